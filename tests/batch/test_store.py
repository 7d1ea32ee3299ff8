"""Parts that are whole or not there; a place that holds one plan."""

from __future__ import annotations

import errno
import os
import sys

import pyarrow
import pyarrow.parquet as pq
import pytest

from rcc_sim.batch.batch import run_batch
from rcc_sim.batch.engine import Engine
from rcc_sim.batch.store import LOCK, Manifest, Store
from rcc_sim.errors import InputError


def squares(setup, part):
    """Return the squares of some numbers."""
    return [n * n for n in part]


class Squares:
    """A batch that needs no vehicle: n, its square, and an error at each 10th."""

    work = staticmethod(squares)
    setup = None

    def __init__(self, rows=95, part=10, about="squares"):
        self.manifest = Manifest("d" + about, rows, part, {"command": about})
        self.done = []

    def prepared(self, start, stop):
        return list(range(start, stop)), start

    def table(self, start, kept, result):
        assert kept == start
        self.done.append(start)
        errors = ["tenth" if n % 10 == 0 else None for n in range(len(result))]
        return pyarrow.table(
            {
                "run": list(range(start, start + len(result))),
                "square": result,
                "error": pyarrow.array(errors, pyarrow.string()),
            }
        )


def contents(folder):
    """Return the bytes of every file of a folder."""
    return {path.name: path.read_bytes() for path in folder.iterdir()}


@pytest.fixture
def whole(tmp_path):
    """Return what an undisturbed run leaves."""
    run_batch(Squares(), tmp_path / "whole")
    return contents(tmp_path / "whole")


def test_a_dataset_holds_every_row_once_and_says_what_failed(tmp_path):
    progress = run_batch(Squares(), tmp_path / "out")
    rows = pq.read_table(tmp_path / "out").to_pylist()
    assert [(r["run"], r["square"]) for r in rows] == [(n, n * n) for n in range(95)]
    assert (progress.total, progress.done, progress.failed) == (95, 95, 10)
    assert progress.first == {"tenth": 0}


@pytest.mark.parametrize("moment", range(12))
@pytest.mark.parametrize("where", ["before", "after"])
def test_a_kill_before_or_after_any_rename_loses_and_doubles_nothing(
    tmp_path, monkeypatch, whole, moment, where
):
    real, count = os.replace, [0]

    def replace(source, target):
        count[0] += 1
        if count[0] <= moment:
            return real(source, target)
        if where == "after":
            real(source, target)
        raise SystemExit  # nothing of ours catches it

    monkeypatch.setattr(os, "replace", replace)
    if moment < 11:  # a manifest and ten parts
        with pytest.raises(SystemExit):
            run_batch(Squares(), tmp_path / "out")
    monkeypatch.setattr(os, "replace", real)
    again = Squares()
    progress = run_batch(again, tmp_path / "out")
    assert contents(tmp_path / "out") == whole
    assert len(again.done) == 10 + -progress.before // 10
    assert (progress.done, progress.failed) == (95, 10)


def test_what_a_power_cut_left_without_its_end_is_done_again(tmp_path, whole):
    run_batch(Squares(), tmp_path / "out")
    part = tmp_path / "out" / "part-000003.parquet"
    part.write_bytes(part.read_bytes()[:100])
    (tmp_path / "out" / "part-000004.parquet").write_bytes(b"")
    (tmp_path / "out" / ".tmp-1-part-000005.parquet").write_bytes(b"half")
    run_batch(Squares(), tmp_path / "out")
    assert contents(tmp_path / "out") == whole


