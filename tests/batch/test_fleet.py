"""One row a log; a bad log is a row too; small causes are counted over the fleet."""

from __future__ import annotations

import io
import json
import os

import numpy as np
import pyarrow.parquet as pq
import pytest

from rcc_sim.batch.batch import run_batch
from rcc_sim.batch.engine import Engine
from rcc_sim.batch.fleet import Fleet, rows_in
from rcc_sim.batch.fleet_logs import Entry, entries_of, is_many, logs_of, read_list
from rcc_sim.batch.fleet_rows import (
    CHECK,
    TEMPERATURE,
    check_row,
    context,
    diagnose_row,
)
from rcc_sim.batch.fleet_summary import recurring, summary
from rcc_sim.definitions import own_effects
from rcc_sim.definitions.cycle import Cycle, parse_cycle
from rcc_sim.definitions.vehicle import load_vehicle
from rcc_sim.diagnose.fleet.pool import unpacked
from rcc_sim.errors import InputError
from rcc_sim.report.fleet_tables import lines, pooled_lines
from rcc_sim.simulate.run import simulate
from rcc_sim.trace import Trace, write_trace
from tests.batch.test_runs import DRIVE
from tests.cars import car
from tests.program import rccsim


@pytest.fixture
def logs(tmp_path, monkeypatch):
    """Write four logs, one of them in millivolts and one no log at all."""
    folder = tmp_path / "logs"
    folder.mkdir()
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


def fleet(names=("logs",), lists=None):
    """Return the batch that checks some logs."""
    return Fleet("check", check_row, entries_of(names, lists), CHECK)


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
    assert str(logs.parent) not in found[3]["error"]


def test_a_log_of_500_rows_a_second_is_pooled_as_it_was_explained(tmp_path):
    slow = Cycle("slow", DRIVE.time_s, 0.2 * DRIVE.speed_mps)
    run = simulate(load_vehicle("rcc"), slow, output_rate=500.0).trace
    noise = np.random.default_rng(3).normal(0, 0.01, len(run))
    log = Trace({**run.columns, "speed_mps": run["speed_mps"] + noise}, name="fast")
    with (tmp_path / "fast.csv").open("wb") as file:
        write_trace(log, file)
    weighed = ("payload", "rolling_resistance")
    row = diagnose_row(
        str(tmp_path / "fast.csv"), {"vehicle": "rcc", "candidates": weighed}
    )
    form = unpacked(row["pool_columns"], row["pool"])
    assert [s.effect for s in form.strengths] == [*weighed]
    assert np.isfinite(form.score).all() and np.all(np.diag(form.information) >= 0)


@pytest.mark.slow
def test_an_effect_that_was_taken_out_may_be_found_in_each_log(tmp_path):
    rng = np.random.default_rng(3)
    true = load_vehicle("r1t_epa")
    cycle = parse_cycle("udds[20:200]")
    trace = simulate(true, cycle, imposed=True, output_rate=10.0).trace
    power = trace["battery_power_w"] + rng.normal(0, 100.0, len(trace))
    log = {"time_s": trace["time_s"], "speed_mps": trace["speed_mps"]}
    with (tmp_path / "a.csv").open("wb") as file:
        write_trace(Trace({**log, "battery_power_w": power}), file)
    options = {"vehicle": "r1t_epa", "withhold": ["road_load"]}
    row = diagnose_row(str(tmp_path / "a.csv"), options)
    assert row["cause"] == "road_load"
    form = unpacked(row["pool_columns"], row["pool"])
    assert "road_load" in {s.effect for s in form.strengths}


def test_logs_that_fail_alike_are_counted_together(logs):
    (logs / "e.csv").write_text("no log\n")
    place = logs.parent / "out.parquet"
    progress = run_batch(fleet(), place)
    (kind,) = progress.failures
    assert progress.failures[kind] == 2
    assert "d.csv" not in kind
    assert summary(rows(place), "check")["failures"] == [
        {"error": kind, "logs": 2, "first": os.path.join("logs", "d.csv")}
    ]


