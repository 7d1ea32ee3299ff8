"""The rating of ISO/TS 18571: how alike two curves look, from 0 to 1."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rcc_sim.jit import compiled, makes_arrays

Array = NDArray[np.float64]

INNER, OUTER = 0.05, 0.5
"""Half-widths of the corridors, of the largest reference. [1]"""

MOST_SHIFT = 0.2
"""Largest shift that the phase rating looks at, of the duration. [1]"""

WARP = 0.1
"""Window of the time warping, of the duration. [1]"""

MOST_MAGNITUDE, MOST_SLOPE = 0.5, 2.0
"""Errors at which the ratings of magnitude and slope reach 0. [1]"""

WEIGHTS = (0.4, 0.2, 0.2, 0.2)
"""Of corridor, phase, magnitude and slope."""

LEVEL = 1e-12
"""Correlation within which two shifts do equally well; and share of a curve's variance
below which a part of it is level. [1]"""

SMOOTHED = 9
"""Rows that a slope is averaged over."""


def rating(reference: Array, other: Array) -> float:
    """Return the overall rating of a curve against a reference, on equal rows.

    Corridor, phase, magnitude (after dynamic time warping) and slope, weighted by
    0.4, 0.2, 0.2, 0.2; grades are split at 0.94, 0.80 and 0.58.

    Parameters
    ----------
    reference, other : ndarray, shape (n,)
        At equal steps, neither constant, at least 20 rows.

    References
    ----------
    .. [1] ISO/TS 18571:2014, Road vehicles -- Objective rating metric for non-ambiguous
       signals.
    """
    shift = best_shift(reference, other)
    r, o = shifted(reference, other, shift)
    n = len(reference)
    parts = (
        corridor(reference, other),
        max(1 - abs(shift) / (MOST_SHIFT * n), 0.0),
        magnitude(r, o),
        slope(r, o),
    )
    return float(np.dot(WEIGHTS, parts))


def corridor(reference: Array, other: Array) -> float:
    """Return the share of rows within the inner corridor; less between the two."""
    size = float(np.abs(reference).max())
    off = np.abs(reference - other)
    between = (OUTER * size - off) / ((OUTER - INNER) * size)
    return float(np.mean(np.clip(between, 0.0, 1.0) ** 2))


def best_shift(reference: Array, other: Array) -> int:
    """Return the rows by which ``other`` lags (> 0) where the two correlate best.

    Of shifts that do equally well, the least.
    """
    n = len(reference)
    most = int(np.floor(n * MOST_SHIFT))
    k = np.array([0] + [s for at in range(1, most + 1) for s in (at, -at)])
    r, o = reference - reference.mean(), other - other.mean()
    rows = n - np.abs(k)

    def sums(x: Array, start: NDArray[np.intp]) -> Array:
        total = np.concatenate([[0.0], np.cumsum(x)])
        return np.asarray(total[start + rows] - total[start])

    of_r, of_o = np.maximum(-k, 0), np.maximum(k, 0)
    sum_r, sum_o = sums(r, of_r), sums(o, of_o)
    var_r = sums(r * r, of_r) - sum_r**2 / rows
    var_o = sums(o * o, of_o) - sum_o**2 / rows
    both = np.correlate(o, r, "full")[n - 1 + k] - sum_r * sum_o / rows
    least_r, least_o = (LEVEL * float(x @ x) for x in (r, o))
    varies = (var_r > least_r) & (var_o > least_o)
    alike = np.where(varies, both / np.sqrt(np.where(varies, var_r * var_o, 1.0)), -1.0)
    return int(k[np.argmax(alike >= alike.max() - LEVEL)])


def shifted(reference: Array, other: Array, shift: int) -> tuple[Array, Array]:
    """Return the rows that overlap where ``other`` is moved ahead by ``shift``."""
    if shift > 0:
        return reference[:-shift], other[shift:]
    if shift < 0:
        return reference[-shift:], other[:shift]
    return reference, other


def magnitude(reference: Array, other: Array) -> float:
    """Return the rating of the sizes, each row compared with that it is warped to."""
    n = len(reference)
    path = compiled(warped)(other, reference, int(np.ceil(WARP * n)) - 1)
    o, r = other[path[:, 0]], reference[path[:, 1]]
    error = float(np.abs(o - r).sum() / max(np.abs(r).sum(), 1e-300))
    return max(1 - error / MOST_MAGNITUDE, 0.0)


def slope(reference: Array, other: Array) -> float:
    """Return the rating of the slopes, averaged over nine rows."""
    r, o = (_averaged(np.gradient(x)) for x in (reference, other))
    error = float(np.abs(o - r).sum() / max(np.abs(r).sum(), 1e-300))
    return min(max(1 - error / MOST_SLOPE, 0.0), 1.0)


def _averaged(x: Array) -> Array:
    """Return means over nine rows; over fewer towards the ends."""
    half = SMOOTHED // 2
    out = np.empty(len(x))
    out[half:-half] = np.convolve(x, np.ones(SMOOTHED) / SMOOTHED, mode="valid")
    for k in range(half):
        out[k] = x[: 2 * k + 1].mean()
        out[-k - 1] = x[len(x) - 2 * k - 1 :].mean()
    return out


@makes_arrays
def warped(x, y, window):  # type: ignore[no-untyped-def]
    """Pairs of rows (i, j), |i − j| ≤ window, whose sum of (x_i − y_j)² is least."""
    n = len(x)
    cost = np.full((n, n), np.inf)
    for i in range(n):
        for j in range(max(i - window, 0), min(i + window + 1, n)):
            d = (x[i] - y[j]) ** 2
            if i == 0 and j == 0:
                cost[i, j] = d
                continue
            least = np.inf
            if i > 0:
                least = min(least, cost[i - 1, j])
            if j > 0:
                least = min(least, cost[i, j - 1])
            if i > 0 and j > 0:
                least = min(least, cost[i - 1, j - 1])
            cost[i, j] = least + d
    path = np.zeros((2 * n, 2), dtype=np.int64)
    i, j, k = n - 1, n - 1, 0
    path[0, 0] = i
    path[0, 1] = j
    while i > 0 or j > 0:
        up, left, both = np.inf, np.inf, np.inf
        if i > 0:
            up = cost[i - 1, j]
        if j > 0:
            left = cost[i, j - 1]
        if i > 0 and j > 0:
            both = cost[i - 1, j - 1]
        if up <= left and up <= both:
            i -= 1
        elif left <= both:
            j -= 1
        else:
            i -= 1
            j -= 1
        k += 1
        path[k, 0] = i
        path[k, 1] = j
    return path[: k + 1][::-1]
