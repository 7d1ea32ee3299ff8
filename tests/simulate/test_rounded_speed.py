"""A speed in whole km/h, or a row a second, asks for what the drive took."""

import numpy as np
import pytest

from rcc_sim.analyse.gap import gap
from rcc_sim.analyse.logged import open_log
from rcc_sim.channel import is_coarse, resolution, rounded_to
from rcc_sim.definitions.cycle import parse_cycle
from rcc_sim.definitions.vehicle import load_vehicle
from rcc_sim.simulate.drive import drive_of
from rcc_sim.simulate.replay import replay
from rcc_sim.simulate.smooth import smoothed
from rcc_sim.trace import Trace

CAR = load_vehicle("tesla_model_3")
KMH = 1 / 3.6


def energy_gap(log: Trace, folder) -> float:
    """The gap [%] of a log that is written to a file."""
    table = np.column_stack(list(log.columns.values()))
    head, path = ",".join(log.columns), folder / "log.csv"
    np.savetxt(path, table, fmt="%.7g", delimiter=",", header=head, comments="")
    found = gap(open_log(path, CAR), CAR).energy.gap_percent
    assert found is not None
    return found


def driven(rate: float, step: float, noise: float = 0.01) -> Trace:
    """A town drive whose flows are samples, its speed rounded to a step."""
    cycle = parse_cycle("udds[0:400]")
    time = np.arange(0.0, 400.0, 0.01)
    # the cycle's corners are no driver's: their mean over a second is
    width = 101
    ends = np.interp(time, cycle.time_s, cycle.speed_mps)
    speed = np.convolve(np.pad(ends, width // 2), np.ones(width) / width, "valid")
    motion = {"time_s": time, "speed_mps": speed}
    fine = Trace(motion, name="fine")
    exact = replay(CAR, drive_of(fine, CAR))
    rows = slice(None, None, round(100 / rate))
    seen = speed + np.random.default_rng(4).normal(0, noise, len(speed))
    seen = np.maximum(np.round(seen / step) * step, 0.0)
    log = {c: exact[c][rows] for c in ("battery_voltage_v", "battery_current_a")}
    log = {"time_s": time[rows], "speed_mps": seen[rows]} | log
    return Trace(log, name="log")


@pytest.mark.parametrize(
    ("rate", "step"), [(20.0, KMH), (10.0, KMH), (5.0, KMH), (10.0, 0.5 * KMH)]
)
def test_the_energy_by_a_rounded_speed_is_the_drive_s(tmp_path, rate, step):
    log = driven(rate, step)
    assert rounded_to(log["speed_mps"]) == pytest.approx(step)
    assert abs(energy_gap(log, tmp_path)) < 1.0


@pytest.mark.parametrize("rate", [1.0, 2.0])
def test_the_energy_by_a_row_a_second_is_the_drive_s(tmp_path, rate):
    log = driven(rate, 1e-6, noise=0.0)
    assert rounded_to(log["speed_mps"]) == 0.0
    assert abs(energy_gap(log, tmp_path)) < 1.0


def test_a_rounded_speed_is_known_where_it_passes_from_step_to_step():
    t = np.arange(0, 60, 0.1)
    true = 12 - 12 * np.cos(2 * np.pi * t / 60)
    seen = np.round(true / KMH) * KMH
    found, accel, _ = smoothed(t, seen)
    inner = slice(20, -20)
    slope = np.gradient(true, t)
    assert np.std((found - true)[inner]) < 0.5 * np.std((seen - true)[inner])
    assert np.std((accel - slope)[inner]) < 0.1 * np.std(slope)
    assert np.std((np.gradient(seen, t) - slope)[inner]) > 0.5 * np.std(slope)


@pytest.mark.parametrize("step", [0.001, 0.01])
def test_digits_of_a_file_are_no_rounding(step):
    t = np.arange(0, 60, 0.1)
    speed = np.round(np.minimum(1.5 * t, 20.0) / step) * step
    assert rounded_to(speed) == 0.0


@pytest.mark.parametrize("rate", [5.0, 10.0, 20.0])
@pytest.mark.parametrize("digits", [3, 5, 12])
def test_a_speed_of_tenths_of_a_kmh_asks_for_the_acceleration_that_there_was(
    rate, digits
):
    """What its steps add to the acceleration would lighten the car by their square."""
    log = driven(rate, 0.1 * KMH, noise=0.003)
    fine = driven(rate, 1e-9, noise=0.0)["speed_mps"]
    time, seen = log["time_s"], np.round(log["speed_mps"], digits)
    step = resolution(seen)
    assert step == pytest.approx(0.1 * KMH, rel=0.01)
    under_way = fine[1:] > 0.5
    known = np.diff(smoothed(time, seen).speed)[under_way]
    true, raw = np.diff(fine)[under_way], np.diff(seen)[under_way]
    assert true @ known / (known @ known) == pytest.approx(1.0, abs=0.005)
    lightened = 1 - true @ raw / (raw @ raw)
    assert lightened == pytest.approx(step**2 / 6 / np.mean(raw**2), rel=0.3)


@pytest.mark.parametrize("name", ["udds", "us06", "hwfet", "nycc", "wltc_3b"])
def test_the_rounding_of_a_schedule_is_too_little_to_smooth(name):
    cycle = parse_cycle(name)
    assert not is_coarse(cycle.speed_mps)
    assert np.array_equal(smoothed(cycle.time_s, cycle.speed_mps)[0], cycle.speed_mps)


def test_only_what_is_rounded_has_a_resolution():
    rng = np.random.default_rng(5)
    t = np.arange(0, 100, 0.1)
    wave = 10 + 5 * np.sin(t)
    noisy = wave + rng.normal(0, 0.2, len(t))
    assert resolution(wave) == resolution(noisy) == resolution(0 * t) == 0.0
    assert resolution(t[:3]) == 0.0
    gone = np.where(rng.random(len(t)) < 0.1, np.nan, np.round(noisy, 1))
    assert resolution(gone) == pytest.approx(0.1)


def test_a_car_that_stands_takes_its_auxiliaries_and_no_more():
    """What smoothing leaves of a speed there would creep, and creeping takes torque."""
    log = driven(5.0, 0.1 * KMH, noise=0.003)
    nil = log["speed_mps"] == 0
    stands = nil[:-3] & nil[1:-2] & nil[2:-1] & nil[3:]
    assert stands.sum() > 100
    found = replay(CAR, drive_of(log, CAR))
    power = found["battery_power_w"][2:-1][stands]
    load = CAR.effects["auxiliary_load"]["power_w"].value
    assert np.abs(found["motor_torque_nm"][2:-1][stands]).max() == 0.0
    assert power == pytest.approx(load, rel=0.01)