@pytest.mark.parametrize("place", ["out", "out.parquet"])
def test_a_batch_that_goes_on_says_the_same_of_what_failed(logs, place):
    """Which log it was, not the number of its row, and the same words."""
    first = run_batch(fleet(), logs.parent / place)
    again = run_batch(fleet(), logs.parent / place)
    assert first.failures == again.failures
    assert first.log == again.log == {next(iter(first.failures)): "logs/d.csv"}


def test_two_processes_give_the_rows_of_one(logs):
    one, two = logs.parent / "one", logs.parent / "two"
    run_batch(fleet(), one)
    run_batch(fleet(), two, Engine(jobs=2))
    assert {p.name: p.read_bytes() for p in one.iterdir()} == {
        p.name: p.read_bytes() for p in two.iterdir()
    }


def test_the_parts_of_a_folder_are_one_dataset_whatever_each_log_holds(logs):
    run_batch(fleet(), logs.parent / "out")
    assert rows(logs.parent / "out") == list(
        rows_in(logs.parent / "out", fleet().manifest)
    )


def test_a_log_that_changed_makes_another_batch(logs):
    run_batch(fleet(), logs.parent / "out")
    with (logs / "a.csv").open("a") as file:
        file.write("\n")
    with pytest.raises(InputError, match="another plan"):
        run_batch(fleet(), logs.parent / "out")


def test_a_model_that_changed_makes_another_batch(logs, tmp_path):
    model = tmp_path / "car.toml"
    model.write_text('[vehicle]\nextends = "rcc"\nname = "car"\n')
    one = Fleet("check", check_row, (Entry("logs/a.csv"),), CHECK, {}, (str(model),))
    before = one.manifest.digest
    model.write_text(
        '[vehicle]\nextends = "rcc"\nname = "car"\n[body]\nmass_kg = 4.0\n'
    )
    again = Fleet("check", check_row, (Entry("logs/a.csv"),), CHECK, {}, (str(model),))
    assert again.manifest.digest != before


PUDDLE = """
from pathlib import Path
from rcc_sim.physics.effect import Effect, Param

DEPTH = float(Path(__file__).with_name("depth.txt").read_text())

def force(size):
    return DEPTH * size

EFFECT = Effect(
    id="puddle", title="puddle", equation="F", channels=("speed_mps",), seen_as="drag",
    source="own",
    params=(Param("size", neutral=0.0, bounds=(0.0, 9.0), typical=(0.1, 1.0)),),
)
"""


@pytest.mark.parametrize(
    ("file", "before", "after"),
    [
        ("road.csv", "distance_m,slope\n0,0\n9,0\n", "distance_m,slope\n0,1\n9,0\n"),
        ("depth.txt", "0.2", "20"),
        ("map.toml", "[columns]\n", '[columns]\nspeed_mps = "v"\n'),
    ],
)
def test_a_file_behind_the_model_that_changed_makes_another_batch(
    tmp_path, file, before, after
):
    (tmp_path / "puddle.py").write_text(PUDDLE)
    (tmp_path / "depth.txt").write_text("0.2")
    (tmp_path / "road.csv").write_text("distance_m,slope\n0,0\n9,0\n")
    model = tmp_path / "car.toml"
    model.write_text(
        '[vehicle]\nextends = "rcc"\nname = "car"\n[effects]\nfiles = ["puddle.py"]\n'
        'puddle.size = 0.1\nroad_grade = { slope = 0.0, profile = "road.csv" }\n'
    )
    options = {"map": str(tmp_path / "map.toml")}
    digests = set()
    for text in (before, after):
        (tmp_path / file).write_text(text)
        own_effects._of_source.cache_clear()  # as in another process
        logs = (Entry("logs/a.csv"),)
        batch = Fleet("check", check_row, logs, CHECK, options, (str(model),))
        digests.add(batch.manifest.digest)
    assert len(digests) == 2


@pytest.mark.parametrize("name", ["rows.csv", "rows.parquet", "rows"])
def test_what_a_batch_wrote_is_none_of_its_logs(logs, name):
    before = logs_of(["logs"])
    for _ in range(2):
        done = rccsim("check", "logs", "-o", f"logs/{name}", cwd=logs.parent)
        assert done.returncode == 0, done.stderr
        assert "4 logs" in done.stderr
        assert logs_of(["logs"]) == logs_of(["logs/*.csv"]) == before


