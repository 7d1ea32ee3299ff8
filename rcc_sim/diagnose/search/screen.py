"""Every candidate, at likely strengths, re-simulated and held against a fit."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace
from math import sqrt
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from rcc_sim.diagnose.causes.candidates import Candidate
from rcc_sim.diagnose.causes.cause import ENOUGH
from rcc_sim.diagnose.causes.detect import Shown
from rcc_sim.diagnose.causes.sought import Search
from rcc_sim.diagnose.fitting.engine import Engine
from rcc_sim.diagnose.fitting.fit import Fit
from rcc_sim.errors import InputError

Array = NDArray[np.float64]

TRIES = 7
"""Linear guesses of a strength, one from the last, at most."""

UNSEEN, BOLDER = 1e-6, 100.0
"""Size, in squares of the noise's own, below which a signal is none, and times the
strength that is then tried."""

CLOSE, WORTH = 0.05, 0.5
"""Share of a strength, and nats, for which no further guess is made."""

TICK, FINER = 0.001, 9
"""Step [s], and steps to each side, by which a clock's period is found finer."""

CLOSER = 1.25, 1.12, 1.06, 1.03
"""Factors by which what is found on a grid is found finer, one after the other."""

ANOTHER = 5.0
"""Nats that one more figure of an effect must gain to join the others."""

STRAINED = -6.0
"""Logarithm of the prior of a fit whose figures may stand in for an effect: together
three and a half sds off."""

OUTWARD = 3.0
"""Times the best strength at which it is tried whether more gains more."""

FARTHEST = 10.0
"""Most that one try may reach beyond the last, in times its distance from neutral."""


ROOM = 1_000_000
"""Most rows, all channels together, of which what each figure changes is kept: 8
bytes a row and figure."""


class Promise(NamedTuple):
    """Nats that a slope promised, the figure's dotted key, and where to follow it from.

    From neutral on; or from a strength of a grid, to which no slope leads.
    """

    nats: float
    key: str
    start: float


class Slope(NamedTuple):
    """What a unit of a figure changes: d, whitened, beyond the knobs' reach; and -r·d.

    By the smallest step that was tried.
    """

    signal: Array
    lean: float
    step: float


@dataclass(frozen=True)
class Screened:
    """A candidate at its best strength.

    Parameters
    ----------
    candidate : Candidate
        The effect.
    gain : float
        Nats gained over the fit, the knobs giving way along their signals.
    values : dict
        Dotted key -> strength.
    shown : dict
        Dotted key -> what strengths that were tried would show.
    promised : Promise
        Most that a slope promised: more than ``gain`` where the knobs would have to
        give way along curves.
    slopes : dict
        Dotted key -> what a unit of it changes, of those that have a slope.
    """

    candidate: Candidate
    gain: float
    values: dict[str, float] = field(default_factory=dict)
    shown: dict[str, list[Shown]] = field(default_factory=dict)
    promised: Promise = field(default_factory=lambda: Promise(0.0, "", 0.0))
    slopes: dict[str, Slope] = field(default_factory=dict)


def shared(found: Sequence[Screened], effect: str) -> dict[str, float]:
    r"""Share of an effect's nats that each other gains at its best size.

    To first order, with signals d that the knobs cannot take up,

    .. math:: (d_1^T d_2)^2 / (d_1^T d_1 \, d_2^T d_2)

    the most of any two of their figures. A threshold on the way may hide what a slope
    shows: the screen then says less.

    Parameters
    ----------
    found : sequence of Screened
        Candidates with the signals that the screen took of their figures.
    effect : str
        Which of them the others are held against.

    Returns
    -------
    dict
        Effect -> share, of those that have a slope.
    """
    slopes = [(r.candidate.effect, x.signal) for r in found for x in r.slopes.values()]
    out: dict[str, float] = {}
    for mine in (d for name, d in slopes if name == effect):
        for name, d in slopes:
            share = float(mine @ d) ** 2 / (float(mine @ mine) * float(d @ d))
            out[name] = max(out.get(name, 0.0), share)
    return out


