"""What is left when the model is right: scale, memory and likelihood of residuals.

A residual is taken as noise whose size may grow with speed (a rough road is a force,
so that it shows in power in proportion to speed) and that remembers the recent past.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import cached_property
from math import inf

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_array

from rcc_sim.analyse.offsets import noise_of
from rcc_sim.diagnose.noise.kernel import (
    FREEDOM,
    follow_drift,
    learn,
    leave_drift,
    whiten,
    whiten_cut,
)
from rcc_sim.diagnose.noise.strips import Strips
from rcc_sim.jit import compiled

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
Places = NDArray[np.intp]

CURVATURE = (FREEDOM + 1) / (FREEDOM + 3)
"""Fisher information of the t-distribution about its centre, its scale being 1."""

SOLVED = 2
"""Times that the memory is solved for in each turn of scale and memory."""

DRIFTS = (16.0, 32.0, 64.0, 128.0)
"""Times [rows] in which the drift of a sensor dies away."""

DRIFT_SIZES = (0.0, 0.1, 0.2, 0.4, 0.8, 1.6)
"""Sizes of the drift, in times the noise of a row."""

SHORT = 1000
"""Rows below which a log is too short to tell what an encoder's noise remembers: what
is missing in the model would be learnt as a memory. That of other sensors is real."""


LEAST = 0.1
"""Noise at rest, as a share of that on the way, below which none is believed."""

STOPS = (4.0, 16.0, 64.0, 256.0)
"""Times in which a level at rest may die away, in those over which rows are alike."""

LEVELS = (0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0)
"""Sizes of that level, in times the noise of a row."""

FORGOTTEN = 20.0
"""Nepers from which on nothing is left of a level."""


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


@dataclass(frozen=True)
class Rest:
    """Rows at rest, and how what they share is followed along them.

    Parameters
    ----------
    at : ndarray of bool, shape (n,)
        Rows at which the vehicle stands and that count.
    gain, fade : ndarray, shape (n,)
        Share of a row's innovation that their level takes on; what is left of the level
        at the next (``follow_drift``).
    """

    at: Mask
    gain: Array
    fade: Array

    @classmethod
    def none(cls, n: int) -> Rest:
        """Return that of a drive without a stop."""
        return cls(np.zeros(n, bool), *np.zeros((2, n)))

    @property
    def rows(self) -> tuple[Mask, Array, Array]:
        """All of it, row by row."""
        return self.at, self.gain, self.fade

    def remembers(self, ends: Places) -> Places:
        """Return one past the last rows that know of those before the ``ends``."""
        last = self._forgotten[np.maximum(ends - 1, 0)]
        until = np.searchsorted(self._forgotten, last + FORGOTTEN) + 1
        return np.where(ends > 0, np.minimum(until, len(self.at)), 0)

    @cached_property
    def _forgotten(self) -> Array:
        """Nepers by which a level has faded since the start."""
        left = np.where(self.at, self.fade * (1 - self.gain), 1.0)
        faded: Array = np.cumsum(-np.log(np.maximum(left, 1e-300)))
        return faded


@dataclass(frozen=True)
class Whitener:
    """Turns one channel's residual into white noise of unit variance.

    Parameters
    ----------
    scale : ndarray, shape (n,)
        How the noise of a row compares with that of others; of its innovation, where
        a drift is followed.
    memory : ndarray
        Weights of the means of blocks of past rows, which foresee the next.
    edges : list of int
        Edges of those blocks. [rows]
    sigma : float
        Size of the noise where the scale is 1.
    valid : ndarray of bool, shape (n,)
        Rows that count.
    drift : tuple of ndarray or None
        Of each row that counts, the share of its innovation that a drift takes on and
        what is left of it at the next (``follow_drift``); None where nothing drifts.
    rest : Rest or None
        Rows at which the vehicle stands, of whose noise its motion has no part.
    """

    scale: Array
    memory: Array
    edges: list[int]
    sigma: float
    valid: Mask
    drift: tuple[Array, Array] | None = None
    rest: Rest | None = None

    def __call__(self, e: Array) -> Array:
        """Return residuals (n,) or signals (n, k), whitened, invalid rows dropped."""
        if not e.any():  # as of a figure that a channel knows nothing of
            return np.zeros((self._count, *e.shape[1:]))
        wide = np.require(np.atleast_2d(e.T), float, ["C", "W"])
        w = np.empty((len(wide), self._count))
        if self.drift is not None:
            rows = np.flatnonzero(self.valid)
            compiled(leave_drift)(wide, rows, self._unit[rows], *self.drift, w)
        else:
            known = self._unit, self.valid, *self._ends
            compiled(whiten)(wide, *known, *self._stops.rows, w)
        return w.T if e.ndim > 1 else w[0]

    def through(self, e: Array, windows: csc_array) -> Strips:
        """Return a signal (n,) in each of some windows (n, k), whitened likewise.

        A window's rows, which are in order, and those that remember them are all that
        is worked out: some rows after it, and of all later stops what its own last left
        there.
        """
        if self.drift is not None:
            return Strips.of(self(e[:, None] * windows.toarray()))
        n, k, stops = len(e), windows.shape[1], self._stops
        starts, at = windows.indptr, np.append(windows.indices, 0)
        held = np.diff(starts) > 0
        begin = np.where(held, at[starts[:-1]], 0)
        past = np.where(held, at[starts[1:] - 1] + 1, 0)
        near = np.minimum(past + (self.edges[-1] if len(self.memory) else 0), n)
        end = np.maximum(near, stops.remembers(past))
        before = np.concatenate([[0], np.cumsum(self.valid)])
        first, size = before[begin], before[end] - before[begin]
        place = np.concatenate([[0], np.cumsum(size)])
        w = np.empty(place[-1])
        cut = windows.data, windows.indices, starts, begin, end, place
        known = self._unit, self.valid, *self._ends
        compiled(whiten_cut)(e, *cut, *known, *stops.rows, w)
        rows = np.flatnonzero(stops.at[self.valid])
        whole = np.zeros((len(rows), k))
        runs = [w[a : a + m] for a, m in zip(place, before[near] - first, strict=False)]
        for j in range(k if len(rows) else 0):
            stand = slice(*np.searchsorted(rows, [first[j], first[j] + size[j]]))
            standing = place[j] + rows[stand] - first[j]
            whole[stand, j], w[standing] = w[standing], 0.0
        return Strips((self._count, k), rows, whole, np.arange(k), first, runs)

    def foresees(self, e: Array) -> float:
        """Return the share of a residual (n,) that its own past foresees.

        1 - |W e|² / |e / s|², W whitening it and s being the noise of each row; a
        sensor's own noise has none.
        """
        white, plain = self(e), e[self.valid] / self._unit[self.valid]
        power = float(plain @ plain)
        return max(1 - float(white @ white) / power, 0.0) if power else 0.0

    @cached_property
    def _count(self) -> int:
        return int(np.count_nonzero(self.valid))

    @cached_property
    def _unit(self) -> Array:
        return self.scale * self.sigma

    @cached_property
    def _stops(self) -> Rest:
        return self.rest or Rest.none(len(self.scale))

    @cached_property
    def _ends(self) -> tuple[NDArray[np.intp], Array]:
        """Edges of the blocks, and the weight of the running total at each."""
        if not len(self.memory):
            return np.zeros(0, dtype=np.intp), np.zeros(0)
        share = self.memory / np.diff(self.edges)
        return np.array(self.edges), np.diff(share, prepend=0.0, append=0.0)


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
    memory: Array | None = None,
) -> Whitener:
    """Learn scale and memory from a residual; the scale alone where that is known.

    The scale's square is 1 plus a non-negative sum of the squares of what the noise
    may grow with (speed; how fast the channel changes), learnt from what the memory
    does not foresee. No noise is below ``least``: what is missing remembers nothing,
    and the memory keeps the share of the rest.
    """
    n = int(valid.sum())
    scale = np.ones(len(e))
    if n < 10 or not np.any(e[valid]):
        size = max(least, 1e-12) if n >= 10 else 1.0
        return Whitener(scale, np.zeros(max(len(edges) - 1, 0)), edges, size, valid)
    raw = np.where(valid, e, 0.0)
    parts = [np.ones(len(e))]
    for g in grows_with:
        unit = float(np.mean(g[valid] ** 2))
        if unit > 0:
            parts.append(g**2 / unit)
    share = np.full(len(parts), 1.0 / len(parts))
    solved = SOLVED if memory is None else 0
    memory = np.zeros(max(len(edges) - 1, 0)) if memory is None else memory.copy()
    known = (np.flatnonzero(valid), np.stack(parts), np.array(edges, dtype=np.intp))
    sigma = compiled(learn)(raw, *known, solved, share, memory, scale)
    unit = float(np.sqrt(share[0])) or 1.0
    size, scale = sigma * unit, scale / unit
    if size < least:  # how a model errs that is as exact as this, nobody knows
        scale, size = scale * size / least, least
        memory = memory * float(np.mean(np.minimum(scale[valid], 1.0) ** 2))
        scale = np.maximum(scale, 1.0)
    if edges == [0]:
        return drifting(raw, scale * size, valid)
    return Whitener(scale, memory, edges, size, valid)


def at_rest(
    moving: Whitener, e: Array, valid: Mask, stands: Mask, alike: float
) -> Whitener:
    """Whitener of rows that count, of which those at rest have a noise of their own.

    They vary about a level, and that from stop to stop and within one: as is likeliest
    for the residual e, or by as much as if so many rows that are alike told no more
    than one. What all share is no noise: the likelihood is that of the rest (REML).
    """
    rest = valid & stands
    rows = np.flatnonzero(rest)
    stop = np.cumsum(np.diff(stands.astype(int), prepend=0) == 1)[rows]
    first = np.flatnonzero(np.diff(stop, prepend=0))
    steps = np.delete(np.diff(e[rows], prepend=0.0), first)
    size = max(noise_of(steps), LEAST * moving.sigma)
    least = size * np.sqrt(min(alike * len(first) / len(rows), 1.0))
    levels = (least, *(size * x for x in LEVELS if size * x > least))
    ways = [(time * alike, level**2) for time in STOPS for level in levels]
    each = np.full(len(e), size**2)
    sd, gain, fade = likeliest_drift(e, rows, each, ways, shared=True)
    scale, of = moving.scale.copy(), np.zeros((2, len(e)))
    scale[rows], of[:, rows] = sd / moving.sigma, (gain, fade)
    return replace(moving, scale=scale, valid=valid, rest=Rest(rest, *of))


def likeliest_drift(
    e: Array,
    rows: NDArray[np.intp],
    each: Array,
    ways: Iterable[tuple[float, float]],
    *,
    shared: bool = False,
) -> tuple[Array, Array, Array]:
    """Return how the likeliest drift is followed: sd, gain and fade of the rows.

    Of the ``ways``, times [rows] and variances, it is the likeliest for the residuals
    e (n,), which have the variances ``each`` (n,) beside it. What all rows have in
    common is no drift where that is ``shared``: the likelihood is then that of the
    rest (REML).
    """
    wide = np.stack([e, np.ones(len(e))]) if shared else e[None]
    (sd, gain, fade), w = np.empty((3, len(rows))), np.empty((len(wide), len(rows)))
    best, found = -inf, (np.ones(len(rows)), *np.zeros((2, len(rows))))
    for how in ways:
        compiled(follow_drift)(each, rows, *how, sd, gain, fade)
        compiled(leave_drift)(wide, rows, sd, gain, fade, w)
        left, value = w[0], -float(np.log(sd).sum())
        if shared:
            known = float(w[1] @ w[1])
            left = left - float(left @ w[1]) / known * w[1]
            value -= 0.5 * float(np.log(known))
        value += float(log_density(left).sum())
        if value > best:
            best, found = value, (sd.copy(), gain.copy(), fade.copy())
    return found


def drifting(e: Array, scale: Array, valid: Mask) -> Whitener:
    """Whitener of rows that are independent but for a slow drift of the sensor.

    The drift's size and time are the likeliest for the residuals e, of which each has
    the standard deviation ``scale`` beside it.
    """
    rows, each = np.flatnonzero(valid), scale**2
    usual = float(np.median(each[rows]))
    ways = [(time, size**2 * usual) for time in DRIFTS for size in DRIFT_SIZES]
    sd, gain, fade = likeliest_drift(e, rows, each, ways)
    own = np.ones(len(e))
    own[rows] = sd
    return Whitener(own, np.zeros(0), [0], 1.0, valid, (gain, fade))