def test_no_row_goes_over_a_log(logs):
    before = (logs / "a.csv").read_bytes()
    for output in ("logs/a.csv", "logs/../logs/a.csv"):
        done = rccsim("check", "logs", "-o", output, cwd=logs.parent)
        assert done.returncode == 2
        assert "is read here, and would be lost" in done.stderr
    assert (logs / "a.csv").read_bytes() == before


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
    with pytest.raises(InputError, match="matches no logs"):
        logs_of(["logs/*.mcap"])


def test_an_empty_folder_is_an_error_that_names_it(tmp_path):
    with pytest.raises(InputError, match="the folder holds no logs"):
        logs_of([str(tmp_path)])


def test_a_folder_that_is_one_bag_is_one_log(tmp_path):
    bag = tmp_path / "drives" / "first"
    bag.mkdir(parents=True)
    (bag / "metadata.yaml").write_text("x\n")
    (bag / "first_0.db3").write_text("x\n")
    assert logs_of([str(tmp_path / "drives")]) == (str(bag),)
    assert logs_of([str(bag)]) == (str(bag),)
    assert not is_many(str(bag))
    assert is_many(str(tmp_path / "drives"))


def test_a_list_gives_each_log_its_model_and_labels():
    text = "log,vehicle,car,ambient_temperature_degc\na.csv,rcc,x,4\nb.csv,,y,\n"
    first, second = read_list(io.StringIO(text))
    assert first == Entry("a.csv", "rcc", {"car": "x", TEMPERATURE: 4.0})
    assert second == Entry("b.csv", "", {"car": "y"})
    plain = read_list(io.StringIO("a.csv\n\nfolder/b, c.csv\n"))
    assert [entry.log for entry in plain] == ["a.csv", "folder/b, c.csv"]


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "the list is empty"),
        ("log,car\n", "the list is empty"),
        ("log,car\na.csv\n", "line 2: should have a log and 2 cells"),
        ("log,car\n,x\n", "line 2: should have a log"),
        ("log,car,car\na,b,c\n", "line 1: should name each column once"),
    ],
)
def test_a_list_that_is_none_is_an_error_that_names_the_line(text, said):
    with pytest.raises(InputError, match=said):
        read_list(io.StringIO(text))


def test_a_missing_log_of_a_list_is_a_row(logs):
    lists = io.StringIO("log,car\nlogs/a.csv,x\nlogs/gone.csv,y\n")
    run_batch(fleet((), lists), logs.parent / "out")
    good, gone = rows(logs.parent / "out")
    assert (good["error"], good["car"]) == (None, "x")
    assert "gone.csv: cannot be read" in gone["error"]
    assert gone["car"] == "y"


def test_a_log_tells_its_day_and_weather_where_it_holds_them():
    t = 1_767_225_600.0 + np.arange(20.0)  # 2026-01-01T00:00:00Z
    trace = Trace(
        {
            "time_s": t,
            "speed_mps": t - t[0],
            TEMPERATURE: np.full(20, 6.5),
            "tyre_pressure_pa": np.full(20, 2.1e5),
        }
    )
    told = context(trace)
    assert (told["date"], told[TEMPERATURE]) == ("2026-01-01", 6.5)
    assert told["constants"] == '{"tyre_pressure_pa": 210000.0}'


def test_a_log_of_dates_is_filed_by_its_date(tmp_path):
    log = tmp_path / "trip.csv"
    stamps = (f"2025-03-01T23:{k:02d}:00.5Z,{k % 7}" for k in range(30))
    log.write_text("\n".join(["when,v", *stamps]))
    by = tmp_path / "map.toml"
    by.write_text(
        '[map]\n[columns]\ntime_s = { from = "when", unit = "date" }\nspeed_mps = "v"\n'
    )
    row = check_row(str(log), {"map": str(by)})
    assert row["date"] == "2025-03-01"
    milliseconds = Trace({"time_s": 1.7e12 + np.arange(3.0), "speed_mps": np.ones(3)})
    assert "date" not in context(milliseconds)


