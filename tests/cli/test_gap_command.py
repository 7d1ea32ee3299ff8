"""`rccsim gap` as a user meets it: JSON, CSV, pictures, pipes, mistakes."""

import json
from pathlib import Path

import numpy as np
import pytest
from scipy.interpolate import RegularGridInterpolator

from rcc_sim.analyse.gap import gap
from rcc_sim.analyse.logged import open_log
from rcc_sim.definitions.kernel import efficiency_map
from rcc_sim.definitions.vehicle import load_vehicle
from tests.program import rccsim

CASES = Path(__file__).resolve().parents[3] / "shared" / "cases"
BMW = Path(__file__).resolve().parents[3] / "shared/data/real_ev/bmw_i3_tum"


@pytest.fixture(scope="module")
def drive(tmp_path_factory):
    path = tmp_path_factory.mktemp("gap") / "drive.csv"
    done = rccsim(
        *("simulate", "rcc", "--cycle", "udds[20:60]", "--output", path),
        *("--with", "rolling_resistance:coefficient=0.03"),
    )
    assert done.returncode == 0, done.stderr
    return path


def test_the_way_back_meets_the_slope_from_the_other_side(tmp_path):
    back, car = tmp_path / "back.csv", tmp_path / "car.toml"
    downhill = ("--with", "road_grade:slope=-0.02", "--output", back)
    assert not rccsim("simulate", "rcc", "--cycle", "udds[20:40]", *downhill).returncode
    car.write_text(
        '[vehicle]\nname = "car"\nextends = "rcc"\n[effects.road_grade]\nslope = 0.02\n'
    )
    asked = ("gap", back, "--vehicle", car, "--json", "--hide", "slope")
    out, home = (
        json.loads(rccsim(*asked, "--hide", "elevation_m", *way).stdout)["energy"]
        for way in ((), ("--back",))
    )
    assert out["gap_percent"] < -10
    assert abs(home["gap_percent"]) < 1e-3


def test_a_span_of_a_log_is_the_log_cut_there(drive, tmp_path):
    rows = drive.read_text().splitlines()
    cut = [r for r in rows[1:] if 10.0 <= float(r.split(",")[0]) <= 30.0]
    (tmp_path / "cut.csv").write_text("\n".join([rows[0], *cut]) + "\n")
    asked = ("--vehicle", "rcc", "--json")
    whole = json.loads(rccsim("gap", drive, *asked, "--span", "10:30").stdout)
    alone = json.loads(rccsim("gap", tmp_path / "cut.csv", *asked).stdout)
    assert whole["energy"] == alone["energy"]
    assert whole["channels"] == alone["channels"]


@pytest.mark.parametrize(
    ("span", "told"),
    [
        ("5", "FROM:TO"),
        ("a:b", "FROM:TO"),
        ("9:5", "ends before it begins"),
        ("900:", "its clock runs from 0 to 40"),
    ],
)
def test_a_span_that_is_none_is_told(drive, span, told):
    done = rccsim("gap", drive, "--vehicle", "rcc", "--span", span)
    assert done.returncode == 2 and done.stdout == ""
    assert told in done.stderr


def test_json_holds_where_the_gap_sits(drive):
    done = rccsim("gap", drive, "--vehicle", "rcc", "--json")
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout)
    assert found["mode"] == "commanded"
    energy = found["energy"]
    assert energy["gap_wh"] == pytest.approx(
        energy["measured_wh"] - energy["simulated_wh"]
    )
    assert energy["gap_percent"] == pytest.approx(
        100 * energy["gap_wh"] / energy["measured_wh"]
    )
    assert energy["gap_wh"] > 0
    for part in ("regimes", "stages"):
        total = sum(row["gap_wh"] for row in found[part])
        assert total == pytest.approx(energy["gap_wh"])
    for row in found["channels"]:
        assert {"channel", "rmse", "bias", "noise", "score"} <= set(row)
    for row in found["windows"]:
        assert row["start_s"] < row["end_s"]


def test_a_pipe_gets_csv_and_the_verdict_goes_to_stderr(drive):
    done = rccsim("gap", "-", "--vehicle", "rcc", stdin=drive.read_text())
    assert done.returncode == 0, done.stderr
    assert done.stdout.splitlines()[0] == "part,name,figure,value"
    assert "gap" in done.stderr and "u_val" in done.stderr


def test_stages_of_a_log_without_its_speed_here_and_there_are_numbers(drive, tmp_path):
    lines = drive.read_text().splitlines()
    at = lines[0].split(",").index("speed_mps")
    for row in range(500, 520):
        cells = lines[row].split(",")
        cells[at] = "n/a"
        lines[row] = ",".join(cells)
    log = tmp_path / "holes.csv"
    log.write_text("\n".join(lines) + "\n")
    found = json.loads(rccsim("gap", log, "--vehicle", "rcc", "--json").stdout)
    stages = [row["gap_wh"] for row in found["stages"]]
    assert sum(stages) == pytest.approx(found["energy"]["gap_wh"])


