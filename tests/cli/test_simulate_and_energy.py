"""`simulate` and `energy` as a user meets them: pipes, files, mistakes."""

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from tests.program import rccsim

CYCLE = "time_s,speed_mps\n0,0\n2,3\n5,3\n7,0\n9,0\n"


def failed(done, *words):
    lines = done.stderr.splitlines()
    assert done.returncode == 2, done.stderr
    assert sum(line.startswith("error: ") for line in lines) == 1
    assert "Traceback" not in done.stderr
    assert not done.stdout
    for word in words:
        assert word in done.stderr, done.stderr


@pytest.fixture
def cycle(tmp_path):
    path = tmp_path / "c.csv"
    path.write_text(CYCLE)
    return path


def test_a_pipe_from_cycle_to_energy_closes_its_ledger():
    trace = rccsim("simulate", "rcc", "--cycle", "-", stdin=CYCLE)
    report = json.loads(rccsim("energy", "-", "--json", stdin=trace.stdout).stdout)
    assert abs(report["residual"]) < 1e-6
    assert sum(report["ledger"].values()) == pytest.approx(report["energy_wh"])
    assert report["wh_per_km"] == pytest.approx(
        1000 * report["energy_wh"] / report["distance_m"]
    )
    regimes = sum(r["energy_wh"] for r in report["regimes"])
    assert regimes == pytest.approx(report["energy_wh"])


def test_the_same_inputs_give_the_same_bytes(cycle):
    runs = [rccsim("simulate", "rcc", "--cycle", cycle).stdout for _ in range(2)]
    assert runs[0] == runs[1]


@pytest.mark.parametrize("suffix", ["csv", "csv.gz", "parquet"])
def test_a_trace_written_is_read_back(cycle, tmp_path, suffix):
    out = tmp_path / f"t.{suffix}"
    rccsim("simulate", "rcc", "--cycle", cycle, "-o", out)
    report = json.loads(rccsim("energy", out, "--json").stdout)
    assert report["energy_wh"] > 0


def test_traces_are_compared_with_the_first(cycle, tmp_path):
    a, b = tmp_path / "a.csv", tmp_path / "b.csv"
    rccsim("simulate", "rcc", "--cycle", cycle, "-o", a)
    heavy = ["--with", "rolling_resistance:coefficient=0.05"]
    rccsim("simulate", "rcc", "--cycle", cycle, *heavy, "-o", b)
    document = json.loads(rccsim("energy", a, b, "--vehicle", "rcc", "--json").stdout)
    against = document["against_first"][0]
    assert against["wh_per_km_percent"] > 1
    assert against["ledger_wh_per_km"]["rolling_resistance"] > 0
    assert document["runs"][0]["range_km"] > document["runs"][1]["range_km"]


def test_energy_at_another_size_goes_with_the_scales(cycle, tmp_path):
    a = tmp_path / "a.csv"
    rccsim("simulate", "rcc", "--cycle", cycle, "-o", a)
    own = json.loads(rccsim("energy", a, "--json").stdout)
    options = ["--from", "rcc", "--to", "r1t", "--json"]
    large = json.loads(rccsim("energy", a, *options).stdout)
    assert large["wh_per_km"] / own["wh_per_km"] == pytest.approx(40700 / 90)


@pytest.mark.parametrize(("suffix", "other"), [("png", "svg"), ("pdf", "pdf")])
def test_plots_are_drawn(cycle, tmp_path, suffix, other):
    picture = tmp_path / f"p.{suffix}"
    done = rccsim("simulate", "rcc", "--cycle", cycle, "--plot", picture)
    assert done.returncode == 0
    assert picture.stat().st_size > 5000
    again = tmp_path / f"e.{other}"
    assert rccsim("energy", "-", "--plot", again, stdin=done.stdout).returncode == 0
    assert again.stat().st_size > 5000


def test_overrides_act(cycle):
    heavier = rccsim("simulate", "rcc", "--cycle", cycle, "--set", "body.mass_kg=4.5")
    plain = rccsim("simulate", "rcc", "--cycle", cycle)
    assert heavier.stdout != plain.stdout
    free = rccsim(
        "simulate", "rcc", "--cycle", cycle, "--without", "drivetrain_damping"
    )
    assert "energy_drivetrain_damping_j" not in free.stdout.partition("\n")[0]


def test_a_surveyed_road_and_a_logged_load_are_driven(cycle, tmp_path):
    flat = json.loads(rccsim("simulate", "r1t", "--cycle", cycle, "--json").stdout)
    road, load = tmp_path / "road.csv", tmp_path / "load.csv"
    road.write_text("distance_m,elevation_m\n0,0\n100,5\n")
    load.write_text("time_s,aux_power_w\n0,1000\n9,1000\n")
    words = ("--road-log", road, "--aux-log", load, "--json")
    done = rccsim("simulate", "r1t", "--cycle", cycle, *words)
    hilly = json.loads(done.stdout)
    climb = 3152 * 9.80665 * 0.05 * hilly["distance_m"] / 3600
    assert hilly["ledger"]["road_grade"] == pytest.approx(climb, rel=1e-3)
    assert hilly["ledger"]["auxiliary_load"] == pytest.approx(1000 * 9 / 3600, rel=1e-3)
    assert hilly["energy_wh"] > flat["energy_wh"] + climb
    done = rccsim("simulate", "r1t", "--cycle", cycle, "--road-log", load)
    failed(done, "distance_m")