def row(**known):
    """Return a row of `gap`."""
    base = {"error": None, "vehicle": "v", "measured_wh": 10.0, "simulated_wh": 9.0}
    base |= {"gap_wh": 1.0, "gap_percent": 10.0, "within": False, "findings": []}
    return {"log": "l", **base, **known}


def test_energies_at_the_battery_and_at_the_shaft_are_not_one_sum():
    rows = [row(at=at) for at in ("shaft", "battery", "battery")]
    found = summary(rows, "gap")
    energy = {k: found["energy"][k] for k in ("at", "logs", "elsewhere", "measured_wh")}
    assert energy == {"at": "battery", "logs": 2, "elsewhere": 1, "measured_wh": 20.0}
    assert "measured at the battery (1 log elsewhere);" in " ".join(lines(found))
    even = summary(rows[:2], "gap")["energy"]
    assert (even["at"], even["logs"]) == ("battery", 1)


def test_a_summary_sums_energies_and_gathers_by_class():
    more = {"simulated_wh": 8.0, "gap_wh": 2.0, "gap_percent": 20.0}
    found = summary(
        [
            row(**{TEMPERATURE: 1.0}),
            row(**{TEMPERATURE: 4.0, **more}),
            row(**{TEMPERATURE: -3.0, "within": True}),
            row(error="no log"),
        ],
        "gap",
    )
    assert (found["logs"], found["failed"]) == (4, 1)
    assert found["energy"]["gap_percent"] == pytest.approx(100 * 4 / 30)
    assert found["energy"]["within"] == 1
    assert [(c[TEMPERATURE], c["logs"]) for c in found["by"][TEMPERATURE]] == [
        ("-5 to 0", 1),
        ("0 to 5", 2),
    ]
    assert found["by"]["vehicle"][0]["logs"] == 3


def test_the_gap_of_a_fleet_that_recuperates_has_the_sign_of_its_logs():
    given = {"measured_wh": -1.0, "simulated_wh": -2.0, "gap_wh": 1.0}
    found = summary([row(**given, gap_percent=100.0)], "gap")["energy"]
    assert found["gap_percent"] == found["gap_percent_median"] == 100.0


def named(effect, *tied):
    """Return the columns of a log that names an effect which others tie with."""
    one = {"effect": effect, "indistinguishable_from": list(tied)}
    return {"status": "explained", "causes": [effect], "causes_json": json.dumps([one])}


def test_logs_that_name_one_of_a_tie_each_name_one_cause():
    ties = [("rubs", "rolls"), ("rubs", "rolls", "iron"), ("rubs", "rolls")]
    rows = [row(**named(*tie)) for tie in [*ties, ("rolls", "rubs")]]
    found = summary(rows, "diagnose")
    assert found["pooled"]["too_strong"] == ["rubs"]
    told = {e["effect"]: e["indistinguishable_from"] for e in found["effects"]}
    assert told == {"rubs": ["rolls"], "rolls": ["rubs"]}
    assert "rubs (or rolls: these logs cannot tell) is too strong" in lines(found)[-1]


def test_a_cause_that_too_few_logs_name_or_tie_with_is_none_of_all():
    rows = [row(**named("rubs", "rolls")) for _ in range(3)]
    rows += [row(**named("drag")), row(**named("drag", "rolls"))]
    assert summary(rows, "diagnose")["pooled"]["too_strong"] == []
    assert lines(summary(rows, "diagnose"))[-1] == "together, 0 logs: no cause"


def test_what_is_enough_and_yet_no_cause_is_not_told_as_the_most():
    def told(nats):
        ranking = [{"effect": "payload", "nats": nats}]
        return pooled_lines({"causes": [], "logs": 3, "ranking": ranking}, [])

    assert told(11.6) == ["together, 3 logs: no cause (the most: payload, 11.6 nats)"]
    assert told(17.5) == ["together, 3 logs: no cause"]
