"""An altimeter wanders, on the way as at rest: no slope is made of that."""

import numpy as np
import pytest
from scipy.signal import lfilter

from rcc_sim.simulate.road import VISIT, surveyed_slope, undithered, visits

RATE, MINUTES = 10.0, 15.0  # Hz, min
WAVES = ((0.8, 420.0), (2.0, 1100.0), (4.0, 2700.0))  # m: heights and lengths of hills
WANDER, FORGETS = 0.4, 200.0  # m, s: of a barometer


def drive():
    """Time and distance of a delivery round, and the road's height and slope there."""
    time = np.arange(0.0, 60 * MINUTES, 1 / RATE)
    stop = np.sin(2 * np.pi * time / 95.0) < -0.55
    width = int(6 * RATE)
    speed = np.convolve(np.where(stop, 0.0, 10.0), np.ones(width) / width, "same")
    s = np.cumsum(speed) / RATE
    height = sum(a * np.sin(2 * np.pi * s / l) for a, l in WAVES)
    slope = sum(a * 2 * np.pi / l * np.cos(2 * np.pi * s / l) for a, l in WAVES)
    return time, s, speed > 1.0, height, slope


def read(height, seed, noise, wander=WANDER):
    """What a barometer reads: an Ornstein-Uhlenbeck process on top, and noise."""
    rng = np.random.default_rng(seed)
    keeps = np.exp(-1 / (RATE * FORGETS))
    kicks = rng.normal(0, wander * np.sqrt(1 - keeps**2), len(height))
    return height + lfilter([1], [1, -keeps], kicks) + rng.normal(0, noise, len(height))


def climbing(slope, found, there):
    """True slope by the one that was found: less than 1 where it holds noise."""
    return float(slope[there] @ found[there] / (found[there] @ found[there]))


@pytest.mark.parametrize("step", [0.0, 0.1])
@pytest.mark.parametrize("seed", [1, 2, 3])
def test_a_barometer_that_wanders_makes_no_slopes(seed, step):
    time, s, there, height, slope = drive()
    seen = read(height, seed, noise=0.05)
    seen = step * np.round(seen / step) if step else seen
    found, without = (np.interp(s, *surveyed_slope(s, seen, t)) for t in (time, None))
    off, was = (np.std((x - slope)[there]) for x in (found, without))
    assert off < 0.8 * was
    assert climbing(slope, found, there) == pytest.approx(1.0, abs=0.04)
    assert climbing(slope, without, there) < 0.96


@pytest.mark.parametrize("seed", [1, 2, 3, 4, 5, 6])
def test_whole_metres_that_flicker_are_no_steps_of_the_road(seed):
    """A mean of many is no surer of the height than one: they all err alike."""
    time, s, there, height, slope = drive()
    seen = np.round(read(height, seed, noise=0.05))
    found, without = (np.interp(s, *surveyed_slope(s, seen, t)) for t in (time, None))
    assert np.std((found - slope)[there]) < np.std((without - slope)[there])
    better = climbing(slope, found, there) - climbing(slope, without, there)
    assert better > 0.01


@pytest.mark.parametrize("noise", [0.0, 0.05, 0.15, 0.5])
def test_what_a_mean_of_rounded_heights_keeps_is_what_they_err_by_at_one_place(noise):
    rng = np.random.default_rng(4)
    true = rng.uniform(0, 1, 400)[:, None]
    seen = np.round(true + rng.normal(0, noise, (400, 400)))
    within = float(seen.var(axis=1).mean())
    kept = undithered(seen[:200].ravel(), within)
    means = float(np.var(seen.mean(axis=1) - true[:, 0]))
    assert kept == pytest.approx(means, rel=0.4, abs=0.001)


def test_exact_heights_lose_nothing_to_a_wander():
    time, s, there, height, slope = drive()
    found, without = (np.interp(s, *surveyed_slope(s, height, t)) for t in (time, None))
    assert np.std((found - without)[there]) < 0.01 * np.std(slope)
    assert np.std((found - slope)[there]) < 0.02 * np.std(slope)


def test_a_flat_road_is_flat_however_its_altimeter_wanders():
    time, s, there, height, _ = drive()
    found = np.interp(s, *surveyed_slope(s, read(0 * height, 5, 0.05), time))
    assert np.std(found[there]) < 0.001


def test_short_hills_on_a_long_way_are_found():
    """Cells follow the readings, however long the way."""
    time = np.arange(0.0, 2400.0, 0.2)
    s = 14.0 * time
    slope = 0.015 * np.cos(2 * np.pi * s / 400.0)
    height = 0.015 * 400.0 / (2 * np.pi) * np.sin(2 * np.pi * s / 400.0)
    found = np.interp(s, *surveyed_slope(s, height, time))
    assert np.std(found - slope) < 0.06 * np.std(slope)


@pytest.mark.parametrize("noise", [1e-4, 1e-3, 0.02])
@pytest.mark.parametrize("length", [30.0, 150.0, 5000.0])
def test_a_level_road_of_any_length_is_level(length, noise):
    time = np.arange(0.0, 75.0, 0.01)
    s = length / 75.0 * time
    for seed in range(4):
        seen = np.random.default_rng(seed).normal(0.0, noise, len(s))
        _, slope = surveyed_slope(s, np.round(seen, 5), time)
        assert np.abs(slope).max() < 0.5 * noise / length + 2e-6


def test_a_stand_of_hours_is_three_visits():
    time = np.arange(0.0, 7200.0, 0.1)
    cell = np.where(time < 100, 0, np.where(time < 7000, 1, 2))
    visit = visits(cell, time)
    assert np.all(np.diff(visit) >= 0) and visit[0] == 0 and visit[-1] == 8
    assert len(np.unique(visit[cell == 1])) == 3
    assert np.sum(visit == 3) == pytest.approx(10 * VISIT, abs=1)
    short = visits(np.zeros(50, int), 0.1 * np.arange(50.0))
    assert len(np.unique(short)) == 1


def test_leaps_of_a_receiver_are_no_cliffs():
    """It loses its satellites, reads 100 m too little for a while, and comes back."""
    time, s, there, height, slope = drive()
    seen = np.round(read(height, 4, noise=0.3))
    for first, rows, leap in ((800, 150, -111.0), (4000, 1300, 40.0), (7000, 5, 160.0)):
        seen[first : first + rows] += leap
    where, found = surveyed_slope(s, seen, time)
    assert np.abs(found).max() < 0.06
    assert np.std((np.interp(s, where, found) - slope)[there]) < 0.7 * np.std(slope)


def test_a_road_that_is_kept_is_that_of_its_own_log_and_not_changed_from_outside():
    time, s, _, height, _ = drive()
    seen = read(height, 7, noise=0.05)
    first = surveyed_slope(s, seen, time)
    expected = [x.copy() for x in first]
    for x in first:
        x *= 2.0
    other = surveyed_slope(s, 2 * seen, time)
    roads = [surveyed_slope(s, 2 * seen, time), surveyed_slope(s, seen, time)]
    np.testing.assert_array_equal(roads[0], other)
    np.testing.assert_array_equal(roads[1], expected)
    assert not np.array_equal(other[1], expected[1])
    assert not np.array_equal(surveyed_slope(s, seen)[1], expected[1])
