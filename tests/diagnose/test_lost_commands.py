"""Rows at which it is not known what a car was asked for are not held against it."""

import numpy as np
import pytest

from rcc_sim.analyse.gap import gap
from rcc_sim.analyse.logged import Logged
from rcc_sim.definitions.cycle import Cycle
from rcc_sim.definitions.vehicle import load_vehicle
from rcc_sim.diagnose.run import diagnose
from rcc_sim.simulate.drive import FORGOTTEN, drive_of
from rcc_sim.simulate.run import LaneChanges, simulate
from rcc_sim.trace import Trace

CAR = load_vehicle("rcc")
COMMANDS = ("speed_ref_mps", "steer_cmd_rad")
NOISE = {
    "speed_mps": 0.004,
    "yaw_rate_radps": 0.012,
    "accel_y_mps2": 0.2,
    "motor_current_a": 0.1,
    "battery_current_a": 0.05,
    "battery_voltage_v": 0.01,
}
HOLES = [(12.0, 14.5), (30.0, 31.0), (47.0, 49.2)]


@pytest.fixture(scope="module")
def log():
    """A lively drive with a trim of the steering, its commands lost for seconds."""
    rng = np.random.default_rng(2)
    time = np.append(0.0, np.cumsum(rng.uniform(1.5, 3.0, 27)))
    cycle = Cycle("lively", time, np.append(0.0, rng.uniform(1.0, 3.5, 27)))
    true = CAR.changed(effects={"steering_offset": {"angle_rad": 0.012}})
    run = simulate(true, cycle, lanes=LaneChanges(7.0), output_rate=100).trace
    columns = {c: run[c] for c in ("time_s", *COMMANDS)}
    for name, sd in NOISE.items():
        columns[name] = run[name] + rng.normal(0.0, sd, len(run))
    columns["speed_mps"] = np.abs(columns["speed_mps"])
    for name in COMMANDS:
        columns[name] = columns[name].copy()
        for start, end in HOLES:
            columns[name][(run["time_s"] > start) & (run["time_s"] < end)] = np.nan
    return Logged(Trace(columns, name="lost"), (), None)


def test_holes_and_the_time_after_them_are_not_predicted(log):
    unseen, time = drive_of(log.log, CAR).unseen, log.log["time_s"]
    expected = np.zeros(len(time), dtype=bool)
    for start, end in HOLES:
        expected |= (time > start) & (time < end + FORGOTTEN - 0.02)
    assert unseen is not None
    assert np.count_nonzero(unseen != expected) <= 3 * len(HOLES)


def test_what_acts_is_found_and_nothing_for_what_is_not_known(log):
    (one,) = diagnose([log], CAR).asserted
    assert one.cause.effect == "steering_offset"
    assert one.figures["angle_rad"].value == pytest.approx(0.012, abs=5e-4)


def test_no_energy_is_missed_where_nothing_was_asked_for(log):
    straight = {c: x for c, x in log.log.columns.items() if c != "steer_cmd_rad"}
    straight["steer_cmd_rad"] = log.log["steer_cmd_rad"] + 0.012
    found = gap(Logged(Trace(straight, name="known"), (), None), CAR)
    assert found.energy.within
    assert abs(found.energy.gap_percent) < 0.5


def test_a_value_lost_here_and_there_is_bridged(log):
    columns = {c: np.where(np.isnan(x), 0.0, x) for c, x in log.log.columns.items()}
    columns["speed_ref_mps"][::7] = np.nan
    assert drive_of(Trace(columns), CAR).unseen is None