def test_a_log_without_its_steering_turns_as_its_gyro_shows(drive, tmp_path):
    lines = [line.split(",") for line in drive.read_text().splitlines()]
    at, yaw = map(lines[0].index, ("steer_cmd_rad", "yaw_rate_radps"))
    for cells in lines[500:520]:  # a sway, and no turn
        cells[yaw] = "0.01"
    log = tmp_path / "straight.csv"
    log.write_text("".join(",".join(c[:at] + c[at + 1 :]) + "\n" for c in lines))
    told = "no steering is told: the model turns as yaw_rate_radps shows"
    assert told in rccsim("gap", log, "--vehicle", "rcc").stderr
    assert told not in rccsim("gap", drive, "--vehicle", "rcc").stderr


def test_the_tables_of_a_terminal_can_be_piped_and_written(drive, tmp_path):
    out = tmp_path / "gap.txt"
    piped = rccsim("gap", drive, "--vehicle", "rcc", "--text").stdout
    rccsim("gap", drive, "--vehicle", "rcc", "--text", "-o", out)
    verdict, *_ = piped.splitlines()
    assert "measured" in verdict and "u_val" in verdict and "By channel" in piped
    assert out.read_text() == piped
    both = rccsim("gap", drive, "--vehicle", "rcc", "--text", "--json")
    assert both.returncode == 2
    assert both.stderr.startswith("error: --text and --json: one of them")


def test_a_plot_is_drawn(drive, tmp_path):
    picture = tmp_path / "gap.svg"
    done = rccsim("gap", drive, "--vehicle", "rcc", "--plot", picture, "--json")
    assert done.returncode == 0, done.stderr
    assert "measured" in picture.read_text()


def test_a_hidden_channel_is_not_compared(drive):
    done = rccsim(
        *("gap", drive, "--vehicle", "rcc", "--json"), "--hide", "yaw_rate_radps"
    )
    channels = [c["channel"] for c in json.loads(done.stdout)["channels"]]
    assert "yaw_rate_radps" not in channels
    assert "speed_mps" in channels


@pytest.mark.parametrize(
    ("text", "word"),
    [
        ("", "empty"),
        ("time_s,speed_mps\n0,1\n", "row"),
        ("time_s,wind\n" + "".join(f"{k},1\n" for k in range(40)), "predicts"),
        ("time_s,speed_mps\n" + "".join(f"{k},nan\n" for k in range(40)), "blank"),
    ],
)
def test_what_is_no_log_is_one_line_and_exit_2(tmp_path, text, word):
    path = tmp_path / "bad.csv"
    path.write_text(text)
    done = rccsim("gap", path, "--vehicle", "rcc", "--json")
    assert done.returncode == 2
    assert done.stdout == ""
    assert done.stderr.startswith("error: ")
    assert word in done.stderr


def test_an_unknown_hidden_column_is_an_error(drive):
    done = rccsim("gap", drive, "--vehicle", "rcc", "--hide", "yawrate")
    assert done.returncode == 2
    assert "yawrate" in done.stderr


@pytest.mark.skipif(not BMW.is_dir(), reason="the BMW logs are not here")
@pytest.mark.parametrize(
    "trip", ["TripA01", pytest.param("TripB03", marks=pytest.mark.thorough)]
)
def test_the_electrical_stage_is_battery_less_logged_torque_and_known_loads(trip):
    """By hand: P = τ ω / η driving, τ ω η braking, and the auxiliaries; η by scipy."""
    done = rccsim("gap", BMW / f"{trip}.csv.gz", "--vehicle", "bmw_i3", "--json")
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout)
    stages = {row["stage"]: row["gap_wh"] for row in found["stages"]}
    assert set(stages) == {"mechanical", "electrical"}
    assert sum(stages.values()) == pytest.approx(found["energy"]["gap_wh"])
    car = load_vehicle("bmw_i3")
    log = open_log(BMW / f"{trip}.csv.gz", car).log
    gear = car.drivetrain.gear_ratio.value / car.tyres.radius_m.value
    torque, speed = log["motor_torque_nm"], log["speed_mps"] * gear
    shaft = torque * speed
    *grid, table = efficiency_map(car)
    at = [np.clip(x, 0, g[-1]) for x, g in zip((abs(torque), speed), grid, strict=True)]
    eta = RegularGridInterpolator(tuple(grid), table)(np.nan_to_num(np.array(at)).T)
    eta *= car.effects["motor_efficiency"]["scale"].value
    model = np.where(shaft > 0, shaft / eta, shaft * eta) + log["aux_power_w"]
    model += car.effects["auxiliary_load"]["power_w"].value
    left = log["battery_voltage_v"] * log["battery_current_a"] - model
    by_hand = np.nansum(left * np.gradient(log["time_s"])) / 3600
    measured = found["energy"]["measured_wh"]
    assert stages["electrical"] == pytest.approx(by_hand, abs=0.005 * measured)


@pytest.mark.slow
@pytest.mark.skipif(not CASES.is_dir(), reason="the withheld cases are not here")
@pytest.mark.parametrize(
    "drive_name", ["log", pytest.param("fresh", marks=pytest.mark.thorough)]
)
def test_drives_of_nothing_but_tolerances_are_within_their_uncertainty(drive_name):
    truth = json.loads((CASES / "labels.json").read_text())
    nulls = [case for case, label in truth.items() if label["kind"] == "null"]
    beyond = []
    for case in nulls:
        where = CASES / case
        car = load_vehicle(where / "vehicle.toml")
        if not gap(open_log(where / f"{drive_name}.csv.gz", car), car).energy.within:
            beyond.append(case)
    assert len(beyond) <= 0.05 * len(nulls) + 1
