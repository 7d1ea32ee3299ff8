"""A sensor's offset is a tolerance, unless it was withheld to be found."""

import re

import numpy as np
import pytest

from rcc_sim.analyse.logged import open_log
from rcc_sim.analyse.offsets import noise_at_rest, offset_sd
from rcc_sim.definitions.cycle import Cycle
from rcc_sim.definitions.vehicle import load_vehicle
from rcc_sim.diagnose.fitting.knobs import bias_key, bias_knobs
from rcc_sim.diagnose.residuals.posed import problem_of
from rcc_sim.diagnose.residuals.problem import Problem
from rcc_sim.diagnose.run import diagnose
from rcc_sim.simulate.drive import drive_of
from rcc_sim.simulate.replay import replay
from rcc_sim.simulate.run import LaneChanges, simulate
from rcc_sim.trace import Trace
from tests import scaled_drive

OFFSET = -0.4  # m/s²; less than the noise, so that it would pass as one


def driven(noise):
    """A car by throttle, its accelerometer off and noisy. [m/s²]"""
    rng = np.random.default_rng(8)
    t = np.arange(0, 40, 0.02)
    throttle = np.where(t % 5 < 2.0, 0.26, 0.0)
    blank = np.zeros(len(t))
    car = load_vehicle("dart_jetracer").changed(without=("accelerometer_bias",))
    columns = {"time_s": t, "throttle": throttle, "steer_cmd_rad": blank}
    out = replay(car, drive_of(Trace(columns | {"speed_mps": blank}), car))
    columns["speed_mps"] = np.round(
        out["speed_mps"] + 0.01 * rng.normal(size=len(t)), 3
    )
    shaken = noise * rng.normal(size=len(t))
    columns["accel_x_mps2"] = out["accel_x_mps2"] + OFFSET + shaken
    return car, Trace(columns, name="drive")


@pytest.fixture(scope="module")
def drive():
    return driven(noise=1.0)


def opened(car, log, folder):
    path, rows = folder / "drive.csv", np.column_stack(list(log.columns.values()))
    np.savetxt(path, rows, delimiter=",", header=",".join(log.columns), comments="")
    return open_log(path, car)


def test_how_far_a_sensor_may_be_off():
    """A fifth of its noise; what its zero wanders by; what is stated; else half."""
    car, rows = load_vehicle("rcc"), 20_000
    white = np.random.default_rng(1).normal(size=rows)
    names = (
        *("battery_current_a", "motor_torque_nm", "accel_x_mps2", "yaw_rate_radps"),
        "elevation_m",
    )
    log = Trace(
        {
            "time_s": 0.01 * np.arange(rows),
            **dict.fromkeys(names, 0.3 * white),
            "accel_y_mps2": 1e-3 * white,
        }
    )
    known = {c: offset_sd(log, car, c) for c in log.columns if c != "time_s"}
    assert known.pop("elevation_m") == pytest.approx(0.15, rel=0.05)
    assert known.pop("accel_y_mps2") == 0.02
    assert known == {c: pytest.approx(0.06, rel=0.05) for c in known}
    stated = car.changed(settings={"sensors.accel_x_mps2.bias_sd": 0.5})
    assert offset_sd(log, stated, "accel_x_mps2") == 0.5


def test_meters_of_a_stated_noise_are_off_by_it_however_rough_the_road():
    """The current scatters ten times as much as its meter does, and power with it."""
    rng, t = np.random.default_rng(4), np.arange(0.0, 100.0, 0.02)
    columns = {
        "time_s": t,
        "speed_mps": 3.0 + 0.05 * rng.normal(size=len(t)),
        "battery_voltage_v": 12.0 + 0.02 * rng.normal(size=len(t)),
        "battery_current_a": 2.0 + 0.5 * rng.normal(size=len(t)),
    }
    noise = {"battery_voltage_v": 0.02, "battery_current_a": 0.05}
    settings = {f"sensors.{c}.noise_sd": sd for c, sd in noise.items()}
    key, car = bias_key(0, "battery_power_w"), load_vehicle("rcc")
    stated, guessed = (
        {k.key: k.sd for k in bias_knobs(problem_of(Trace(columns), one))}[key]
        for one in (car.changed(settings=settings), car)
    )
    by_current, by_voltage = 0.2 * 0.05 * 12.0, 0.2 * 0.02 * 2.0
    assert stated == pytest.approx(np.hypot(by_current, by_voltage), rel=0.01)
    assert guessed > 5 * stated


def test_a_meter_shows_its_noise_where_the_car_stands():
    """Its current follows the drive from row to row, but for 60 s in 600."""
    rng, t = np.random.default_rng(2), np.arange(0, 600.0)
    drive = np.where(t % 100 < 10, 0.0, 40 + 30 * np.sin(1.3 * t))
    current = 5.0 + drive + 0.3 * rng.normal(size=len(t))
    log = Trace({"time_s": t, "speed_mps": drive / 4, "battery_current_a": current})
    largest = np.abs(current).max()
    assert noise_at_rest(log, "battery_current_a") == pytest.approx(0.3, rel=0.3)
    sd = offset_sd(log, load_vehicle("bmw_i3"), "battery_current_a")
    assert sd == pytest.approx(max(0.06, 5e-4 * largest), rel=0.3)
    assert (
        noise_at_rest(
            Trace(log.columns | {"speed_mps": 0 * t + 9}), "battery_current_a"
        )
        == np.inf
    )


