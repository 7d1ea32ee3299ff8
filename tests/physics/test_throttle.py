"""A car driven by throttle, and what stands between a command and the wheels."""

import numpy as np
import pytest

from rcc_sim.definitions.cycle import Cycle
from rcc_sim.errors import InputError
from rcc_sim.simulate.run import simulate
from tests.cars import car

T = np.array([0.0, 1.0, 1.001, 6.0])
DRIVE = Cycle("d", T, np.zeros(4))
STEP = (T, np.array([0.0, 0.0, 0.5, 0.5]))
TABLE = {
    "controller__mode": "throttle",
    "controller__force_throttle": [0.0, 1.0],
    "controller__force_speed_mps": [0.0, 5.0],
    "controller__force_n": [[0.0, 0.0], [20.0, 0.0]],
}
DRAG = {"aerodynamic_drag": {"drag_area_m2": 0.05}}


def test_a_throttle_step_follows_its_closed_form():
    """F = 20 u (1 - v/5): m dv/dt = 10 - 2 v, from t = 1 s on."""
    run = simulate(car(**TABLE), DRIVE, throttle=STEP).trace
    t = run["time_s"]
    closed = 5.0 * (1 - np.exp(-2 / 3.78 * np.maximum(t - 1.0005, 0)))
    assert np.abs(run["speed_mps"] - closed).max() < 5e-3


def test_a_dead_zone_of_the_throttle_swallows_what_is_below_it():
    dead = car({"throttle_dead_zone": {"threshold": 0.6}}, **TABLE)
    assert simulate(dead, DRIVE, throttle=STEP).trace["distance_m"][-1] == 0.0
    live = car({"throttle_dead_zone": {"threshold": 0.4}}, **TABLE)
    assert simulate(live, DRIVE, throttle=STEP).trace["distance_m"][-1] > 1.0


def test_a_throttle_that_gives_more_pushes_in_proportion():
    """F = 1.5 x 20 u (1 - v/5): m dv/dt = 15 - 3 v."""
    more = car({"throttle_gain": {"gain": 1.5}}, **TABLE)
    run = simulate(more, DRIVE, throttle=STEP).trace
    t = run["time_s"]
    closed = 5.0 * (1 - np.exp(-3 / 3.78 * np.maximum(t - 1.0005, 0)))
    assert np.abs(run["speed_mps"] - closed).max() < 5e-3


def test_a_road_load_with_a_negative_part_never_pushes():
    """A fit to low speeds, 2 + 1 v - 1 v², is 0 from 2 m/s on."""
    load = {"road_load": {"a_n": 2.0, "b_n_s_per_m": 1.0, "c_n_s2_per_m2": -1.0}}
    push = (T, np.array([1.0, 1.0, 0.0, 0.0]))
    run = simulate(car(load, **TABLE), DRIVE, throttle=push).trace
    coasts = run["speed_mps"][run["time_s"] > 1.1]
    assert coasts[0] > 2.5
    assert np.ptp(coasts) == 0.0


def test_friction_brakes_do_what_the_motor_may_not():
    """-20 N in all: the motor brakes with 0.05 N m at n = 241/m, 12.06 N of them."""
    table = TABLE | {
        "controller__force_throttle": [-1.0, 1.0],
        "controller__force_n": [[-20.0, -20.0], [20.0, 20.0]],
    }
    push = (T, np.array([1.0, 1.0, -1.0, -1.0]))
    free = simulate(car(**table), DRIVE, throttle=push)
    limited = car({"regeneration_limit": {"max_torque_nm": 0.05}}, **table)
    bounded = simulate(limited, DRIVE, throttle=push)
    np.testing.assert_allclose(
        bounded.trace["speed_mps"], free.trace["speed_mps"], atol=1e-9
    )
    assert free.trace["motor_torque_nm"].min() == pytest.approx(-20 * 0.049 / 11.82)
    assert bounded.trace["motor_torque_nm"].min() == pytest.approx(-0.05)
    stopped = 0.5 * 3.78 * bounded.trace["speed_mps"].max() ** 2
    share = 1 - 0.05 * 11.82 / 0.049 / 20
    brakes = bounded.trace["energy_brakes_j"][-1]
    assert brakes == pytest.approx(share * stopped, rel=3e-3)