def test_a_road_steeper_than_any_is_refused_by_its_row(cycle, tmp_path):
    road = tmp_path / "road.csv"
    road.write_text("distance_m,elevation_m\n0,0\n1,0\n1.1,0.2\n40,0.2\n")
    done = rccsim("simulate", "r1t", "--cycle", cycle, "--road-log", road)
    failed(done, "elevation_m, row 3: +0.2 m in 0.1 m")


def test_what_a_cycle_file_holds_beside_its_speeds_is_told_unless_followed(tmp_path):
    run = tmp_path / "run.csv"
    run.write_text("time_s,speed_mps,steer_cmd_rad\n0,0,0\n2,3,0.1\n9,0,0.1\n")
    done = rccsim("simulate", "rcc", "--cycle", run)
    assert "steer_cmd_rad is not followed; --steer-log" in done.stderr
    for words in (["--steer-log", run], ["--lane-change-every", "3"]):
        done = rccsim("simulate", "rcc", "--cycle", run, *words)
        assert "not followed" not in done.stderr


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--set", "body.mas_kg=3"], ["body.mas_kg", "mass_kg"]),
        (["--set", "mass_kg=3"], ["mass_kg", "body.mass_kg"]),
        (["--set", "body.mass_kg=heavy"], ["body.mass_kg", "number"]),
        (["--set", "body.mass_kg"], ["KEY=VALUE"]),
        (["--set", "body.mass_kg=-3"], ["error: --set body.mass_kg=-3: should be"]),
        (["--set", "body.mass=4"], ["no such key", "did you mean `body.mass_kg`?"]),
        (["--with", "gear_loss=0.9"], ["did you mean `gear_loss:efficiency=0.9`?"]),
        (["--with", "gear_loss.efficiency=0.9"], ["`gear_loss:efficiency=0.9`?"]),
        (["--with", "rolling_resistance:coefficient=7"], ["error: --with rolling_"]),
        (["--with", "rolling_resistanc:coefficient=1"], ["rolling_resistance"]),
        (["--with", "rolling_resistance"], ["coefficient"]),
        (["--with", "rolling_resistance:coefficient"], ["ID:PARAM=VALUE"]),
        (["--with", "rolling_resistance:coeff=0.1"], ["--with", "coefficient"]),
        (["--with", "road_load:a_n=1,b_n_s_per_m=0,c_n_s2_per_m2=0"], ["damping"]),
        (["--without", "rolling_resistance"], ["does not have"]),
        (["--lane-change-every", "-3"], ["positive"]),
        (["--lane-change-every", "3", "--lane-change-length", "9"], ["9"]),
        (["--lane-width", "3"], ["--lane-change-every"]),
        (["--output-rate", "333"], ["loop"]),
        (["--steer-log", "nowhere.csv"], ["nowhere.csv"]),
        (["--plot", "p.jpeg"], ["p.jpeg", "png"]),
        (["-o", "no/such/folder/t.csv"], ["no/such/folder"]),
        (["--substeps", "0"], ["substeps"]),
    ],
)
def test_a_mistake_is_one_line_with_its_mend(cycle, options, words):
    failed(rccsim("simulate", "rcc", "--cycle", cycle, *options), *words)


def test_a_vehicle_without_the_table_that_a_run_needs_says_which(cycle, tmp_path):
    path = tmp_path / "bare.toml"
    path.write_text(
        '[vehicle]\nname = "bare"\n[body]\nmass_kg = 3.78\nyaw_inertia_kgm2 = 0.0382\n'
        "cg_to_front_axle_m = 0.15876\ncg_to_rear_axle_m = 0.16523\n[tyres]\n"
        "radius_m = 0.049\nfront_cornering_stiffness_n_per_rad = 90\n"
        "rear_cornering_stiffness_n_per_rad = 90\n[drivetrain]\ngear_ratio = 11.82\n"
    )
    failed(rccsim("simulate", path, "--cycle", cycle), "[controller]", "--imposed")
    assert rccsim("simulate", path, "--cycle", cycle, "--imposed").returncode == 0


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="no /dev/full here")
def test_a_full_disk_is_an_error(cycle):
    done = rccsim("simulate", "rcc", "--cycle", cycle, "-o", "/dev/full")
    failed(done, "/dev/full")
    with open("/dev/full", "w") as full:
        command = [sys.executable, "-m", "rcc_sim", "simulate", "rcc", "--cycle", cycle]
        done = subprocess.run(
            command, stdout=full, stderr=subprocess.PIPE, text=True, timeout=120
        )
    assert done.returncode == 2
    assert "Traceback" not in done.stderr


