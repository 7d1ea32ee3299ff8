"""Late sensors: the shape stays, the time moves, the energy is kept."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.interpolate import CubicSpline

from rcc_sim.physics.effects.sensor_delay import late
from rcc_sim.simulate.run import simulate
from tests.cars import car
from tests.physics.test_effects import BASE, CYCLE

uneven = st.lists(st.floats(0.01, 0.5), min_size=5, max_size=40)


@given(steps=uneven, delay=st.floats(0, 1))
def test_a_straight_line_comes_later_by_the_delay(steps, delay):
    time = np.concatenate([[0.0], np.cumsum(steps)])
    seen = late(2.0 + 3.0 * time, time, delay, sampled=True)
    assert np.allclose(seen, 2.0 + 3.0 * np.maximum(time - delay, 0.0))


@given(steps=uneven, delay=st.floats(0, 1), seed=st.integers(0, 99))
def test_a_delayed_power_holds_the_energy_that_was_there_a_delay_ago(
    steps, delay, seed
):
    time = np.concatenate([[0.0], np.cumsum(steps)])
    power = np.random.default_rng(seed).normal(size=len(time))
    power[1] = 0.0  # nothing before the start
    seen = late(power, time, delay, sampled=False)
    true = np.concatenate([[0.0], np.cumsum(power[1:] * np.diff(time))])
    later = np.concatenate([[0.0], np.cumsum(seen[1:] * np.diff(time))])
    start, *_, end = np.gradient(true, time)
    between = CubicSpline(time, true, bc_type=((1, start), (1, end)))
    ago = between(np.maximum(time - delay, 0.0))
    assert np.allclose(later, ago, atol=1e-3 * np.abs(power).max())


@given(rows=st.integers(1, 12), seed=st.integers(0, 99))
def test_readings_that_are_ahead_hold_their_last_value(rows, seed):
    time = 0.25 * np.arange(40)
    power = np.random.default_rng(seed).normal(size=len(time))
    for sampled in (True, False):
        seen = late(power, time, -0.25 * rows, sampled=sampled)
        assert np.allclose(seen[1:-rows], power[1 + rows :], atol=1e-12)
        assert np.allclose(seen[-rows:], power[-1], atol=1e-9)


@given(rows=st.integers(0, 12), seed=st.integers(0, 99))
def test_a_delay_of_whole_rows_moves_a_power_and_changes_nothing_else(rows, seed):
    time = 0.25 * np.arange(40)
    power = np.random.default_rng(seed).normal(size=len(time))
    seen = late(power, time, 0.25 * rows, sampled=False)
    assert np.allclose(seen[1 + rows :], power[1 : len(time) - rows], atol=1e-12)


@pytest.mark.parametrize("delay", [0.03, 0.05, 0.07, 0.25])
def test_a_part_of_a_row_delays_a_power_that_turns_within_some_rows(delay):
    """Against the mean of the sine itself: within 1 %; straight lines are 6 % off."""
    time = 0.1 * np.arange(200)
    w = 2 * np.pi / 0.9  # nine rows a turn

    def means(late_by):
        t = time - late_by
        return np.concatenate([[0.0], -np.diff(np.cos(w * t)) / w / np.diff(t)])

    seen = late(means(0.0), time, delay, sampled=False)
    off = (seen - means(delay))[8:-8]
    assert np.abs(off).max() < 0.01


@given(steps=uneven, delay=st.floats(0, 3), sampled=st.booleans())
def test_a_constant_stays_a_constant(steps, delay, sampled):
    time = np.concatenate([[5.0], 5.0 + np.cumsum(steps)])
    seen = late(np.full(len(time), 7.5), time, delay, sampled)
    assert np.allclose(seen, 7.5)


def test_each_channel_has_its_own_delay():
    true = simulate(car(BASE), CYCLE).trace
    delays = {"delay_s": 0.02, "battery_delay_s": 0.05, "yaw_rate_delay_s": 0.1}
    seen = simulate(car(BASE | {"sensor_delay": delays}), CYCLE).trace
    for column, rows in (("speed_mps", 2), ("motor_current_a", 2),
                         ("accel_x_mps2", 2), ("battery_power_w", 7)):  # fmt: skip
        moved = np.abs(seen[column][rows + 1 :] - true[column][1:-rows]).max()
        assert moved < 1e-9 * np.abs(true[column]).max(), column
    assert np.array_equal(seen["x_m"], true["x_m"])
    total = seen["energy_drivetrain_damping_j"][-1]
    assert total == pytest.approx(true["energy_drivetrain_damping_j"][-1], abs=0)


@pytest.mark.parametrize("delay", [0.03, 0.05, 0.07])
def test_a_part_of_a_row_delays_a_speed_and_does_not_even_it(delay):
    """Against the sine itself: within 1 %; straight lines are 5 % off."""
    time = 0.1 * np.arange(200)
    speed = 3.0 + np.sin(6.0 * time)
    seen = late(speed, time, delay, sampled=True)
    true = 3.0 + np.sin(6.0 * (time - delay))
    inner = slice(5, -5)
    assert np.abs(seen - true)[inner].max() < 0.01
    straight = np.interp(time - delay, time, speed)
    assert np.abs(straight - true)[inner].max() > 0.03


def test_a_late_speed_is_never_below_a_stop():
    time = 0.1 * np.arange(60)
    speed = np.clip(3.0 - time, 0.0, None)
    seen = late(speed, time, 0.04, sampled=True)
    assert seen.min() == 0.0 and seen.max() == 3.0
