"""`sweep`, `sensitivity` and `--draws` from the shell."""

from __future__ import annotations

import json

import pyarrow.parquet as pq
import pytest

from tests.test_house import run

QUICK = ["r1t_epa", "--cycle", "udds[20:60]", "--imposed"]


def test_a_sweep_writes_a_row_a_run_and_says_so(tmp_path):
    grid = ["--set", "body.mass_kg=3000:3400:100", "--set", "lanes.every=none,50"]
    done = run("sweep", *QUICK, *grid, "-o", "out.parquet", "--json", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout)["runs"] == 10
    rows = pq.read_table(tmp_path / "out.parquet").to_pylist()
    assert [row["body.mass_kg"] for row in rows[::2]] == [3000, 3100, 3200, 3300, 3400]
    heavier = [row["energy_road_load_wh"] for row in rows[::2]]
    assert max(heavier) == min(heavier)  # a road load does not know the mass
    again = run("sweep", *QUICK, *grid, "-o", "out.parquet", cwd=tmp_path)
    assert "all 10 runs were there already" in again.stderr


def test_a_folder_is_not_called_as_a_table_is(tmp_path):
    done = run("sweep", *QUICK, "--draw", "2", "-o", "out.csv", cwd=tmp_path)
    assert done.returncode == 2
    assert "out.parquet for one file, out for a folder" in done.stderr
    assert not (tmp_path / "out.csv").exists()


def test_draws_are_the_same_at_each_point_of_the_grid(tmp_path):
    options = ["--draw", "20", "--method", "sobol", "--seed", "3"]
    grid = ["--set", "lanes.every=none,50"]
    done = run("sweep", *QUICK, *options, *grid, "-o", "out", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    table = pq.read_table(tmp_path / "out").to_pandas()
    without, with_lanes = table[:20], table[20:]
    key = "effects.motor_efficiency.scale"
    assert (without[key].to_numpy() == with_lanes[key].to_numpy()).all()
    assert (without.wh_per_km.to_numpy() < with_lanes.wh_per_km.to_numpy()).all()


def test_failures_are_rows_and_are_summed_up(tmp_path):
    (tmp_path / "d.csv").write_text("body.mass_kg\n3100\n-5\n3200\n")
    done = run("sweep", *QUICK, "--draws-file", "d.csv", "-o", "out", cwd=tmp_path)
    assert done.returncode == 0
    assert "warning: 1 of 3 runs failed" in done.stderr
    assert "first: 1" in done.stderr
    rows = pq.read_table(tmp_path / "out").to_pylist()
    assert [row["error"] is None for row in rows] == [True, False, True]


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ([], "nothing to sweep"),
        (["--set", "body.mas_kg=1,2"], "body.mas_kg: no such key"),
        (["--set", "effects.gearloss.efficiency=1"], "no such key"),
        (["--set", "body.mass_kg=5:3:1"], "an empty grid"),
        (["--set", "body.mass_kg=heavy"], "should be a number"),
        (["--draw", "5", "--draws-file", "d.csv"], "give one of them"),
        (["--draw", "5", "--method", "dice"], "no such method"),
        (["--draw", "0"], "should be at least 1"),
        (["--set", "lanes.every=1:1e4:1", "--draw", "100000000"], "too many"),
        (["--set", "body.mass_kg=3e3", "-j", "2", "--dask", "x"], "give one of them"),
        (["--draws-file", "none.csv"], "cannot be read"),
        (["--set", "lanes.every=9", "--lane-change-length", "50"], "lane change"),
    ],
    ids=lambda value: value if isinstance(value, str) else None,
)
def test_what_cannot_be_swept_is_one_error_line_and_leaves_nothing(
    options, words, tmp_path
):
    done = run("sweep", *QUICK, *options, "-o", "out", cwd=tmp_path)
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.startswith("error: ")
    assert words in done.stderr
    assert len(done.stderr.splitlines()) <= 2
    assert not (tmp_path / "out").exists()


def test_rows_too_far_apart_for_lane_changes_are_warned_of(tmp_path):
    grid = ["--set", "lanes.every=none,50"]
    done = run("sweep", *QUICK, *grid, "-o", "out", cwd=tmp_path)
    assert "too few for lane changes" in done.stderr


def test_sensitivity_prints_an_index_a_key(tmp_path):
    pytest.importorskip("SALib")
    done = run("sensitivity", *QUICK, "--samples", "64", "--json", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    rows = json.loads(done.stdout)["indices"]
    assert rows[0]["key"] == "effects.motor_efficiency.scale"
    totals = [row["total"] for row in rows]
    assert totals == sorted(totals, reverse=True)


def test_intervals_stand_beside_every_figure_of_a_run(tmp_path):
    done = run(
        "simulate", *QUICK, "--draws", "50", "-o", "t.csv", "--json", cwd=tmp_path
    )
    assert done.returncode == 0, done.stderr
    figures = json.loads(done.stdout)["figures"]
    for name in ("energy_wh", "wh_per_km", "energy_road_load_wh"):
        assert figures[name]["low"] < figures[name]["value"] < figures[name]["high"]
    draws = ["--vehicle", "r1t_epa", "--draws", "50", "--json"]
    done = run("energy", "t.csv", *draws, cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    whole = json.loads(done.stdout)
    found = whole["draws"]["figures"]
    assert found["energy_wh"]["value"] == pytest.approx(whole["energy_wh"])
    assert found["range_km"]["low"] < found["range_km"]["high"]
    alone = run("energy", "t.csv", "--draws", "50", cwd=tmp_path)
    assert (alone.returncode, alone.stdout) == (2, "")
