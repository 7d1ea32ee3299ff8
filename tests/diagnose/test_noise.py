import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.sparse import csc_array

from rcc_sim.diagnose.noise.whitener import (
    at_rest,
    fit_whitener,
    lag_edges,
    log_likelihood,
)

ROWS = 4000
ALL = np.ones(ROWS, bool)


def autocorrelated(memory, rng):
    x = np.zeros(ROWS)
    for k in range(1, ROWS):
        x[k] = memory * x[k - 1] + rng.normal()
    return x


def correlation(w, lag):
    return float(np.corrcoef(w[:-lag], w[lag:])[0, 1])


@settings(max_examples=12)
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


def stopping(seed=4, stop=200, drive=300):
    """Rows of a drive whose noise remembers, with stops between, where it does not."""
    rng = np.random.default_rng(seed)
    stands = np.arange(ROWS) % (stop + drive) >= drive
    e = np.where(stands, 0.3 * rng.normal(size=ROWS), autocorrelated(0.95, rng))
    return e, stands, rng


def rested(e, stands, alike=1.0, valid=ALL):
    moving = fit_whitener(e, valid & ~stands, [], lag_edges(100.0, 1.0, ROWS))
    return at_rest(moving, e, valid, stands, alike)


def test_rest_neither_remembers_a_drive_nor_is_remembered_by_it():
    e, stands, rng = stopping()
    valid = rng.random(ROWS) > 0.1
    by = rested(e, stands, 10.0, valid)
    at = stands[valid]
    moved = by(e + 5.0 * stands) - by(e)
    assert moved[~at] == pytest.approx(0.0, abs=1e-9)
    assert moved[at].max() > 1.0
    other = by(e + 5.0 * ~stands) - by(e)
    assert other[at] == pytest.approx(0.0, abs=1e-12)


def test_windows_that_cut_stops_are_whitened_as_the_whole_is():
    e, stands, rng = stopping()
    by = rested(e, stands, 10.0, rng.random(ROWS) > 0.1)
    windows = csc_array(np.eye(13)[np.arange(ROWS) * 13 // ROWS])
    whole = by(e[:, None] * windows.toarray())
    assert by.through(e, windows).toarray() == pytest.approx(whole, abs=1e-9)


def test_rows_at_rest_are_whitened_by_the_inverse_of_their_covariance():
    """A level that dies away and rows about it: wᵀw = eᵀ C⁻¹ e, ln|C| by its scale."""
    e, stands, rng = stopping()
    e = e + np.where(stands, np.repeat(rng.normal(size=8), 500), 0.0)
    by = rested(e, stands)
    rows, unit = np.flatnonzero(stands), (by.scale * by.sigma)[stands]
    variance = unit[0] ** 2 * (1 - by.rest.gain[rows[0]])
    time = -1 / np.log(by.rest.fade[rows[0]])
    apart = np.abs(rows[:, None] - rows)
    C = variance * np.eye(len(rows))
    C += (unit[0] ** 2 - variance) * np.exp(-apart / time)
    x = e[stands]
    assert by(e)[stands] @ by(e)[stands] == pytest.approx(x @ np.linalg.solve(C, x))
    assert 2 * np.log(unit).sum() == pytest.approx(np.linalg.slogdet(C)[1])


@pytest.mark.parametrize(
    ("apart", "lasts"),
    [
        (1.0, 50),
        pytest.param(1.0, 300, marks=pytest.mark.thorough),
        (3.0, 1000),
    ],
)
def test_the_mean_at_rest_is_no_surer_than_its_scatter_from_drive_to_drive(
    apart, lasts
):
    """Over 200 drives whose level at rest wanders; and not much less sure."""
    means, told = [], []
    for seed in range(200):
        e, stands, rng = stopping(seed)
        fade, level = np.exp(-1 / lasts), np.empty(ROWS)
        level[0] = rng.normal()
        for k, x in enumerate(np.sqrt(1 - fade**2) * rng.normal(size=ROWS - 1)):
            level[k + 1] = fade * level[k] + x
        e = e + apart * np.where(stands, level, 0.0)
        w, one = (rested(e, stands, 10.0)(x)[stands] for x in (e, np.ones(ROWS)))
        means.append(w @ one / (one @ one))
        told.append(1 / (one @ one))
    assert 0.9 < np.mean(told) / np.var(means) < 3.0


@pytest.mark.parametrize("alike", [1.0, 20.0])
def test_of_stops_that_are_alike_so_many_rows_tell_as_one_does(alike):
    e, stands, _ = stopping()
    told = 1 / np.sum(rested(e, stands, alike)(np.ones(ROWS))[stands] ** 2)
    assert told > 0.9 * (1 + alike) * 0.3**2 / stands.sum()
    assert told < 8 * alike * 0.3**2 / stands.sum()


def test_rest_is_known_where_every_other_row_is_lost():
    e, stands, _ = stopping()
    by = rested(e, stands, 10.0, np.arange(ROWS) % 2 == 0)
    variance = (by.scale * by.sigma)[stands & by.valid] ** 2
    assert np.sqrt(variance.min()) == pytest.approx(0.3, rel=0.15)


def test_a_floor_below_most_rows_leaves_their_memory():
    """It lifts what little there is at rest: the rest remembers as it did."""
    rng = np.random.default_rng(3)
    grows = np.where(np.arange(6000) % 600 < 60, 0.0, 1.0)
    steps, e = rng.normal(0, 1.0, 6000), np.zeros(6000)
    for i in range(1, 6000):
        e[i] = 0.7 * e[i - 1] + steps[i]
    e = np.where(grows > 0, e, rng.normal(0, 0.01, 6000))
    known = e, np.ones(6000, bool), [grows], [0, 1, 2, 4]
    free, floored = fit_whitener(*known), fit_whitener(*known, 0.1)
    assert floored.memory == pytest.approx(free.memory, rel=0.15, abs=0.05)
    assert floored.memory[0] > 0.55
