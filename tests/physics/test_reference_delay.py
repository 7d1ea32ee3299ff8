"""A late reference is the same drive, later; a steering is as prompt as before."""

import numpy as np
import pytest

from rcc_sim.definitions.cycle import Cycle
from rcc_sim.simulate.run import simulate
from tests.cars import car, truck

TIME = np.array([0.0, 2, 5, 8, 11, 14, 16])
SPEED = np.array([0.0, 0, 4, 4, 1, 0, 0])


def later(delay):
    """Return the drive as the controller hears it: all of it so much later."""
    return Cycle("c", np.append(TIME[:1], TIME[1:] + delay), SPEED)


def sent(vehicle, delay):
    return simulate(vehicle({"reference_delay": {"delay_s": delay}}), DRIVE).trace


DRIVE = Cycle("c", TIME, SPEED)


@pytest.mark.parametrize("vehicle", [car, truck])
@pytest.mark.parametrize("delay", [0.1, 0.1234])
def test_a_late_reference_drives_as_the_same_reference_that_much_later(vehicle, delay):
    late, moved = sent(vehicle, delay), simulate(vehicle({}), later(delay)).trace
    rows = len(late["time_s"])
    for column in ("speed_mps", "motor_torque_nm", "distance_m"):
        want = moved[column][:rows]
        scale = np.abs(want).max()
        assert np.allclose(late[column], want, rtol=0, atol=1e-9 * scale), column


def test_the_log_shows_the_reference_as_it_was_sent():
    late = sent(car, 0.1)
    want = np.interp(late["time_s"], TIME, SPEED)
    assert np.allclose(late["speed_ref_mps"], want, atol=1e-12)


def test_steps_of_a_reference_arrive_as_late():
    steps = {"reference_sampling": {"period_s": 0.5}}
    prompt = simulate(car(steps), DRIVE, output_rate=100).trace
    both = car(steps | {"reference_delay": {"delay_s": 0.1}})
    late = simulate(both, DRIVE, output_rate=100).trace
    rows = round(0.1 / 0.01)
    assert np.allclose(late["speed_mps"][rows:], prompt["speed_mps"][:-rows], atol=1e-9)


def test_a_steering_is_as_prompt_as_before():
    t = np.linspace(0, 16, 1601)
    steer = t, 0.05 * np.sin(2 * t)
    cruise = Cycle("c", np.array([0.0, 16.0]), np.array([4.0, 4.0]))
    prompt = simulate(car({}), cruise, steer=steer).trace
    late = simulate(car({"reference_delay": {"delay_s": 0.2}}), cruise, steer=steer)
    assert np.array_equal(late.trace["yaw_rate_radps"], prompt["yaw_rate_radps"])
