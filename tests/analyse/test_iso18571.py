"""The ISO/TS 18571 rating: closed forms, and the reference implementation."""

import numpy as np
import pytest

from rcc_sim.analyse.iso18571 import best_shift, corridor, magnitude, rating, slope

T = np.linspace(0, 6 * np.pi, 600)


def test_a_curve_against_itself_is_rated_one():
    assert rating(np.sin(T), np.sin(T)) == pytest.approx(1.0)


def test_a_curve_beyond_the_outer_corridor_throughout_has_no_corridor_rating():
    assert corridor(np.ones(100), np.ones(100) * 1.6) == 0.0
    assert corridor(np.ones(100), np.ones(100) * 1.04) == 1.0


def test_the_corridor_falls_with_the_square_between_the_two():
    half_way = 1 + (0.05 + 0.5) / 2
    assert corridor(np.ones(50), np.full(50, half_way)) == pytest.approx(0.25)


@pytest.mark.parametrize("shift", [-20, 0, 13])
def test_a_shifted_curve_is_found_shifted_by_so_much(shift):
    pulse = np.exp(-(((np.arange(600) - 300) / 40.0) ** 2))
    assert best_shift(pulse, np.roll(pulse, shift)) == shift


def test_a_curve_a_fifth_too_large_loses_two_fifths_of_its_magnitude():
    """e = 0.2 |r| / |r|; rated (0.5 - 0.2) / 0.5, where warping cannot help."""
    flat = np.ones(100)
    assert magnitude(flat, 1.2 * flat) == pytest.approx(0.6)


def test_a_slope_twice_as_steep_is_rated_one_half():
    ramp = np.linspace(0, 1, 100)
    assert slope(ramp, 2 * ramp) == pytest.approx(0.5)


@pytest.mark.parametrize("seed", range(5))
def test_it_agrees_with_the_published_implementation(seed):
    peer = pytest.importorskip("objective_rating_metrics.rating")
    rng = np.random.default_rng(seed)
    n = 300 + seed
    x = np.cumsum(rng.normal(size=n))
    y = np.roll(x, 3 * seed) * (1 + 0.05 * seed) + rng.normal(size=n) * 0.3
    t = np.arange(float(n))
    theirs = peer.ISO18571(np.column_stack([t, x]), np.column_stack([t, y]), dt=1.0)
    assert rating(x, y) == pytest.approx(theirs.overall_rating(-1), abs=1e-12)
