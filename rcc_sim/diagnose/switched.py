"""A load that switches: levels, and the moments at which the log says they change.

A profile that changes little from knot to knot does not fit one that jumps, and the
noise that remembers takes it for its own. Here the moments of change are sought by a
noise that remembers nothing, and paid for; the levels between are then weighed against
the noise that they leave.
"""

from __future__ import annotations

from math import ceil, lgamma

import numpy as np
from numpy.typing import NDArray

from rcc_sim.diagnose.cause import BRISK_ENOUGH, PROFILES, Cause
from rcc_sim.diagnose.engine import MEMORY, Engine
from rcc_sim.diagnose.fit import Fit
from rcc_sim.diagnose.profile import Probe, Profile, probe_size
from rcc_sim.diagnose.remainder import carrier_of

Array = NDArray[np.float64]

LOAD = "auxiliary_load"

BLOCKS = 1500
"""Blocks of rows at most between which a level may change."""

PENALTIES = (10.0, 40.0, 160.0)
"""Nats that a change must gain by a noise that remembers nothing; the most of them by
one that does, is found by trying."""


LEAST = 1.0
"""Nats that a load is said to gain at least by a noise that takes it for its own."""


def as_levels(engine: Engine, fit: Fit) -> Cause | None:
    """Return a load that switches on and off, if what is left of a fit is one.

    The same levels of a drag have to be less likely by as much as a load must gain.
    Its ``gain`` is by the noise of the fit, as any other's; ``sharpened`` is how much
    more it is together with the noise that it leaves.
    """
    if any(w.turned is not None for w in fit.noise):
        return None
    key, along = PROFILES[LOAD]
    probe = Probe(engine, fit, key, probe_size(engine, key))
    found: dict[int, Profile] = {}
    windows: dict[int, tuple[Array, float]] = {}
    for i, problem in enumerate(engine.problems):
        x = problem.coordinate(along)
        best = stepped(probe, i, x)
        if best and best[0].evidence > BRISK_ENOUGH:
            found[i], windows[i] = best[0], best[1:]
        else:
            found[i] = Profile(key, along, x[[0, -1]], np.zeros(2), np.zeros(2), 0.0)
    if not windows:
        return None
    drag = carrier_of(engine, fit, "drag")
    other = Probe(engine, fit, drag, probe_size(engine, drag))
    both = sum(p.evidence for p in found.values())
    rival = sum(other.levels(i, H).evidence - cost for i, (H, cost) in windows.items())
    if both < rival + BRISK_ENOUGH:
        return None
    alone = sum(probe.evidence(i, H) - cost for i, (H, cost) in windows.items())
    gain = max(alone, LEAST)
    return Cause(
        LOAD,
        (key,),
        gain,
        rival=max(rival, 0.0),
        profiles=found,
        sharpened=both / gain,
        shares=probe.shares,
    )


def stepped(probe: Probe, log: int, x: Array) -> tuple[Profile, Array, float] | None:
    """Return the likeliest levels over x, their windows (n, k), and the changes' cost.

    The cost is the log of how many ways there are to choose the moments of change.
    """
    each, by_row = probe.per_row(log)
    count = min(len(x), BLOCKS)
    block = np.arange(len(x)) * count // len(x)
    told = np.bincount(block, by_row, count).astype(float)
    value = np.bincount(block, by_row * each, count) / np.maximum(told, 1e-300)
    least = max(ceil(MEMORY * count / (x[-1] - x[0])), 2)
    best: tuple[Profile, Array, float] | None = None
    for edges in dict.fromkeys(
        segments(value, told, least, nats) for nats in PENALTIES
    ):
        k = len(edges) - 1
        if k < 2:
            continue
        which = np.searchsorted(edges[1:-1], block, side="right")
        H = (which[:, None] == np.arange(k)).astype(float)
        cost = lgamma(count) - lgamma(k) - lgamma(count - k + 1)
        levels = probe.levels(log, H)
        if best is None or levels.evidence - cost > best[0].evidence:
            last = np.flatnonzero(np.diff(which))
            ends = np.concatenate([[0], np.stack([last, last + 1], 1).ravel(), [-1]])
            best = (
                Profile(
                    probe.key,
                    "time_s",
                    x[ends],
                    levels.value.repeat(2),
                    levels.sd.repeat(2),
                    levels.evidence - cost,
                    mean_sd=levels.mean_sd,
                    steps=True,
                ),
                H,
                cost,
            )
    return best


def segments(value: Array, told: Array, least: int, nats: float) -> tuple[int, ...]:
    """Return where the levels of a sequence begin, and its end.

    Those that minimise ``sum told (value - level)^2 / 2 + nats`` per level, of which
    none holds fewer than ``least`` values: optimal partitioning, by dynamic programming
    (Jackson et al. 2005, IEEE Signal Processing Letters 12(2)).

    Parameters
    ----------
    value, told : ndarray, shape (n,)
        Each value, and its inverse variance.
    least : int
        Fewest values in a level.
    nats : float
        What a level costs.
    """
    n = len(value)
    weight = np.concatenate([[0.0], np.cumsum(told)])
    total = np.concatenate([[0.0], np.cumsum(told * value)])
    best, start = np.full(n + 1, -np.inf), np.zeros(n + 1, dtype=int)
    best[0] = 0.0
    for j in range(min(least, n), n + 1):
        i = slice(0, max(j - least, 0) + 1)
        own = np.maximum(weight[j] - weight[i], 1e-300)
        gain = best[i] + 0.5 * (total[j] - total[i]) ** 2 / own - nats
        start[j] = int(gain.argmax())
        best[j] = gain[start[j]]
    edges = [n]
    while edges[-1] > 0:
        edges.append(int(start[edges[-1]]))
    return tuple(edges[::-1])
