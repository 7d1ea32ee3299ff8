"""What dies away is over in the end: no state is a number too small to be normal."""

import numpy as np
import pytest

from rcc_sim.definitions.cycle import Cycle
from rcc_sim.definitions.vehicle import load_vehicle
from rcc_sim.physics.effects.steering_lag import caught_up, lagged
from rcc_sim.simulate.run import simulate

NORMAL = np.finfo(float).tiny
"""The smallest number with all of its digits."""


@pytest.mark.parametrize("share", [0.002, 0.1, 0.43, 0.9])
def test_a_lag_arrives(share):
    value, ticks = 1.0, 0
    while value != 0.0:
        value, ticks = lagged(value, 0.0, share), ticks + 1
        assert value == 0.0 or value >= NORMAL
        assert ticks < 1000 / share


@pytest.mark.parametrize("angle", [0.0, 0.1], ids=["straight", "wheels_turned"])
def test_a_turn_ends(angle):
    """A turn, then half a minute at rest, the motor's lag as short as a tick or two."""
    lag = {"motor_lag": {"time_constant_s": 0.00175}}
    car = load_vehicle("rcc").changed(effects=lag)
    assert caught_up(0.001, 0.00175) < 0.5
    cycle = Cycle(
        "stop", np.array([0.0, 1.0, 4.0, 5.0, 35.0]), np.array([0, 2, 2, 0, 0])
    )
    steer = np.array([0.0, 2.0, 2.5, 5.0, 35.0]), np.array([0, 0, 0.1, angle, angle])
    run = simulate(car, cycle, steer=steer, output_rate=100.0).trace
    for name in ("yaw_rate_radps", "accel_y_mps2", "motor_torque_nm"):
        x = np.abs(run[name])
        assert x.max() > 0
        assert not np.any((x > 0) & (x < NORMAL)), name
    if not angle:
        assert run["yaw_rate_radps"][-1] == 0.0
