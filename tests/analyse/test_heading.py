"""A heading that was measured apart from the gyro."""

import numpy as np
import pytest

from rcc_sim.analyse.heading import (
    lost,
    measured_turn,
    noise_of_turn,
    once_a_span,
    turn_at,
    turn_rate,
)
from rcc_sim.trace import Trace

T = np.arange(0, 20, 0.01)
WHEELBASE = 0.3


def turned(t):
    """Heading whose rate is 2 sin t."""
    return 2 - 2 * np.cos(t)


def test_a_turn_is_the_mean_rate_since_a_span_ago_whatever_whole_turns_are_left_out():
    wrapped = np.angle(np.exp(1j * (turned(T) + 40 * T)))
    found = turn_rate(T, wrapped)
    exact = 40 + (turned(T) - turned(T - 0.1)) / 0.1
    assert np.isnan(found[:10]).all()
    np.testing.assert_allclose(found[10:], exact[10:], atol=1e-9)


def test_the_rate_at_a_row_is_that_about_it():
    found = turn_at(T, turned(T))
    inner = slice(6, -6)
    np.testing.assert_allclose(found[inner], 2 * np.sin(T)[inner], atol=1e-3)


@pytest.mark.parametrize("rate", [turn_rate, turn_at])
def test_across_a_hole_no_rate_is_told(rate):
    heading = np.where((T > 5) & (T < 6), np.nan, turned(T))
    found = rate(T, heading)
    assert np.isnan(found[(T > 5.0) & (T < 6.0)]).all()
    assert np.isfinite(found[(T > 6.2) & (T < 19.9)]).all()


def test_slow_rows_have_a_turn_each_and_fast_ones_a_turn_a_span():
    slow = np.arange(0, 20, 0.25)
    assert np.isfinite(turn_rate(slow, turned(slow))[1:]).all()
    kept = once_a_span(T, turn_rate(T, turned(T)))
    assert np.diff(T[np.isfinite(kept)])[:-1] == pytest.approx(0.1)


def test_a_camera_that_lost_its_marks_for_a_row_tells_no_turn():
    heading = turned(T)
    heading[1000:] += 2.0
    kept = once_a_span(T, turn_rate(T, heading))
    assert np.nanmax(np.abs(kept)) < 2.1


def test_a_place_that_stands_while_the_vehicle_drives_is_lost():
    at = np.where((T > 5) & (T < 8), 5.0, T)
    log = {"time_s": T, "speed_mps": 1 + 0 * T, "x_m": at, "y_m": 0 * T}
    found = lost(Trace(log))
    assert found[(T > 5.3) & (T < 7.7)].all()
    assert not found[(T < 4.5) | (T > 8.5)].any()
    assert not lost(Trace({"time_s": T, "speed_mps": 1 + 0 * T})).any()


def drive(heading, gyro):
    steer = 0.1 * np.sin(T)
    columns = {"time_s": T, "speed_mps": 2 + 0 * T, "steer_cmd_rad": steer}
    return Trace(columns | {"yaw_rad": heading, "yaw_rate_radps": gyro})


def integral(rate):
    return np.concatenate([[0.0], np.cumsum(0.5 * (rate[1:] + rate[:-1]) * 0.01)])


def test_only_a_heading_of_its_own_is_judged():
    noise = np.random.default_rng(0).normal(size=(2, len(T)))
    reckoned = 2 * np.tan(0.1 * np.sin(T)) / WHEELBASE
    true = 2 * np.tan(0.1 * np.sin(T - 0.2)) / WHEELBASE
    late = np.interp(T - 0.05, T, true) + 0.02 * noise[0]
    seen = integral(true) + 0.002 * noise[1]
    assert measured_turn(drive(seen, late), WHEELBASE) is not None
    for derived in (integral(reckoned), 1.03 * integral(reckoned), integral(late)):
        assert measured_turn(drive(derived, late), WHEELBASE) is None


@pytest.mark.parametrize(("noise", "judges"), [(0.0003, True), (0.01, False)])
def test_a_gyro_is_judged_by_no_heading_that_makes_it_seem_to_read_too_little(
    noise, judges
):
    rng = np.random.default_rng(3)
    true = 0.6 * np.sin(T - 0.2)
    gyro = 0.6 * np.sin(T - 0.25) + 0.02 * rng.normal(size=len(T))  # read late
    heading = integral(true) + noise * rng.normal(size=len(T))
    turn = measured_turn(drive(heading, gyro), WHEELBASE)
    assert turn is not None
    assert (turn.at is not None) == judges
    at = turn_at(T, heading)
    known = np.isfinite(at)
    gain = float(at[known] @ gyro[known]) / float(at[known] @ at[known])
    assert (gain > 0.99) == judges  # by the delay alone 0.9988


def test_the_noise_of_a_turn_is_how_far_a_heading_s_noise_moves_it():
    rng = np.random.default_rng(4)
    seen = turned(T) + 0.002 * rng.normal(size=len(T))
    made = turn_at(T, seen) - turn_at(T, turned(T))
    assert noise_of_turn(T, seen) == pytest.approx(np.nanstd(made), rel=0.1)
