"""A run says what went beyond the vehicle's means; angles in degrees are refused."""

import numpy as np
import pytest

from rcc_sim.definitions.cycle import Cycle
from rcc_sim.errors import InputError
from rcc_sim.simulate.run import LaneChanges, simulate
from tests.cars import car

CRUISE = Cycle("c", np.array([0.0, 4.0, 20.0]), np.array([0.0, 5.0, 5.0]))
FAST = Cycle("c", np.array([0.0, 10.0, 30.0]), np.array([0.0, 30.0, 30.0]))


def said(run, word):
    return any(word in note for note in run.notes)


def test_a_drive_within_means_says_nothing():
    assert simulate(car(), CRUISE).notes == ()


def test_the_battery_s_voltage_bounds_the_speed():
    """No current is left where N_p/2 λ ω reaches u_0 / √3."""
    resistive = {"copper_loss": {"phase_resistance_ohm": 0.02}}
    run = simulate(car(resistive), FAST)
    top = 12.0 / np.sqrt(3) / (2 * 0.887e-3)
    assert run.trace["motor_speed_radps"].max() == pytest.approx(top, rel=0.01)
    assert said(run, "voltage")


def test_the_motor_s_speed_limit_bounds_the_speed():
    run = simulate(car(motor__max_speed_radps=1000.0), FAST)
    assert run.trace["motor_speed_radps"][-1] == pytest.approx(1000.0, rel=0.02)
    assert said(run, "speed limit")


def test_a_car_without_brakes_that_runs_on_says_so():
    stop = Cycle("c", np.array([0.0, 2.0, 2.5, 9.0]), np.array([0.0, 6.0, 0.0, 0.0]))
    no_brakes = {
        "regeneration_limit": {"max_current_a": 0.0},
        "rolling_resistance": {"coefficient": 0.02},
    }
    assert said(simulate(car(no_brakes), stop), "over the reference")


def test_cornering_beyond_grip_is_said():
    grippy = car(tyres__friction_coefficient=0.3)
    hard = LaneChanges(8.0, width=1.5, length=4.0)
    assert said(simulate(grippy, CRUISE, lanes=hard), "tyre_saturation")
    bounded = car(
        {"tyre_saturation": {"friction_coefficient": 0.3}},
        tyres__friction_coefficient=0.3,
    )
    assert not said(simulate(bounded, CRUISE, lanes=hard), "tyre_saturation")


def test_steering_in_degrees_is_refused():
    with pytest.raises(InputError, match="row 2") as caught:
        simulate(car(), CRUISE, steer=([0.0, 20.0], [0.0, 15.0]))
    assert "0.2618" in caught.value.hint


def test_the_road_wheels_stop_at_the_largest_angle():
    held, free = (
        simulate(
            car(controller__max_steer_rad=limit), CRUISE, steer=([0, 20], [0.4, 0.4])
        )
        for limit in (0.1, 0.4)
    )
    narrow, wide = (abs(run.trace["yaw_rate_radps"][-1]) for run in (held, free))
    assert narrow < 0.5 * wide


@pytest.mark.parametrize("speed", [2.0, 5.0, 10.0])
def test_the_follower_keeps_to_its_lanes_at_any_speed(speed):
    cycle = Cycle("c", np.array([0.0, 1e-6, 160 / speed]), np.full(3, speed))
    run = simulate(car(), cycle, lanes=LaneChanges(20.0, width=0.33)).trace
    assert run["y_m"].max() < 0.33 * 1.06
    assert run["y_m"].min() > -0.33 * 0.06
    assert run["y_m"].max() > 0.33 * 0.97


def test_a_cycle_too_coarse_for_its_lane_changes_says_so():
    lanes = LaneChanges(10.0)
    coarse = Cycle("c", np.arange(0, 40.0, 1.0), np.full(40, 5.0))
    assert said(simulate(car(), coarse, lanes=lanes, imposed=True), "too few")
    fine = Cycle("c", np.arange(0, 40.0, 0.05), np.full(800, 5.0))
    assert not said(simulate(car(), fine, lanes=lanes, imposed=True), "too few")