def test_a_stated_noise_tells_a_meters_offset_in_a_drive_that_hardly_stands():
    rng, t = np.random.default_rng(2), np.arange(0, 600.0)
    current = 40 + 30 * np.sin(1.3 * t) + 0.3 * rng.normal(size=len(t))
    log = Trace({"time_s": t, "speed_mps": current, "battery_current_a": current})
    car = load_vehicle("bmw_i3")
    stated = {"noise_sd": 0.1, "resolution": 0.12}
    sensors = {f"sensors.battery_current_a.{k}": x for k, x in stated.items()}
    knows = car.changed(settings=sensors)
    noise = np.hypot(0.1, 0.12 / np.sqrt(12))
    assert knows.noise_sd("battery_current_a") == pytest.approx(noise)
    most = 5e-4 * np.abs(current).max()
    told = offset_sd(log, knows, "battery_current_a")
    assert told == pytest.approx(max(0.2 * noise, min(most, noise)))
    assert told < 0.1 * offset_sd(log, car, "battery_current_a")


def test_the_offset_of_a_sensor_may_move_unless_it_is_to_be_found(drive):
    car, log = drive
    free = Problem(car, log, drive_of(log, car))
    kept = Problem(car, log, drive_of(log, car), unzeroed=("accel_x_mps2",))
    key = bias_key(0, "accel_x_mps2")
    assert key in {k.key for k in bias_knobs(free)}
    assert key not in {k.key for k in bias_knobs(kept)}


@pytest.mark.slow
def test_a_withheld_offset_is_named_and_passes_as_a_tolerance_otherwise(
    drive, tmp_path
):
    car, log = drive
    log = opened(car, log, tmp_path)
    assert diagnose([log], car).asserted == ()
    found = diagnose([log], car, withheld=["accelerometer_bias"])
    (one,) = found.asserted
    assert one.cause.effect == "accelerometer_bias"
    assert one.figures["x_mps2"].value == pytest.approx(OFFSET, abs=0.08)


@pytest.mark.slow
def test_an_offset_beyond_what_zeroing_leaves_is_named(tmp_path):
    car, log = driven(noise=0.25)
    (one,) = diagnose([opened(car, log, tmp_path)], car).asserted
    assert one.cause.effect == "accelerometer_bias"
    figure = one.figures["x_mps2"]
    assert figure.value == pytest.approx(OFFSET, abs=0.1)
    assert figure.low < OFFSET < figure.high


@pytest.mark.slow
def test_offsets_are_no_noise_that_remembers(tmp_path):
    """In 17 s a memory could take them: a likeness of 0.99 from row to row."""
    car, rng = load_vehicle("f1tenth"), np.random.default_rng(3)
    cycle = Cycle("steps", np.arange(0, 18, 3.0), np.array([0, 2, 3, 1.5, 3, 1.0]))
    run = simulate(car, cycle, lanes=LaneChanges(every=8.0)).trace
    noise = {"speed_mps": 0.003, "motor_current_a": 0.25, "battery_power_w": 0.6}
    noise |= {"yaw_rate_radps": 0.015, "accel_x_mps2": 0.15, "accel_y_mps2": 0.15}
    off = {"yaw_rate_radps": 0.03, "accel_x_mps2": 0.25, "accel_y_mps2": -0.2}
    given = {c: run[c] for c in ("time_s", "speed_ref_mps", "steer_cmd_rad")}
    seen = {
        c: run[c] + off.get(c, 0.0) + sd * rng.normal(size=len(run))
        for c, sd in noise.items()
    }
    log = opened(car, Trace(given | seen, name="moved"), tmp_path)
    found = {
        f"{one.cause.effect}.{name}": figure
        for one in diagnose([log], car).asserted
        for name, figure in one.figures.items()
    }
    true = {
        "yaw_rate_bias.bias_radps": 0.03,
        "accelerometer_bias.x_mps2": 0.25,
        "accelerometer_bias.y_mps2": -0.2,
    }
    assert {k: x.value for k, x in found.items()} == pytest.approx(true, rel=0.05)
    assert all(x.low < true[k] < x.high for k, x in found.items())


def test_a_meter_that_is_off_by_more_than_is_likely_is_told(tmp_path):
    """Five of its stated sds, with no load among the candidates."""
    car = load_vehicle("rcc").changed(
        settings={"sensors.battery_current_a.bias_sd": 0.02}
    )
    run = scaled_drive.drive(car, LaneChanges(10.0))
    read = {"battery_current_a": run["battery_current_a"] - 0.1}
    shown = scaled_drive.logged({**run.columns, **read}, car, 3, tmp_path)
    found = diagnose([shown], car, candidates=("payload",))
    (told,) = [f for f in found.gap.findings if f.kind == "misread"]
    assert told.channel == "battery_power_w"
    volts = float(np.mean(shown.log["battery_voltage_v"]))
    size = float(re.search(r"reads ([0-9.]+) W too little throughout", told.what)[1])
    assert 0.7 < size / (0.1 * volts) < 1.05  # stated figures take the rest
