"""Of a long hole nothing is said; what is read in turn, or rarely, is used."""

from dataclasses import replace

import numpy as np
import pytest

from rcc_sim.analyse.gap import gap
from rcc_sim.analyse.logged import open_log
from rcc_sim.definitions.cycle import parse_cycle
from rcc_sim.definitions.vehicle import load_vehicle
from rcc_sim.simulate.drive import drive_of
from rcc_sim.simulate.holes import in_holes
from rcc_sim.simulate.replay import replay
from rcc_sim.trace import Trace

CAR = load_vehicle("tesla_model_3")


def drive(rate: float = 10.0) -> dict:
    """A town drive as its model sees it."""
    cycle = parse_cycle("udds[0:300]")
    time = np.arange(0.0, 300.0, 1 / rate)
    speed = np.interp(time, cycle.time_s, cycle.speed_mps)
    log = Trace({"time_s": time, "speed_mps": speed}, name="log")
    exact = replay(CAR, drive_of(log, CAR, 1 / rate))
    rng = np.random.default_rng(1)
    volts = exact["battery_voltage_v"] + rng.normal(0, 0.1, len(time))
    current = {"battery_current_a": exact["battery_current_a"]}
    return log.columns | {"battery_voltage_v": volts} | current


def gap_of(log: dict, folder):
    path, table = folder / "log.csv", np.column_stack(list(log.values()))
    head = ",".join(log)
    np.savetxt(path, table, fmt="%.9g", delimiter=",", header=head, comments="")
    return gap(open_log(path, CAR), CAR)


def test_energy_is_counted_where_speed_is_known_alone(tmp_path):
    log = drive()
    time, lost = log["time_s"], slice(1600, 2250)  # from one stop to the next but one
    power = log["battery_voltage_v"] * log["battery_current_a"]
    energy = 0.5 * (power[1:] + power[:-1]) * np.diff(time) / 3600
    outside = np.delete(energy, np.arange(lost.start - 1, lost.stop))
    log["speed_mps"][lost] = np.nan
    found = gap_of(log, tmp_path).energy
    assert found.measured_wh == pytest.approx(outside.sum(), rel=0.01)
    assert abs(found.gap_percent) < 0.5
    assert outside.sum() < 0.8 * energy.sum()


def test_some_lost_rows_are_bridged(tmp_path):
    log = drive()
    before = gap_of(log, tmp_path).energy.measured_wh
    log["speed_mps"][np.random.default_rng(3).random(3000) < 0.1] = np.nan
    found = gap_of(log, tmp_path).energy
    assert found.measured_wh == pytest.approx(before, rel=1e-3)
    assert abs(found.gap_percent) < 1.0


def test_a_hole_is_longer_than_five_readings_and_may_be_at_either_end():
    time = np.arange(20.0)
    known = np.ones(20, dtype=bool)
    assert in_holes(time, known) is None
    known[5:9] = False  # five seconds from reading to reading
    assert in_holes(time, known) is None
    known[5:10] = False
    assert np.flatnonzero(in_holes(time, known)).tolist() == [5, 6, 7, 8, 9]
    known[:] = True
    known[:2] = known[-1] = False
    assert np.flatnonzero(in_holes(time, known)).tolist() == [0, 1, 19]


def test_readings_rarer_than_rows_are_no_holes():
    time = np.arange(1000) / 1000
    known = np.arange(1000) % 10 == 0
    assert in_holes(time[:991], known[:991]) is None


def test_channels_that_are_read_in_turn_give_the_energy(tmp_path):
    log = drive(30.0)
    whole = gap_of(log, tmp_path).energy
    for turn, c in enumerate(("speed_mps", "battery_voltage_v", "battery_current_a")):
        log[c][np.arange(len(log[c])) % 3 != turn] = np.nan
    found = gap_of(log, tmp_path).energy
    assert found.measured_wh == pytest.approx(whole.measured_wh, rel=0.005)
    assert abs(found.gap_percent) < 0.5


def test_a_power_that_is_read_once_a_second_is_compared_there(tmp_path):
    log = drive()
    whole = gap_of(log, tmp_path).energy
    for c in ("battery_voltage_v", "battery_current_a"):
        # off the cycle's corners, at whole seconds, where a power leaps
        log[c][np.arange(len(log[c])) % 10 != 5] = np.nan
    found = gap_of(log, tmp_path).energy
    assert found.measured_wh == pytest.approx(whole.measured_wh, rel=0.05)
    assert abs(found.gap_percent) < 0.5


def test_one_lost_voltage_leaves_an_uncertainty(tmp_path):
    log = drive()
    whole = gap_of(log, tmp_path).energy
    log["battery_voltage_v"][1000] = np.nan
    found = gap_of(log, tmp_path).energy
    assert found.u_val == pytest.approx(whole.u_val, rel=0.05)
    assert not replace(found, noise_wh=np.nan, simulated_wh=0.0).within
