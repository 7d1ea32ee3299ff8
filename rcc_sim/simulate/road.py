"""The slope of a road whose elevation was surveyed along a drive, noise and all."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

CELLS = 240
"""Most cells that a road is cut into."""


def surveyed_slope(distance: Array, elevation: Array) -> tuple[Array, Array]:
    """Slope [1] over distance [m] from elevations [m] that hold noise.

    The height is a twice integrated random walk whose strength is the likeliest for
    these elevations; a flat road with a noisy survey comes out flat.

    Returns
    -------
    distance, slope : ndarray, shape (k,)
        Middle of each cell [m], rise over run [1].
    """
    ok = np.isfinite(distance) & np.isfinite(elevation)
    s, h = distance[ok], elevation[ok]
    length = float(s[-1] - s[0]) if len(s) else 0.0
    if len(s) < 10 or length <= 0:
        return np.zeros(1), np.zeros(1)
    k = int(min(CELLS, max(len(s) // 8, 4)))
    edges = np.linspace(s[0], s[-1], k + 1)
    cell = np.clip(np.searchsorted(edges, s, side="right") - 1, 0, k - 1)
    count = np.bincount(cell, minlength=k).astype(float)
    mean = np.bincount(cell, h, minlength=k) / np.maximum(count, 1)
    spread = np.bincount(cell, (h - mean[cell]) ** 2, minlength=k).sum()
    noise2 = max(spread / max(len(h) - (count > 0).sum(), 1), 1e-12)
    D2 = np.diff(np.eye(k), 2, axis=0)
    step = edges[1] - edges[0]
    used = count > 0
    best = (-np.inf, mean)
    A = np.diag(count / noise2)
    b = count * mean / noise2
    for strength in np.logspace(-6, 0, 25):
        # second difference of height ~ N(0, q2)
        q2 = (strength * step) ** 2
        N = A + D2.T @ D2 / q2
        N += 1e-9 * np.eye(k) * np.trace(A) / k
        L = np.linalg.cholesky(N)
        x = np.linalg.solve(N, b)
        fit = (count[used] * (mean[used] - x[used]) ** 2).sum() / noise2
        rough = ((D2 @ x) ** 2).sum() / q2
        value = (
            -0.5 * (fit + rough) - np.log(np.diag(L)).sum() - (k - 2) / 2 * np.log(q2)
        )
        if value > best[0]:
            best = (value, x)
    middle = 0.5 * (edges[1:] + edges[:-1])
    dh = np.diff(best[1])
    run = np.sqrt(np.maximum(step**2 - dh**2, 1e-12))
    return 0.5 * (middle[1:] + middle[:-1]), dh / run
