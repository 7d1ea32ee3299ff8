"""A noisy speed is smoothed on ramps as well, where it never turns."""

import numpy as np
import pytest

from rcc_sim.channel import is_rough
from rcc_sim.definitions.cycle import parse_cycle
from rcc_sim.simulate.smooth import smoothed

RAMPS = 20 * np.abs(np.arange(0, 200, 0.1) / 25 % 2 - 1)


@pytest.mark.parametrize("noise", [0.002, 0.02, 0.1])
def test_a_noisy_ramp_is_rough_and_a_clean_one_is_not(noise):
    rng = np.random.default_rng(1)
    assert is_rough(RAMPS + noise * rng.normal(size=len(RAMPS)))
    assert not is_rough(RAMPS)


@pytest.mark.parametrize("name", ["udds", "hwfet", "nedc"])
@pytest.mark.parametrize("step", [1.0, 0.1])
@pytest.mark.parametrize("digits", [3, 6])
def test_a_schedule_is_not_rough(name, step, digits):
    cycle = parse_cycle(name)
    time = np.arange(0, cycle.duration, step)
    speed = np.interp(time, cycle.time_s, cycle.speed_mps)
    assert not is_rough(np.round(speed, digits))


def test_what_is_rough_is_told_by_how_its_bends_grow_with_their_width():
    """By 1 for white noise, √2 for its sum, √8 for the sum of that, 4 for a curve."""
    rng = np.random.default_rng(3)
    white = rng.normal(size=5000)
    curve = 50 * np.sin(np.arange(5000) / 40)
    assert is_rough(white)
    assert is_rough(np.cumsum(white))
    assert not is_rough(np.cumsum(np.cumsum(white)))
    assert not is_rough(curve)


@pytest.mark.parametrize("held", [0, 2000])
def test_wheel_speeds_that_scatter_less_than_they_ramp_are_rough(held):
    """A car's speed never turns back on its ramps, nor while it stands for long."""
    rng, time = np.random.default_rng(4), np.arange(0, 400, 0.1)
    accel = 0.7 * np.sin(time / 3) + 0.15 * rng.normal(size=len(time))
    speed = np.maximum(12 + np.cumsum(0.1 * accel), 0.0)
    speed = np.round(np.concatenate([np.zeros(held), speed]) * 3.6, 2) / 3.6
    assert is_rough(speed)


def test_the_acceleration_of_a_noisy_ramp_is_found():
    time, rng = np.arange(0, 200, 0.1), np.random.default_rng(2)
    speed, accel, _ = smoothed(time, RAMPS + 0.02 * rng.normal(size=len(RAMPS)))
    turns = np.minimum(time % 25, 25 - time % 25) < 2
    true = np.where((time // 25) % 2, 0.8, -0.8)
    assert np.std((accel - true)[~turns]) < 0.05  # 0.28 by differences of rows
    assert np.std((speed - RAMPS)[~turns]) < 0.01
