"""`check`, `gap` and `diagnose` over many logs, as a user meets them."""

import csv
import io
import json

import pyarrow.parquet as pq
import pytest

from rcc_sim.report.fleet_page import fleet_page
from tests.program import rccsim
from tests.report.made import NASTY
from tests.report.test_report_page import Reader


@pytest.fixture(scope="module")
def place(tmp_path_factory):
    """A folder of three drives of 25 s and a file that is no log."""
    from benchmarks.one_car import write

    folder = tmp_path_factory.mktemp("fleet")
    write(folder, 3, effect="rolling_resistance", of=0.015, seconds=25.0, seed=2)
    (folder / "logs" / "zz.csv").write_text("no log\n")
    return folder


def test_a_folder_is_a_fleet_and_gives_a_row_a_log(place):
    done = rccsim("gap", "logs", "--vehicle", "vehicle.toml", cwd=place)
    rows = list(csv.DictReader(io.StringIO(done.stdout)))
    assert done.returncode == 0
    assert [row["error"] == "" for row in rows] == [True, True, True, False]
    assert all(float(row["measured_wh"]) > 0 for row in rows[:3])
    assert "4 logs, 1 failed" in done.stderr
    assert "logs/zz.csv" in done.stderr


def test_a_fleet_without_one_usable_log_fails_once_its_rows_are_told(place):
    done = rccsim("gap", "logs/zz.csv", "gone.csv", "--vehicle", "rcc", cwd=place)
    rows = list(csv.DictReader(io.StringIO(done.stdout)))
    assert done.returncode == 2 and len(rows) == 2
    assert all(row["error"] for row in rows)
    assert "none of the 2 logs" in done.stderr


def test_several_logs_of_gap_are_those_of_gap_on_each(place):
    names = ["logs/0000.csv.gz", "logs/0001.csv.gz"]
    many = rccsim("gap", *names, "--vehicle", "vehicle.toml", "--csv", cwd=place)
    rows = list(csv.DictReader(io.StringIO(many.stdout)))
    for name, row in zip(names, rows, strict=True):
        one = rccsim("gap", name, "--vehicle", "vehicle.toml", "--json", cwd=place)
        energy = json.loads(one.stdout)["energy"]
        assert float(row["gap_wh"]) == pytest.approx(energy["gap_wh"], rel=1e-6)


@pytest.mark.slow
def test_a_cause_too_weak_for_most_logs_is_named_by_all_of_them(tmp_path):
    """Ten drives of one car of the blind plant; most find no gap on their own."""
    from benchmarks.one_car import write

    write(tmp_path, 10, effect="rolling_resistance", of=0.004, seconds=25.0, seed=2)
    args = [
        *("diagnose", "logs/*.csv.gz", "--vehicle", "vehicle.toml", "--json"),
        *("--candidates", "rolling_resistance", "--candidates", "payload"),
        *("-o", "rows.parquet", "--html", "fleet.html", "--jobs", "2"),
    ]
    done = rccsim(*args, cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout)
    rows = pq.read_table(tmp_path / "rows.parquet").to_pylist()
    assert [row["log"] for row in rows] == [f"logs/000{k}.csv.gz" for k in range(10)]
    assert found["schema"] == "rccsim.fleet/1"
    assert found["status"]["no_gap"] >= 5
    assert found["pooled"]["logs"] == 10
    (cause,) = found["pooled"]["causes"]
    assert cause["effect"] == "rolling_resistance"
    assert cause["low"] < 0.004 < cause["high"]
    assert cause["named_alone_in"] < 5
    assert "rolling_resistance" in done.stderr
    assert "logs/0002.csv.gz" in (tmp_path / "fleet.html").read_text()
    before = (tmp_path / "rows.parquet").read_bytes()
    again = rccsim(*args, cwd=tmp_path)
    assert "10 logs (0 now)" in again.stderr
    assert (tmp_path / "rows.parquet").read_bytes() == before
    assert json.loads(again.stdout) == found


@pytest.mark.slow
def test_a_cause_that_each_log_names_is_not_shared_out_among_others(tmp_path):
    (tmp_path / "logs").mkdir()
    for part in ("20:60", "60:100"):
        done = rccsim(
            *("simulate", "rcc", "--cycle", f"udds[{part}]"),
            *("--with", "gear_loss:efficiency=0.9", "-o", f"logs/{part[:2]}.csv"),
            cwd=tmp_path,
        )
        assert done.returncode == 0, done.stderr
    few = ("--candidates", "gear_loss,copper_loss,payload,rolling_resistance")
    asked = ("diagnose", "logs", "--vehicle", "rcc", "--json", *few)
    done = rccsim(*asked, cwd=tmp_path)
    found = json.loads(done.stdout)
    (named,) = found["effects"]
    assert (named["effect"], named["logs"]) == ("gear_loss", 2)
    assert named["median"] == pytest.approx(0.9, abs=0.01)
    assert found["pooled"]["too_strong"] == ["gear_loss"]
    assert found["pooled"]["causes"] == []
    assert "gear_loss named in 2 (efficiency 0.9)" in done.stderr