def test_a_failed_write_leaves_the_old_file_and_no_other(cycle, tmp_path):
    out = tmp_path / "t.csv"
    out.write_text("old")
    rccsim("simulate", "rcc", "--cycle", cycle, "-o", out, "--output-rate", "333")
    assert out.read_text() == "old"
    assert sorted(p.name for p in tmp_path.iterdir()) == ["c.csv", "t.csv"]


def test_an_interrupt_is_130_and_leaves_nothing(tmp_path):
    command = [sys.executable, "-m", "rcc_sim", "simulate", "rcc", "--cycle", "udds*20"]
    process = subprocess.Popen(
        [*command, "-o", str(tmp_path / "t.csv")], stderr=subprocess.PIPE, text=True
    )
    time.sleep(2.0)
    process.send_signal(signal.SIGINT)
    _, said = process.communicate(timeout=120)
    if process.returncode == 0:
        pytest.skip("the run was over before the interrupt")
    assert process.returncode == 130
    assert "Traceback" not in said
    assert os.listdir(tmp_path) == []


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", ["empty"]),
        ("time_s,speed_mps\n", ["no rows"]),
        ("a,b\n1,2\n", ["time_s"]),
        ("time_s,battery_power_w\n0,1\n0,1\n", ["row 2", "increase"]),
        (
            "time_s,battery_power_w,speed_mps\n0,1,1\n1,x,1\n",
            ["battery_power_w", "row 2"],
        ),
        ("time_s,battery_power_w,speed_mps\n0,1,1\n1,,1\n", ["row 2", "missing"]),
        ("time_s,speed_mps\n0,1\n1,2\n", ["battery_power_w"]),
        ("time_s,speed_mps\n0,1\n1,2,3\n", ["CSV"]),
    ],
)
def test_a_trace_that_is_none_is_an_error_that_says_why(text, words):
    failed(rccsim("energy", "-", stdin=text), *words)


def test_a_run_that_could_not_be_written_or_would_overwrite_is_not_begun(tmp_path):
    steps = tmp_path / "steps.csv"
    steps.write_text("time_s,steer_cmd_rad\n0,0\n100,0\n")
    drive = ("simulate", "rcc", "--cycle", "udds*40")
    nowhere = str(tmp_path / "nowhere" / "t.csv")
    failed(rccsim(*drive, "-o", nowhere), "--output", "no folder")
    log = str(steps)
    failed(rccsim(*drive, "--steer-log", log, "-o", log), "--output", "lost")
    assert steps.read_text().startswith("time_s,steer_cmd_rad")


def test_a_ledger_that_lost_a_column_fails_the_check(cycle):
    rows = rccsim("simulate", "rcc", "--cycle", cycle).stdout.splitlines()
    gone = rows[0].split(",").index("energy_drivetrain_damping_j")
    cut = "\n".join(
        ",".join(c for k, c in enumerate(row.split(",")) if k != gone) for row in rows
    )
    done = rccsim("energy", "-", stdin=cut)
    assert done.returncode == 1
    assert "does not close" in done.stderr


def test_a_measured_trace_without_a_ledger_is_integrated():
    text = (
        "time_s,speed_mps,battery_voltage_v,battery_current_a\n0,2,10,1\n3600,2,10,1\n"
    )
    report = json.loads(rccsim("energy", "-", "--json", stdin=text).stdout)
    assert report["energy_wh"] == pytest.approx(10.0)
    assert report["wh_per_km"] == pytest.approx(10 / 7.2)
    assert report["ledger"] == {} and report["residual"] is None
    assert "ledger" not in rccsim("energy", "-", stdin=text).stdout


def test_a_log_by_other_names_is_read_by_its_map(tmp_path):
    log, by = tmp_path / "log.csv", tmp_path / "map.toml"
    log.write_text("t;v [km/h];U;I\n0;7.2;10;-1\n3600;7.2;10;-1\n")
    lines = {
        "time_s": '"t"',
        "speed_mps": '"v [km/h]", unit = "km/h"',
        "battery_voltage_v": '"U"',
        "battery_current_a": '"I", sign = -1',
    }
    columns = "\n".join(f"{c} = {{ from = {x} }}" for c, x in lines.items())
    by.write_text(f'[map]\nseparator = ";"\n[columns]\n{columns}\n')
    report = json.loads(rccsim("energy", str(log), "--map", str(by), "--json").stdout)
    assert report["energy_wh"] == pytest.approx(10.0)
    assert report["wh_per_km"] == pytest.approx(10 / 7.2)


def test_a_log_of_another_make_is_told_how_to_be_read(tmp_path):
    log = tmp_path / "log.csv"
    log.write_bytes("time_s;Temperature [°C]\n0;20\n1;20\n".encode("latin-1"))
    failed(rccsim("energy", str(log)), "UTF-8", "rccsim convert")
    failed(rccsim("simulate", "bmw_i3", "--cycle", str(log)), "UTF-8", "convert")
