"""Every candidate, at every likely strength, re-simulated and held against a fit."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from rcc_sim.diagnose.candidates import Candidate, Search
from rcc_sim.diagnose.engine import Engine, Fit
from rcc_sim.errors import InputError

Array = NDArray[np.float64]

TRIES = 7
TICK, FINER = 0.001, 9
"""Step [s], and steps to each side, by which a clock's period is found finer."""

FARTHEST = 10.0
"""Most that one try may reach beyond the last, in times its distance from neutral."""


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
    """

    candidate: Candidate
    gain: float
    values: dict[str, float] = field(default_factory=dict)


class Screen:
    """The neighbourhood of a fit, in which candidates compete.

    The knobs of the fit give way linearly and keep their priors: what they can take
    up counts for no candidate.
    """

    def __init__(self, engine: Engine, base: Fit) -> None:
        self.engine, self.base = engine, base
        self.start = engine.residuals(base.values, coarse=True)
        A = engine.whitened(base.signals, base.noise).white
        sd = np.array([k.sd for k in base.knobs])
        off = np.array([(base.values[k.key] - k.value) / k.sd for k in base.knobs])
        self.Q, _ = np.linalg.qr(np.vstack([A, np.diag(1 / sd)]))
        r = engine.white(base.residuals, base.noise)
        self.left = self.free(np.concatenate([r, off]))

    def free(self, x: Array) -> Array:
        """Return what the knobs cannot take up."""
        return x - self.Q @ (self.Q.T @ x)

    def signal(self, values: dict[str, float]) -> Array:
        """What some figures would change, whitened, beyond the knobs' reach."""
        e = self.engine.residuals({**self.base.values, **values}, coarse=True)
        pairs = zip(e, self.start, strict=True)
        d = self.engine.white([a - b for a, b in pairs], self.base.noise)
        return self.free(np.concatenate([d, np.zeros(len(self.base.knobs))]))

    def gain(self, d: Array) -> float:
        """Nats gained by a signal as it is."""
        return float(-(self.left @ d) - 0.5 * (d @ d))

    def best(self, candidate: Candidate) -> Screened:
        """Return a candidate at its best strength, one figure at a time."""
        best = Screened(candidate, 0.0)
        for search in candidate.searches:
            try:
                gain, x = self.scan(search) if search.grid else self.seek(search)
            except InputError:  # a strength that no such vehicle can have
                continue
            if gain > best.gain:
                best = Screened(candidate, gain, {search.key: x})
        return best

    def scan(self, search: Search) -> tuple[float, float]:
        """Best of a grid: for thresholds, limits and clocks, which have no slope."""
        best = self.best_of(search.key, search.grid)
        if search.clocked and best[0] > 0:
            near = best[1] + TICK * np.arange(-FINER, FINER + 1)
            best = max(best, self.best_of(search.key, near[near > 0]))
        return best

    def best_of(self, key: str, strengths: Iterable[float]) -> tuple[float, float]:
        """Best of some strengths and what it gains."""
        tried = [(self.gain(self.signal({key: x})), float(x)) for x in strengths]
        return max(tried, default=(0.0, 0.0))

    def seek(self, search: Search) -> tuple[float, float]:
        """Best strength by repeated linear guesses, from a likely one on."""
        start = self.base.values.get(search.key, search.neutral)
        best = (0.0, start)
        x = search.first
        for _ in range(TRIES):
            x = min(max(x, search.low), search.high)
            if x == start:
                break
            d = self.signal({search.key: x})
            size = float(d @ d)
            if size < 1e-6:
                x = start + (x - start) * 100
                continue
            best = max(best, (self.gain(d), x))
            share = -float(self.left @ d) / size
            if abs(share - 1) < 0.05 or 0.5 * share**2 * size < 0.5:
                break
            x = start + (x - start) * min(max(share, -FARTHEST), FARTHEST)
        return best
