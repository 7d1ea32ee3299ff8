"""One row a log; a bad log is a row too; small causes are counted over the fleet."""

from __future__ import annotations

import os

import numpy as np
import pyarrow.parquet as pq
import pytest

from rcc_sim.batch.batch import run_batch
from rcc_sim.batch.engine import Engine
from rcc_sim.batch.fleet import Fleet, check_row, logs_of, recurring
from rcc_sim.errors import InputError
from rcc_sim.simulate.run import simulate
from rcc_sim.trace import write_trace
from tests.batch.test_runs import DRIVE
from tests.cars import car


@pytest.fixture
def logs(tmp_path, monkeypatch):
    """Write four logs, one of them in millivolts and one no log at all."""
    folder = tmp_path / "logs"
    folder.mkdir()
    from rcc_sim.definitions.cycle import Cycle

    slow = Cycle("slow", DRIVE.time_s, 0.2 * DRIVE.speed_mps)
    trace = simulate(car(), slow).trace
    for name in ("a", "b"):
        with (folder / f"{name}.csv").open("wb") as file:
            write_trace(trace, file)
    bad = {**trace.columns, "yaw_rate_radps": np.full(len(trace), np.nan)}
    with (folder / "c.csv").open("wb") as file:
        write_trace(type(trace)(bad, name="c"), file)
    (folder / "d.csv").write_text("no log\n")
    monkeypatch.chdir(tmp_path)
    return folder


def fleet(names=("logs",), **options):
    """Return the batch that checks some logs."""
    return Fleet("check", check_row, logs_of(names), {"vehicle": None, **options})


def rows(place):
    """Return the rows of a dataset, in order."""
    return pq.read_table(place).to_pylist()


def test_a_log_that_cannot_be_read_is_a_row_with_its_error(logs):
    progress = run_batch(fleet(), logs.parent / "out.parquet")
    found = rows(logs.parent / "out.parquet")
    assert [os.path.basename(row["log"]) for row in found] == [
        f"{name}.csv" for name in "abcd"
    ]
    assert [row["error"] is None for row in found] == [True, True, True, False]
    assert progress.failed == 1
    assert found[0]["duration_s"] == pytest.approx(DRIVE.duration)
    assert "d.csv" in found[3]["error"]


def test_two_processes_give_the_rows_of_one(logs):
    one, two = logs.parent / "one", logs.parent / "two"
    run_batch(fleet(), one)
    run_batch(fleet(), two, Engine(jobs=2))
    assert {p.name: p.read_bytes() for p in one.iterdir()} == {
        p.name: p.read_bytes() for p in two.iterdir()
    }


def test_a_log_that_changed_makes_another_batch(logs):
    run_batch(fleet(), logs.parent / "out")
    with (logs / "a.csv").open("a") as file:
        file.write("\n")
    with pytest.raises(InputError, match="another plan"):
        run_batch(fleet(), logs.parent / "out")


def test_a_finding_that_recurs_is_counted_once_a_log():
    found = [
        {"log": "a", "error": None, "findings": ["dead:x", "dead:x", "unit:y"]},
        {"log": "b", "error": None, "findings": ["dead:x"]},
        {"log": "c", "error": None, "findings": None},
        {"log": "d", "error": "no log"},
    ]
    first, second = recurring(found)
    assert (first["findings"], first["logs"], first["first"]) == ("dead:x", 2, "a")
    assert first["share"] == pytest.approx(2 / 3)
    assert second["logs"] == 1


def test_folders_patterns_and_paths_name_logs_each_once(logs):
    assert logs_of(["logs"]) == logs_of(["logs/*.csv"])
    assert len(logs_of(["logs", "logs/a.csv"])) == 4
    with pytest.raises(InputError, match="no logs there"):
        logs_of(["logs/*.mcap"])
