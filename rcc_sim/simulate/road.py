"""The slope of a road whose elevation was surveyed along a drive, noise and all."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rcc_sim.simulate.smooth import pieces

Array = NDArray[np.float64]

CELLS, READINGS = 240, 8
"""Most cells that a road is cut into, and readings that each holds at least."""

STANDS = 0.8
"""Share of the readings that repeat the one before beyond which heights are rounded."""

TURNS = 0.3
"""Share of their steps that go back from the one before beyond which they flicker."""

STEP_SHARE = 0.1
"""Share of a step to which a height is known where it passes from one to the next."""


def surveyed_slope(distance: Array, elevation: Array) -> tuple[Array, Array]:
    """Slope [1] over distance [m] from elevations [m] that hold noise.

    The height is a twice integrated random walk whose strength is the likeliest for
    these elevations; a flat road with a noisy survey comes out flat.

    Returns
    -------
    distance, slope : ndarray, shape (k,)
        Middle of each cell [m], rise over run [1].
    """
    from scipy.linalg import cho_solve_banded, cholesky_banded

    ok = np.isfinite(distance) & np.isfinite(elevation)
    s, h = distance[ok], elevation[ok]
    sure, step_noise, each = np.ones(len(s)), 0.0, READINGS
    if is_rounded(s, h):
        s, h, sure, step_noise = passed(s, h)
        each = 1
    length = float(s[-1] - s[0]) if len(s) else 0.0
    if len(s) < 10 or length <= 0:
        return np.zeros(1), np.zeros(1)
    edges, cell = cells(s, each)
    k = len(edges) - 1
    count = np.bincount(cell, sure, minlength=k)
    used = count > 0
    mean, place = (
        np.bincount(cell, sure * x, minlength=k) / np.where(used, count, 1.0)
        for x in (h, s)
    )
    noise2 = step_noise or within(cell, s, h, k)
    bands = second_differences(k)
    step = edges[1] - edges[0]
    best = (-np.inf, mean)
    # a car that waits in a cell was not in its middle: heights run straight between
    where = (place - edges[0]) / step - 0.5
    left = np.clip(np.floor(where), 0, k - 2).astype(int)
    share = np.where(used, where - left, 0.0)
    weight = count / noise2
    seen = np.zeros((3, k))
    np.add.at(seen[2], left, weight * (1 - share) ** 2)
    np.add.at(seen[2], left + 1, weight * share**2)
    np.add.at(seen[1], left + 1, weight * share * (1 - share))
    b = np.zeros(k)
    np.add.at(b, left, weight * (1 - share) * mean)
    np.add.at(b, left + 1, weight * share * mean)
    for strength in np.logspace(-6, 0, 25):
        # second difference of height ~ N(0, q2)
        q2 = (strength * step) ** 2
        N = bands / q2 + seen
        N[-1] += 1e-9 * weight.mean()
        C = cholesky_banded(N)
        x = cho_solve_banded((C, False), b)
        there = (1 - share) * x[left] + share * x[left + 1]
        fit = (count[used] * (mean[used] - there[used]) ** 2).sum() / noise2
        rough = (np.diff(x, 2) ** 2).sum() / q2
        value = -0.5 * (fit + rough) - np.log(C[-1]).sum() - (k - 2) / 2 * np.log(q2)
        if value > best[0]:
            best = (value, x)
    middle = 0.5 * (edges[1:] + edges[:-1])
    dh = np.diff(best[1])
    run = np.sqrt(np.maximum(step**2 - dh**2, 1e-12))
    return 0.5 * (middle[1:] + middle[:-1]), dh / run


def cells(s: Array, each: int) -> tuple[Array, NDArray[np.int_]]:
    """Return the edges of a road's cells, of so many places each, and each's cell."""
    k = int(min(CELLS, max(len(s) // each, 4)))
    edges = np.linspace(s[0], s[-1], k + 1)
    return edges, np.clip(np.searchsorted(edges, s, side="right") - 1, 0, k - 1)


def is_rounded(s: Array, h: Array) -> bool:
    """Tell whether heights are rounded: they stand, and then go on the way they went.

    Where noise makes them flicker between two steps, or they wander by more than a
    step, their mean says more.
    """
    moves, rises = np.diff(s) > 0, np.diff(h)
    steps = rises[rises != 0]
    if not moves.any() or len(steps) < 2:
        return False
    stands = float(np.mean(rises[moves] == 0))
    turns = float(np.mean(np.sign(steps[1:]) != np.sign(steps[:-1])))
    if stands < STANDS or turns > TURNS:
        return False
    edges, cell = cells(s, READINGS)
    wander = within(cell, s, h, len(edges) - 1)
    return wander < float(np.abs(steps).min()) ** 2 / 12


def passed(s: Array, h: Array) -> tuple[Array, Array, Array, float]:
    """Return where heights that are rounded pass from one step to the next.

    There they are half-way. Between two such places a reading says no more than that
    none was passed: all along it is within half a step of the road. Also returns how
    sure each is, against the first kind, and the variance of that. [m²]
    """
    at = np.flatnonzero(np.diff(h) != 0)
    step = float(np.min(np.abs(np.diff(h)[at])))
    ends = np.concatenate([[s[0]], 0.5 * (s[at] + s[at + 1]), [s[-1]]])
    stands = np.concatenate([h[at], h[-1:]])
    long = np.diff(ends)
    among, each = pieces(long)
    place = np.concatenate([ends[1:-1], ends[among] + each * long[among]])
    height = np.concatenate([0.5 * (h[at] + h[at + 1]), stands[among]])
    sure = np.concatenate([np.ones(len(at)), np.full(len(each), 12 * STEP_SHARE**2)])
    order = np.argsort(place, kind="stable")
    return place[order], height[order], sure[order], (STEP_SHARE * step) ** 2


def within(cell: NDArray[np.int_], s: Array, h: Array, k: int) -> float:
    """Variance of heights [m²] about a straight slope in each of k cells."""
    count = np.maximum(np.bincount(cell, minlength=k), 1)
    s, h = (x - (np.bincount(cell, x, k) / count)[cell] for x in (s, h))
    along, across, rise = (
        np.bincount(cell, x, minlength=k) for x in (s * s, h * s, h * h)
    )
    sloped = along > 0
    left = rise.sum() - (across[sloped] ** 2 / along[sloped]).sum()
    free = len(h) - len(np.unique(cell)) - int(sloped.sum())
    return max(float(left) / max(free, 1), 1e-12)


def second_differences(k: int) -> Array:
    """Return D'D in upper bands, shape (3, k), D taking second differences of k."""
    ones = np.ones(k - 2)
    bands = np.zeros((3, k))
    bands[2] = np.convolve(ones, [1.0, 4.0, 1.0])
    bands[1, 1:] = np.convolve(ones, [-2.0, -2.0])
    bands[0, 2:] = ones
    return bands
