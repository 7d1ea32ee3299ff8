"""A log of 10 rows a second, between which a steering turns: no tyre relaxes."""

import numpy as np
import pytest

from rcc_sim.analyse.logged import Logged
from rcc_sim.definitions.cycle import parse_cycle
from rcc_sim.definitions.vehicle import load_vehicle
from rcc_sim.diagnose.run import diagnose
from rcc_sim.simulate.run import LaneChanges, simulate
from rcc_sim.trace import Trace

NOISE = {
    "speed_mps": 0.01,
    "yaw_rate_radps": 0.02,
    "accel_x_mps2": 0.15,
    "accel_y_mps2": 0.15,
    "motor_current_a": 0.2,
    "battery_current_a": 0.05,
    "battery_voltage_v": 0.01,
}


@pytest.mark.slow
def test_a_clean_drive_of_seldom_rows_has_no_cause():
    car, rng = load_vehicle("rcc"), np.random.default_rng(5)
    lanes, cycle = LaneChanges(20.0), parse_cycle("udds[20:125]")
    run = simulate(car, cycle, lanes=lanes, output_rate=10.0).trace
    columns = {c: run[c] for c in ("time_s", "speed_ref_mps", "steer_cmd_rad")}
    for name, sd in NOISE.items():
        columns[name] = run[name] + rng.normal(0, sd, len(run))
    found = diagnose([Logged(Trace(columns, name="10 Hz"), (), None)], car)
    assert found.asserted == ()
    assert found.status == "no_gap"