def test_a_full_disk_is_said_and_what_is_done_stays(tmp_path, monkeypatch, whole):
    real, count = os.fsync, [0]

    def fsync(number):
        count[0] += 1
        if count[0] > 8:
            raise OSError(errno.ENOSPC, "No space left on device")
        return real(number)

    monkeypatch.setattr(os, "fsync", fsync)
    with pytest.raises(InputError, match="No space left") as raised:
        run_batch(Squares(), tmp_path / "out")
    assert "the same command goes on" in raised.value.hint
    monkeypatch.setattr(os, "fsync", real)
    left = contents(tmp_path / "out")
    assert left.keys() < whole.keys()
    assert all(whole[name] == left[name] for name in left)
    run_batch(Squares(), tmp_path / "out")
    assert contents(tmp_path / "out") == whole


def test_a_single_file_has_the_same_rows_and_nothing_is_left_beside_it(tmp_path):
    run_batch(Squares(), tmp_path / "out.parquet")
    run_batch(Squares(), tmp_path / "folder")
    assert [p.name for p in tmp_path.glob("out*")] == ["out.parquet"]
    one, many = (pq.read_table(tmp_path / name) for name in ("out.parquet", "folder"))
    assert one.equals(many)
    again = Squares()
    progress = run_batch(again, tmp_path / "out.parquet")
    assert (again.done, progress.before, progress.failed) == ([], 95, 10)


def test_parts_whose_columns_differ_become_one_file(tmp_path):
    class Ragged(Squares):
        def table(self, start, kept, result):
            whole = super().table(start, kept, result)
            return whole if start < 40 else whole.append_column("more", whole["run"])

    run_batch(Ragged(), tmp_path / "out.parquet")
    rows = pq.read_table(tmp_path / "out.parquet").to_pylist()
    assert [r["more"] for r in rows] == [None] * 40 + list(range(40, 95))


def test_another_plan_in_the_same_place_is_an_error_that_says_in_what(tmp_path):
    for place in (tmp_path / "out", tmp_path / "out.parquet"):
        run_batch(Squares(), place)
        with pytest.raises(InputError, match="command squares, now cubes"):
            run_batch(Squares(about="cubes"), place)
        with pytest.raises(InputError, match="rows 95, now 96"):
            run_batch(Squares(rows=96), place)


def test_a_folder_of_something_else_is_left_alone(tmp_path):
    (tmp_path / "thesis.tex").write_text("all of it")
    with pytest.raises(InputError, match="holds other files"):
        run_batch(Squares(), tmp_path)
    (tmp_path / "log.parquet").write_text("no parquet")
    with pytest.raises(InputError, match="no rows of rccsim"):
        run_batch(Squares(), tmp_path / "log.parquet")
    assert {p.name for p in tmp_path.iterdir()} == {"thesis.tex", "log.parquet"}
    with pytest.raises(InputError, match="cannot be written"):
        run_batch(Squares(), tmp_path / "no" / "folder")


def test_two_at_once_in_one_place_are_one_too_many(tmp_path):
    manifest = Squares().manifest
    at_work = Store(tmp_path / "out", manifest).opened()
    with at_work, pytest.raises(InputError, match="another rccsim is at work"):
        run_batch(Squares(), tmp_path / "out")
    assert run_batch(Squares(), tmp_path / "out").done == 95


@pytest.mark.skipif(sys.platform == "win32", reason="no lock there")
def test_a_lock_that_was_taken_away_as_it_was_opened_is_none(tmp_path, monkeypatch):
    import fcntl

    manifest, late = Squares().manifest, []
    real = fcntl.flock

    def slow(file, how):  # between opening and locking another process ended
        if not late:
            late.append(file)
            (tmp_path / "out" / LOCK).unlink()
        real(file, how)

    monkeypatch.setattr(fcntl, "flock", slow)
    at_work = Store(tmp_path / "out", manifest).opened()
    with at_work, pytest.raises(InputError, match="another rccsim is at work"):
        run_batch(Squares(), tmp_path / "out")


def test_what_never_began_leaves_no_folder(tmp_path):
    with pytest.raises(InputError, match="--jobs 0"):
        run_batch(Squares(), tmp_path / "out", Engine(jobs=0))
    assert list(tmp_path.iterdir()) == []
