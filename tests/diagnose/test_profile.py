import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rcc_sim.diagnose.profile import freed, likeliest, overlap, windows


@given(knots=st.integers(2, 40), seed=st.integers(0, 99))
def test_windows_sum_to_one_everywhere(knots, seed):
    x = np.random.default_rng(seed).uniform(-3, 7, 200)
    H = windows(x, np.linspace(-2, 6, knots))
    assert H.sum(axis=1) == pytest.approx(1)
    assert (H >= 0).all()


def linear_case(truth, noise, rng, rows=3000):
    x = np.linspace(0, 1, rows)
    A = windows(x, np.linspace(0, 1, len(truth)))
    r = -(A @ truth) + noise * rng.normal(size=rows)
    J = np.ones((rows, 1))
    return freed(A, r, J, np.array([1e-6]), np.zeros(1))[:2]


def test_a_profile_is_found_with_its_band_and_nothing_where_there_is_none():
    rng = np.random.default_rng(4)
    truth = np.sin(np.linspace(0, 6, 20))
    evidence, value, sd = likeliest(*linear_case(truth, 1.0, rng))
    assert evidence > 100
    assert np.mean(np.abs(value - truth) < 2.6 * sd) > 0.9
    none, flat, _ = likeliest(*linear_case(0 * truth, 1.0, rng))
    assert none < 5
    assert np.abs(flat).max() < 0.5


def test_what_a_free_knob_can_do_is_no_profile():
    rng = np.random.default_rng(5)
    x = np.linspace(0, 1, 3000)
    A = windows(x, np.linspace(0, 1, 10))
    r = 3.0 + rng.normal(size=3000)
    M, b, _ = freed(A, r, np.ones((3000, 1)), np.array([np.inf]), np.zeros(1))
    assert likeliest(M, b)[0] < 5


def test_overlap_is_one_for_the_same_tracks_and_none_apart():
    a, b = np.array([0.25, 0.75, 0.0]), np.array([0.0, 0.0, 1.0])
    assert overlap(a, a) == pytest.approx(1)
    assert overlap(a, b) == 0
