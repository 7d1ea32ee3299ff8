"""What is left when the model is right: scale, memory and likelihood of residuals.

A residual is taken as noise whose size may grow with speed (a rough road is a force,
so that it shows in power in proportion to speed) and that remembers the recent past.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from math import inf

import numpy as np
from numpy.typing import NDArray

from rcc_sim.jit import compiled, jit

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

FREEDOM = 8.0
"""Degrees of freedom of the t-distribution that whitened residuals follow."""

CURVATURE = (FREEDOM + 1) / (FREEDOM + 3)
"""Fisher information of the t-distribution about its centre, its scale being 1."""

DRIFTS = (16.0, 32.0, 64.0, 128.0)
"""Times [rows] in which the drift of a sensor dies away."""

DRIFT_SIZES = (0.0, 0.1, 0.2, 0.4, 0.8, 1.6)
"""Sizes of the drift, in times the noise of a row."""

SHORT = 1000
"""Rows below which a log is too short to tell what an encoder's noise remembers: what
is missing in the model would be learnt as a memory. That of other sensors is real."""


def local_range(x: Array, rows: int = 7) -> Array:
    """How far a channel moves within some rows: where timing matters."""
    half = rows // 2
    x = np.pad(np.where(np.isfinite(x), x, 0.0), half, mode="symmetric")
    near = np.stack([x[i : len(x) - 2 * half + i] for i in range(2 * half + 1)])
    found: Array = near.max(axis=0) - near.min(axis=0)
    return found


def lag_edges(rate: float, memory: float, rows: int) -> list[int]:
    """Edges [rows] of the blocks of past rows, each twice as long as the last.

    Rows farther apart than the noise remembers have none but a drift: [0].
    """
    longest = min(memory * rate, rows / 20)
    if memory * rate < 1:
        return [0]
    edges = [0, 1, 2]
    while edges[-1] * 2 <= longest:
        edges.append(edges[-1] * 2)
    return edges


def block_means(z: Array, edges: list[int]) -> list[Array]:
    """Means of z over blocks of past rows; before the start z is taken as 0."""
    total = np.zeros((len(z) + edges[-1] + 1, *z.shape[1:]))
    np.cumsum(z, axis=0, out=total[edges[-1] + 1 :])
    n, last = len(z), edges[-1]
    return [
        (total[last - a : last - a + n] - total[last - b : last - b + n]) / (b - a)
        for a, b in pairwise(edges)
    ]


@dataclass(frozen=True)
class Whitener:
    """Turns one channel's residual into white noise of unit variance."""

    scale: Array
    memory: Array
    edges: list[int]
    sigma: float
    valid: Mask
    turned: Array | None = None

    def __call__(self, e: Array) -> Array:
        """Return residuals (n,) or signals (n, k), whitened, invalid rows dropped."""
        if self.turned is not None:
            return self.turned @ np.where(np.isfinite(e[self.valid]), e[self.valid], 0)
        wide = np.require(np.atleast_2d(e.T), float, ["C", "W"])
        w = np.empty((len(wide), self._count))
        compiled(whiten)(wide, self._unit, self.valid, *self._ends, w)
        return w.T if e.ndim > 1 else w[0]

    @cached_property
    def _count(self) -> int:
        return int(np.count_nonzero(self.valid))

    @cached_property
    def _unit(self) -> Array:
        return self.scale * self.sigma

    @cached_property
    def _ends(self) -> tuple[NDArray[np.intp], Array]:
        """Edges of the blocks, and the weight of the running total at each."""
        if not len(self.memory):
            return np.zeros(0, dtype=np.intp), np.zeros(0)
        share = self.memory / np.diff(self.edges)
        return np.array(self.edges), np.diff(share, prepend=0.0, append=0.0)


@jit
def whiten(e, unit, valid, edges, weight, w):  # type: ignore[no-untyped-def]
    """Write to w[j] the valid of e[j, i] / unit[i], less what those before foresee.

    Means of blocks foresee it, which are differences of running totals, a weight for
    each edge of a block; an invalid row counts as 0.
    """
    n = e.shape[1]
    z = np.empty(n)
    total = np.zeros(n + 1)
    for j in range(e.shape[0]):
        for i in range(n):
            z[i] = 0.0
            if valid[i]:
                z[i] = e[j, i] / unit[i]
            total[i + 1] = total[i] + z[i]
        for b in range(len(edges)):
            share, later = weight[b], z[edges[b] :]
            for i in range(len(later)):
                later[i] -= share * total[i]
        k = 0
        for i in range(n):
            if valid[i]:
                w[j, k] = z[i]
                k += 1


def weights(w: Array) -> Array:
    """Weight of each whitened residual in a fit by the t-distribution."""
    return (FREEDOM + 1) / (FREEDOM + w * w)


def curvature(W: Array) -> float:
    """How much less a log-likelihood is curved than its weights W say, on the whole.

    1 where residuals are nil, ``CURVATURE`` at least: its second derivative at w is
    -W (f - w²) / (f + w²), with (f - w²) / (f + w²) = 2 f / (f + 1) W - 1.
    """
    total = float(W.sum()) or 1.0
    return max(2 * FREEDOM / (FREEDOM + 1) * float(W @ W) / total - 1, CURVATURE)