@pytest.mark.parametrize("delay", [0.05, 0.1234])
def test_a_delay_shifts_the_force_and_nothing_else(delay):
    prompt = simulate(car(**TABLE), DRIVE, throttle=STEP).trace
    late = car({"actuation_delay": {"delay_s": delay}}, **TABLE)
    run = simulate(late, DRIVE, throttle=STEP).trace
    t = run["time_s"]
    shifted = np.interp(t - delay, t, prompt["speed_mps"])
    assert np.abs(run["speed_mps"] - shifted).max() < 2e-3


def test_a_lag_of_the_force_is_first_order():
    slow = car({"motor_lag": {"time_constant_s": 0.2}}, **TABLE, body__mass_kg=60.0,
               body__yaw_inertia_kgm2=0.6)  # fmt: skip
    torque = simulate(slow, DRIVE, throttle=STEP).trace
    t, tau = torque["time_s"], torque["motor_torque_nm"]
    after = (t > 1.02) & (t < 2.0)
    speed_left = 1 - torque["speed_mps"] / 5.0
    want = 10.0 / (11.82 / 0.049) * (1 - np.exp(-(t - 1.006) / 0.2)) * speed_left
    assert np.allclose(tau[after], want[after], rtol=0.02, atol=2e-4)


def steered(effects, angle, t):
    cycle = Cycle("c", np.array([0.0, t[-1]]), np.array([4.0, 4.0]))
    return simulate(car(effects), cycle, steer=(t, angle)).trace


def test_steering_answers_as_lag_of_play_of_gain_and_offset():
    t = np.linspace(0, 6, 601)
    angle = 0.05 * np.sin(3 * t)
    plain = steered({}, 0.9 * angle + 0.01, t)
    linked = {"steering_gain": {"gain": 0.9}, "steering_offset": {"angle_rad": 0.01}}
    run = steered(linked, angle, t)
    # the command at the very start aside, gain and offset are those of the plain car
    assert np.abs(run["yaw_rate_radps"] - plain["yaw_rate_radps"])[50:].max() < 1e-9


def test_a_steering_delay_shifts_the_yaw_rate():
    t = np.linspace(0, 6, 6001)
    angle = 0.05 * np.sin(3 * t)
    prompt, late = (
        steered(effects, angle, t)
        for effects in ({}, {"steering_delay": {"delay_s": 0.1}})
    )
    clock = prompt["time_s"]
    shifted = np.interp(clock - 0.1, clock, prompt["yaw_rate_radps"])
    gap = np.abs(late["yaw_rate_radps"] - shifted)[clock > 1.0]
    assert gap.max() < 1e-4


def test_play_leaves_the_wheels_where_they_are_until_it_is_taken_up():
    t = np.linspace(0, 4, 401)
    small = steered(
        {"steering_backlash": {"width_rad": 0.04}}, 0.015 * np.sin(3 * t), t
    )
    assert (small["yaw_rate_radps"] == 0).all()
    large = steered({"steering_backlash": {"width_rad": 0.04}}, 0.1 * np.sin(3 * t), t)
    free = steered({}, 0.1 * np.sin(3 * t), t)
    assert np.abs(large["yaw_rate_radps"]).max() < np.abs(free["yaw_rate_radps"]).max()


def test_a_path_follower_counters_an_offset_of_the_steering():
    from rcc_sim.simulate.run import LaneChanges

    cycle = Cycle("c", np.array([0.0, 2.0, 20.0]), np.array([0.0, 4.0, 4.0]))
    crooked = car({"steering_offset": {"angle_rad": 0.05}})
    run = simulate(crooked, cycle, lanes=LaneChanges(30.0)).trace
    straight = (run["x_m"] > 15) & (run["x_m"] < 28)
    assert run["steer_cmd_rad"][straight].mean() == pytest.approx(-0.05, abs=0.005)


@pytest.mark.parametrize(
    ("settings", "throttle", "word"),
    [
        (TABLE, None, "throttle"),
        ({}, STEP, "throttle"),
        (TABLE | {"controller__force_n": [[0.0, 0.0]]}, STEP, "rows"),
        (TABLE | {"controller__force_throttle": [1.0, 0.0]}, STEP, "rising"),
        ({"controller__mode": "throttle"}, STEP, "force_n"),
    ],
)
def test_a_throttle_that_does_not_fit_is_an_error(settings, throttle, word):
    with pytest.raises(InputError, match=word):
        simulate(car(**settings), DRIVE, throttle=throttle)
