"""What stands is held by its brakes, whatever it did before."""

import numpy as np
import pytest

from rcc_sim.definitions.cycle import Cycle
from rcc_sim.definitions.vehicle import load_vehicle
from rcc_sim.simulate.run import simulate

TIME = np.array([0.0, 1, 4, 6, 9, 12, 16, 20])


@pytest.mark.parametrize("name", ["r1t", "bmw_i3", "twizy"])
@pytest.mark.parametrize("angle", [0.0, 0.1, -0.2])
def test_a_motor_gives_nothing_at_standstill(name, angle):
    """Also where the car still yaws, and comes nearer and nearer to standing."""
    car = load_vehicle(name)
    speed = np.array([0.0, 0, 5, 5, 0, 0, 4, 0])
    steer = TIME, angle * np.array([0.0, 0, 1, 1, 1, 1, -1, -1])
    run = simulate(car, Cycle("stops", TIME, speed), steer=steer, output_rate=50).trace
    still = np.convolve(run["speed_mps"] > 1e-3, np.ones(5), "same") == 0
    assert still.sum() > 50
    assert np.abs(run["motor_torque_nm"][still]).max() == 0.0
