import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rcc_sim.diagnose.noise import fit_whitener, lag_edges, log_likelihood

ROWS = 4000
ALL = np.ones(ROWS, bool)


def autocorrelated(memory, rng):
    x = np.zeros(ROWS)
    for k in range(1, ROWS):
        x[k] = memory * x[k - 1] + rng.normal()
    return x


def correlation(w, lag):
    return float(np.corrcoef(w[:-lag], w[lag:])[0, 1])


@settings(max_examples=12, deadline=None)
@given(memory=st.floats(0.0, 0.95), seed=st.integers(0, 99))
def test_noise_that_remembers_is_whitened(memory, seed):
    e = autocorrelated(memory, np.random.default_rng(seed))
    whitener = fit_whitener(e, ALL, [np.ones(ROWS)], lag_edges(100.0, 3.0, ROWS))
    w = whitener(e)
    for lag in (1, 3, 10):
        assert abs(correlation(w, lag)) < 0.08  # 5 sds of a white one
    assert w.std() == pytest.approx(np.sqrt(8 / 6), rel=0.1)  # sd of t by its scale


def test_noise_that_grows_with_speed_is_levelled():
    rng = np.random.default_rng(1)
    speed = np.abs(np.sin(np.linspace(0, 20, ROWS))) * 20
    e = rng.normal(size=ROWS) * np.sqrt(0.2**2 + (0.1 * speed) ** 2)
    w = fit_whitener(e, ALL, [speed], lag_edges(10.0, 3.0, ROWS))(e)
    slow, fast = w[speed < 3].std(), w[speed > 17].std()
    assert slow == pytest.approx(fast, rel=0.15)


def test_whitening_is_linear_and_leaves_invalid_rows_out():
    rng = np.random.default_rng(2)
    a, b = rng.normal(size=(2, ROWS))
    valid = rng.random(ROWS) > 0.1
    whiten = fit_whitener(a, valid, [], lag_edges(100.0, 1.0, ROWS))
    assert whiten(2 * a - 3 * b) == pytest.approx(2 * whiten(a) - 3 * whiten(b))
    assert whiten(np.column_stack([a, b]))[:, 1] == pytest.approx(whiten(b))
    assert len(whiten(a)) == valid.sum()


def test_the_likelihood_is_highest_for_the_noise_that_made_the_residual():
    rng = np.random.default_rng(3)
    e = autocorrelated(0.8, rng)
    edges = lag_edges(100.0, 1.0, ROWS)
    right = fit_whitener(e, ALL, [], edges)
    wrong = fit_whitener(rng.normal(size=ROWS) * 3, ALL, [], edges)
    assert log_likelihood(right, e) > log_likelihood(wrong, e) + 100


def test_a_noise_that_a_floor_lifts_a_little_remembers_almost_as_before():
    rng = np.random.default_rng(2)
    e = rng.normal(size=6000)
    for i in range(1, len(e)):
        e[i] += 0.95 * e[i - 1]
    every, edges = np.ones(len(e), bool), [0, 1, 2, 4, 8, 16]

    by = fit_whitener(e, every, [], edges, 1.05)  # what is new in a row has 1.0
    assert np.mean(by(e) ** 2) < 1.5  # without a memory 9
    # far below the floor nothing is known of what it remembers
    small = fit_whitener(1e-6 * e, every, [], edges, 1.0)
    np.testing.assert_allclose(small.memory, 0.0, atol=1e-9)


@pytest.mark.parametrize("least", [1e-9, 1e-4, 1e-2, 1.0])
def test_a_floor_lifts_what_lies_below_it_and_nothing_else(least):
    rng = np.random.default_rng(2)
    grows = np.repeat([0.0, 2.0], 2000)
    e = grows * rng.normal(size=4000) * 0.1 + 1e-7 * rng.normal(size=4000)
    whitener = fit_whitener(e, np.ones(4000, bool), [grows], [0, 1, 2, 4], least)
    each = whitener.scale * whitener.sigma
    assert each[0] == pytest.approx(max(1e-7, least), rel=0.3)
    assert each[-1] == pytest.approx(max(0.2, least), rel=0.3)


@pytest.mark.parametrize("memory", [0.0, 0.5, 0.9])
def test_of_noise_that_remembers_its_past_foresees_the_square_of_that(memory):
    """An AR(1)'s innovation has 1 - memory² of its variance."""
    e = autocorrelated(memory, np.random.default_rng(5))
    whitener = fit_whitener(e, ALL, [], lag_edges(100.0, 3.0, ROWS))
    assert whitener.foresees(e) == pytest.approx(memory**2, abs=0.03)