def test_a_list_from_a_pipe_brings_labels_and_a_model_of_its_own(place):
    lines = ["log,vehicle,car", "logs/0000.csv.gz,,x", "logs/0001.csv.gz,rcc,y"]
    done = rccsim(
        *("gap", "--vehicle", "vehicle.toml", "--list", "-", "--by", "car"),
        *("--json", "-o", "rows.csv"),
        cwd=place,
        stdin="\n".join([*lines, "gone.csv,,y"]),
    )
    found = json.loads(done.stdout)
    assert [row["car"] for row in found["by"]["car"]] == ["x", "y"]
    with (place / "rows.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert [row["car"] for row in rows] == ["x", "y", "y"]
    assert rows[1]["vehicle"] == "rcc"
    assert "gone.csv: cannot be read" in rows[2]["error"]


def test_several_logs_of_diagnose_are_one_explanation_and_each_makes_a_fleet(place):
    done = rccsim("diagnose", "--help", cwd=place)
    assert "--each" in done.stdout
    done = rccsim(
        *("check", "logs/0000.csv.gz", "logs/0001.csv.gz", "--each", "--json"),
        cwd=place,
    )
    assert json.loads(done.stdout)["sound"] == 2


def test_strict_fails_where_a_log_of_the_fleet_is_not_sound(place):
    done = rccsim("check", "logs", "--strict", cwd=place)
    assert done.returncode == 1
    assert "not sound: 1 of 4 logs" in done.stderr


@pytest.mark.parametrize(
    ("args", "said"),
    [
        (("check", "x/*.csv"), "x/*.csv: the pattern matches no logs"),
        (("check",), "no log"),
        (("gap", "logs", "--vehicle", "nope"), "no such vehicle: 'nope'"),
        (("gap", "--vehicle", "rcc", "--list", "nope"), "nope: cannot be read"),
        (("gap", "logs", "--vehicle", "rcc", "--plot", "x.png"), "--plot: belongs to"),
        (("gap", "logs", "--vehicle", "rcc", "--by", "nope"), "nope: no such column"),
        (("gap", "logs", "--vehicle", "rcc", "--map", "nope"), "nope"),
        (("gap", "logs", "--vehicle", "rcc", "--reader", "nope"), "no such reader"),
        (("check", "logs", "--jobs", "2", "--dask", "tcp://x:1"), "give one of them"),
        (("check", "logs/zz.csv", "--jobs", "2"), "belong to a fleet"),
        (("check", "logs/zz.csv", "--html", "x.html"), "belongs to a fleet"),
        (
            ("diagnose", "logs", "--vehicle", "rcc", "--candidates", "nope"),
            "nope: no such effect",
        ),
        (
            ("diagnose", "logs", "--vehicle", "rcc", "--write-vehicle", "x.toml"),
            "--write-vehicle: belongs to a single log",
        ),
    ],
)
def test_a_mistake_is_an_error_before_anything_starts(place, args, said):
    done = rccsim(*args, cwd=place)
    assert done.returncode == 2
    assert said in done.stderr
    assert done.stdout == ""
    assert len(done.stderr.splitlines()) <= 2


@pytest.mark.parametrize("name", ["mode", "log", "error"])
def test_a_label_may_not_bear_the_name_of_a_result(place, name):
    lists = f"log,{name}2,{name}\nlogs/0000.csv.gz,1,2\n"
    done = rccsim("gap", "--vehicle", "rcc", "--list", "-", cwd=place, stdin=lists)
    assert done.returncode == 2
    assert "error: " in done.stderr


def test_the_page_shows_every_name_as_text_and_loads_nothing():
    row = {"log": NASTY, "error": None, "cause": NASTY, "findings": [NASTY]}
    bad = {"log": "b", "error": NASTY}
    found = {
        "command": "gap",
        "logs": 2,
        "failed": 1,
        "failures": [{"error": NASTY, "logs": 1, "first": NASTY}],
        "findings": [{"findings": NASTY, "logs": 1, "share": 1.0, "first": NASTY}],
        "by": {NASTY: [{NASTY: NASTY, "logs": 1, "share": None}]},
    }
    text = fleet_page(found, [row, bad])
    read = Reader(text)
    assert read.open == []
    assert "script" not in read.tags
    assert not {"src", "href", "onclick", "onerror"} & {n for n, _ in read.attributes}
    assert read.text.count(NASTY) >= 4