def log_density(w: Array) -> Array:
    """Log-likelihood of each whitened residual, up to a constant."""
    density: Array = -0.5 * (FREEDOM + 1) * np.log1p(w * w / FREEDOM)
    return density


def log_likelihood(whitener: Whitener, e: Array) -> float:
    """Log-likelihood of a channel's residual, scale and all."""
    n = int(whitener.valid.sum())
    size = float(np.log(whitener.scale[whitener.valid]).sum())
    return (
        float(log_density(whitener(e)).sum()) - n * float(np.log(whitener.sigma)) - size
    )


def fit_whitener(
    e: Array,
    valid: Mask,
    grows_with: list[Array],
    edges: list[int],
    least: float = 0.0,
) -> Whitener:
    """Learn scale and memory from a residual.

    The scale's square is 1 plus a non-negative sum of the squares of what the noise
    may grow with (speed; how fast the channel changes), learnt from what the memory
    does not foresee. No noise is below ``least``.
    """
    n = int(valid.sum())
    scale = np.ones(len(e))
    if n < 10 or not np.any(e[valid]):
        size = max(least, 1e-12) if n >= 10 else 1.0
        memory = np.zeros(max(len(edges) - 1, 0))
        return Whitener(scale, memory, edges, size, valid)
    raw = np.where(valid, e, 0.0)
    parts = [np.ones(len(e))]
    for g in grows_with:
        unit = float(np.mean(g[valid] ** 2))
        if unit > 0:
            parts.append(g**2 / unit)
    X = np.stack(parts)
    share = np.full(len(parts), 1.0 / len(parts))
    memory = np.zeros(max(len(edges) - 1, 0))
    sigma = 1.0
    for _ in range(3):
        z = raw / scale
        means = block_means(z, edges) if len(memory) else []
        seen = z - sum(c * m for c, m in zip(memory, means, strict=True))
        share = fit_scale((seen * scale)[valid], X[:, valid], share)
        scale = np.sqrt(share @ X)
        z = raw / scale
        means = block_means(z, edges) if len(memory) else []
        features = np.array(means).reshape(len(memory), len(z)).T[valid]
        memory, sigma = fit_memory(z[valid], features, memory)
    unit = float(np.sqrt(share[0])) or 1.0
    size, scale = sigma * unit, scale / unit
    if size < least:  # how a model errs that is as exact as this, nobody knows
        memory, scale, size = 0 * memory, np.maximum(scale * size / least, 1.0), least
    if edges == [0]:
        return drifting(raw, scale * size, valid)
    return Whitener(scale, memory, edges, size, valid)


def fit_scale(u: Array, X: Array, share: Array) -> Array:
    """Non-negative shares of X (k, n) whose sum is the likeliest variance of u (n,).

    Multiplicative steps on the likelihood of a t-distribution.
    """
    u2 = u * u
    share = np.maximum(share, 1e-6 / len(share)) * robust_size(u2)
    for _ in range(12):
        s2 = share @ X
        seen = (FREEDOM + 1) / (FREEDOM + u2 / s2) * u2 / s2**2
        share = share * (X @ seen) / np.maximum(X @ (1 / s2), 1e-300)
        share = np.maximum(share, 1e-12 * share.max())
    return share


def fit_memory(z: Array, features: Array, memory: Array) -> tuple[Array, float]:
    """Weights of past block means that foresee z, and the size of what is left."""
    size = np.sqrt(robust_size((z - features @ memory) ** 2))
    for _ in range(2 if len(memory) else 0):
        W = weights((z - features @ memory) / size)
        A = features.T * W
        N = A @ features
        ridge = 1e-3 * np.trace(N) / len(memory) + 1e-30
        memory = np.linalg.solve(N + ridge * np.eye(len(memory)), A @ z)
        size = np.sqrt(robust_size((z - features @ memory) ** 2))
    return memory, float(size)


def robust_size(squares: Array) -> float:
    """Square of the t-distribution's scale, from squared residuals."""
    least = 1e-6 * float(np.mean(squares))  # most rows may be alike to the last bit
    s = max(float(np.median(squares)) * 2.2, least) + 1e-300
    for _ in range(6):
        s = float(np.mean((FREEDOM + 1) / (FREEDOM + squares / s) * squares)) + 1e-300
    return s


def drifting(e: Array, scale: Array, valid: Mask) -> Whitener:
    """Whitener of rows that are independent but for a slow drift of the sensor.

    The drift's size and time are the likeliest for the residuals e, of which each has
    the standard deviation ``scale`` beside it.
    """
    rows = np.flatnonzero(valid)
    z, each = e[rows], scale[rows] ** 2
    near = np.abs(rows[:, None] - rows[None, :])
    best = (-inf, np.diag(np.sqrt(each)))
    for time in DRIFTS:
        shape = np.exp(-near / time)
        for size in DRIFT_SIZES:
            K = np.diag(each) + size**2 * float(np.median(each)) * shape
            L = np.linalg.cholesky(K)
            w: Array = np.asarray(np.linalg.solve(L, z))
            value = float(log_density(w).sum()) - float(np.log(np.diag(L)).sum())
            if value > best[0]:
                best = (value, L)
    L = best[1]
    own = np.ones(len(e))
    own[rows] = np.diag(L)
    return Whitener(own, np.zeros(0), [0], 1.0, valid, np.linalg.inv(L))