class Screen:
    """The neighbourhood of a fit, in which candidates compete.

    The knobs of the fit give way linearly and keep their priors: what they can take
    up counts for no candidate.
    """

    def __init__(self, engine: Engine, base: Fit) -> None:
        self.engine, self.base = engine, base
        self.start = engine.residuals(base.values, coarse=True)
        A = engine.whitened(base.signals, base.noise).white
        rows = np.hstack([A.T, np.diag(1 / base.prior_sd)])
        self.Q = np.asfortranarray(np.linalg.qr(rows.T).Q)  # column by column: faster
        r = engine.white(base.residuals, base.noise)
        self.left = self.free(np.concatenate([r, base.off / base.prior_sd]))
        self.shown: dict[str, list[Shown]] = {}
        self.promised: dict[str, Promise] = {}
        self.slopes: dict[str, Slope] = {}

    def free(self, x: Array) -> Array:
        """Return what the knobs cannot take up."""
        return x - self.Q @ (self.Q.T @ x)

    def signal(self, values: dict[str, float]) -> Array:
        """What some figures would change, whitened, beyond the knobs' reach."""
        e = self.engine.residuals({**self.base.values, **values}, coarse=True)
        pairs = zip(e, self.start, strict=True)
        d = self.engine.white([a - b for a, b in pairs], self.base.noise)
        d = self.free(np.concatenate([d, np.zeros(len(self.base.knobs))]))
        if len(values) == 1:
            (key, strength), *_ = values.items()
            self.shown.setdefault(key, []).append(Shown(strength, 0.5 * float(d @ d)))
        return d

    def gain(self, d: Array) -> float:
        """Nats gained by a signal as it is."""
        return float(-(self.left @ d) - 0.5 * (d @ d))

    def best(self, candidate: Candidate) -> Screened:
        """Return a candidate at its best strength, one figure at a time.

        Where several may be off, each further one that is worth it joins the best.
        """
        best = self.best_one(candidate, {})
        while candidate.several and best.values:
            more = self.best_one(candidate, best.values)
            if more.gain < best.gain + ANOTHER:
                break
            best = more
        keys = [search.key for search in candidate.searches]
        return replace(
            best,
            shown={key: self.shown.get(key, []) for key in keys},
            slopes={key: self.slopes[key] for key in keys if key in self.slopes},
            promised=max(self.promised.get(k, Promise(0.0, k, 0.0)) for k in keys),
        )

    def best_one(self, candidate: Candidate, held: dict[str, float]) -> Screened:
        """Return a candidate with one more figure than those that are held.

        Where several may be off, the first are the plainest.
        """
        best = Screened(candidate, 0.0)
        for search in candidate.beside(held):
            try:
                scan = self.scan if search.grid else self.seek
                gain, x = scan(search, held)
            except InputError:  # a strength that no such vehicle can have
                continue
            least = best.gain + ANOTHER * (candidate.several and best.gain > 0)
            if gain > least:
                best = Screened(candidate, gain, {**held, search.key: x})
        return best

    def scan(self, search: Search, held: dict[str, float]) -> tuple[float, float]:
        """Best of a grid: for thresholds, limits and clocks, which have no slope.

        Of clocks, from the quickest on, until one changes twice as much as is left,
        which gains nothing (Cauchy-Schwarz): a slower one changes no less. About what
        gains enough others are tried, ever closer: a delay beside commands that jump
        lies in a hollow of its own, out of which no slope leads. Not so of readings,
        which a part of a row makes smoother, and likelier so.
        """
        if search.stepped:
            return self.threshold(search, held)
        best = (0.0, 0.0)
        for x in map(float, search.grid):
            d = self.signal({**held, search.key: x})
            best = max(best, (self.gain(d), x))
            if search.clocked and d @ d > 4 * (self.left @ self.left):
                break
            if not (held or search.clocked):
                self.note(Promise(self.promise(d), search.key, x))
        if search.clocked and best[0] > 0:
            near = best[1] + TICK * np.arange(-FINER, FINER + 1)
            best = max(best, self.best_of(search.key, near[near > 0], held))
        elif best[0] > ENOUGH and search.acts != "rows":
            best = self.closer(best, search, held)
        return best

    def threshold(self, search: Search, held: dict[str, float]) -> tuple[float, float]:
        """Best of a grid of thresholds, and of others ever closer to it.

        Where none gains, to the one most like one that would: a threshold that acts too
        early or too late loses more than it gains elsewhere.
        """
        tried = []
        for x in search.grid:
            d = self.signal({**held, search.key: x})
            tried.append((self.promise(d), self.gain(d), float(x)))
        best = max((gain, x) for _, gain, x in tried)
        if best[0] <= 0:
            promise, gain, x = max(tried)
            if promise <= ENOUGH:
                return 0.0, 0.0
            best = (gain, x)
        return self.closer(best, search, held)

    def closer(
        self, best: tuple[float, float], search: Search, held: dict[str, float]
    ) -> tuple[float, float]:
        """Best strength about the best of a grid, ever closer to it."""
        for apart in CLOSER:
            near = best[1] * np.array([1 / apart, apart])
            inside = (near >= search.low) & (near <= search.high) & (near != best[1])
            best = max(best, self.best_of(search.key, near[inside], held))
        return best

    def note(self, one: Promise) -> None:
        """Keep the most that a figure promised."""
        self.promised[one.key] = max(self.promised.get(one.key, one), one)

    def note_slope(self, key: str, step: float, d: Array) -> None:
        """Keep what a figure changes, from the smallest step that was tried."""
        if len(d) > ROOM:
            return
        if key not in self.slopes or abs(step) < self.slopes[key].step:
            per = d / step
            self.slopes[key] = Slope(per, -float(self.left @ per), abs(step))

    def promise(self, d: Array) -> float:
        """Nats that a signal would gain at its best size."""
        return 0.5 * max(-float(self.left @ d), 0.0) ** 2 / (float(d @ d) or 1.0)

    def best_of(
        self, key: str, strengths: Iterable[float], held: dict[str, float]
    ) -> tuple[float, float]:
        """Best of some strengths and what it gains."""
        tried = [
            (self.gain(self.signal({**held, key: x})), float(x)) for x in strengths
        ]
        return max(tried, default=(0.0, 0.0))

    def seek(self, search: Search, held: dict[str, float]) -> tuple[float, float]:
        """Best strength by repeated linear guesses, from a likely one on."""
        start = self.base.values.get(search.key, search.neutral)
        before = self.signal(held) if held else 0.0
        best = (0.0, start)
        x = search.first
        bends, leapt = self.base.prior < STRAINED, False
        for _ in range(TRIES):
            x = min(max(x, search.low), search.high)
            if x == start:
                break
            whole = self.signal({**held, search.key: x})
            d = whole - before
            size = float(d @ d)
            if size < UNSEEN:
                x = start + (x - start) * BOLDER
                continue
            best = max(best, (self.gain(whole), x))
            if not held:
                self.note_slope(search.key, x - start, d)
            share = -float((self.left + before) @ d) / size
            promise = 0.5 * share**2 * size
            if abs(share) > 1 and not held:
                self.note(Promise(promise, search.key, start))
            if bends and abs(share) < 1 and size > 2 * ANOTHER:
                bends, leapt = False, True  # its slope at the start may be another
                x = start + (x - start) * sqrt(2 / size)
                continue
            if abs(share - 1) < CLOSE or promise < WORTH:
                break
            x = start + (x - start) * min(max(share, -FARTHEST), FARTHEST)
        while leapt and not held and best[0] > ANOTHER:
            # out of a hollow near the start, as limits and ticks make them
            x = min(max(start + OUTWARD * (best[1] - start), search.low), search.high)
            farther = self.gain(self.signal({search.key: x}))
            if farther <= best[0]:
                break
            best = (farther, x)
        return best
