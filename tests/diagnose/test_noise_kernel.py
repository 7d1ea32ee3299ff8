"""Kernel code of the noise beside the same in whole arrays, and what each solves."""

import numpy as np
import pytest

from rcc_sim.diagnose.noise import kernel
from rcc_sim.jit import compiled

RNG = np.random.default_rng(5)


def sized(squares):
    """Square of a t-distribution's scale: its share of squares is what it should be."""
    s = compiled(kernel.robust_size)(squares)
    weights = (kernel.FREEDOM + 1) / (kernel.FREEDOM + squares / s)
    return s, float(np.mean(weights * squares)) / s


def test_a_size_is_that_at_which_weighted_squares_come_to_it():
    s, balance = sized(RNG.standard_t(kernel.FREEDOM, 20_000) ** 2)
    assert s == pytest.approx(1.0, rel=0.05)
    assert balance == pytest.approx(1.0, abs=1e-3)


@pytest.mark.parametrize(("share", "times"), [(0.01, 99.0), (0.08, 1e3), (0.6, 0.0)])
def test_a_size_is_found_beside_rows_far_out_and_rows_alike(share, times):
    other = np.where(RNG.random(4000) < share, times, 1.0)
    squares = (other * RNG.normal(size=4000)) ** 2
    s, balance = sized(squares)
    assert balance == pytest.approx(1.0, abs=1e-3)
    assert s < 0.1 * squares.mean() or times == 0.0


def test_a_size_of_nothing_is_next_to_nothing():
    assert 0.0 < compiled(kernel.robust_size)(np.zeros(100)) < 1e-200


def test_shares_of_a_variance_are_found_again():
    X = np.stack([np.ones(20_000), RNG.uniform(0, 2, 20_000) ** 2])
    true = np.array([0.5, 3.0])
    squares = RNG.normal(size=20_000) ** 2 * (true @ X)
    share = np.full(2, 0.5)
    compiled(kernel.fit_scale)(squares, X, share)
    assert share[1] / share[0] == pytest.approx(true[1] / true[0], rel=0.25)


@pytest.mark.parametrize("n", [1, 4, 7, 1000])
def test_sums_of_products_are_numpy_s(n):
    x, y = RNG.normal(size=(2, n))
    assert compiled(kernel.dot)(x, y) == pytest.approx(x @ y, rel=1e-12, abs=1e-12)


@pytest.mark.parametrize("m", [1, 3, 9])
def test_solve_is_that_of_numpy(m):
    A = RNG.normal(size=(m, 3 * m))
    N, b = A @ A.T, RNG.normal(size=m)
    x, lower = b.copy(), np.tril(N)
    compiled(kernel.solve)(lower, x)
    np.testing.assert_allclose(x, np.linalg.solve(N, b), rtol=1e-8)


def test_a_memory_settles_at_that_of_least_squares_by_its_own_weights():
    n = 5000
    means = RNG.normal(size=(3, n))
    z = [0.5, -0.2, 0.1] @ means + RNG.standard_t(kernel.FREEDOM, n)
    memory, squares = np.zeros(3), np.empty(n)
    for _ in range(10):  # until the weights have settled
        size = compiled(kernel.fit_memory)(z, means, 2, memory, squares)
    left = z - memory @ means
    np.testing.assert_allclose(squares, left**2)
    W = (kernel.FREEDOM + 1) / (kernel.FREEDOM + squares / size**2)
    N = (means * W) @ means.T
    N += 1e-3 * np.trace(N) / 3 * np.eye(3)
    np.testing.assert_allclose(memory, np.linalg.solve(N, (means * W) @ z), atol=1e-4)


def test_blocks_of_past_rows_are_averaged_and_what_is_not_seen_counts_as_nothing():
    e, scale = np.arange(1.0, 7.0), np.full(6, 2.0)
    rows, edges = np.array([0, 2, 3, 5]), np.array([0, 1, 3])
    z, means, total = np.empty(4), np.empty((2, 4)), np.zeros(7)
    compiled(kernel.look_back)(e, rows, scale, edges, total, z, means)
    seen = np.where(np.isin(np.arange(6), rows), e / 2, 0.0)
    np.testing.assert_allclose(z, seen[rows])
    before = np.concatenate([np.zeros(3), seen])
    # a block from a to b rows back holds those older than a, up to b
    for k, i in enumerate(rows):
        expected = [before[i + 3 - b : i + 3 - a].mean() for a, b in ((0, 1), (1, 3))]
        np.testing.assert_allclose(means[:, k], expected)


def test_machine_code_and_plain_python_give_the_same():
    n = 300
    e, rows = RNG.normal(size=n), np.arange(n)
    X = np.stack([np.ones(n), RNG.random(n)])
    edges = np.array([0, 1, 2, 4])
    found = []
    for run in (compiled(kernel.learn), kernel.learn):
        share, memory, scale = np.full(2, 0.5), np.zeros(3), np.ones(n)
        size = run(e, rows, X, edges, 2, share, memory, scale)
        found.append(np.concatenate([[size], share, memory, scale]))
    np.testing.assert_allclose(found[0], found[1], rtol=1e-12)


def test_a_memory_that_is_known_stays_and_the_size_is_of_what_it_leaves():
    n = 20_000
    e = RNG.normal(size=n)
    e[1:] += 0.6 * e[:-1]  # foreseen by more than what is known
    share, memory, scale = np.ones(1), np.array([0.3]), np.ones(n)
    known = np.arange(n), np.ones((1, n)), np.array([0, 1])
    size = compiled(kernel.learn)(e, *known, 0, share, memory, scale)
    assert memory[0] == 0.3
    left = e[1:] - 0.3 * e[:-1]
    squares = kernel.robust_size(left**2)
    assert size * scale[0] == pytest.approx(np.sqrt(squares), rel=1e-3)


def test_a_drift_is_followed_as_the_whole_covariance_would_have_it():
    n = 600
    rows = np.flatnonzero(RNG.random(n) < 0.3)
    each, time, variance = RNG.uniform(0.3, 2.0, n), 20.0, 1.7
    near = np.abs(rows[:, None] - rows[None, :])
    K = np.diag(each[rows]) + variance * np.exp(-near / time)
    L = np.linalg.cholesky(K)
    sd, gain, fade = np.empty((3, len(rows)))
    compiled(kernel.follow_drift)(each, rows, time, variance, sd, gain, fade)
    np.testing.assert_allclose(sd, np.diag(L), rtol=1e-10)
    e, w = RNG.normal(size=(3, n)), np.empty((3, len(rows)))
    e[1, rows[4]] = np.nan  # counts as nothing
    compiled(kernel.leave_drift)(e, rows, sd, gain, fade, w)
    seen = np.nan_to_num(e[:, rows])
    np.testing.assert_allclose(w, np.linalg.solve(L, seen.T).T, atol=1e-10)
