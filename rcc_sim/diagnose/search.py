"""Screen every candidate by re-simulation; refine the best."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from rcc_sim.diagnose.candidates import Candidate
from rcc_sim.errors import InputError
from rcc_sim.diagnose.fit import Engine, Fit, Knob

Array = NDArray[np.float64]


@dataclass
class Screened:
    candidate: Candidate
    gain: float
    values: dict[str, float]


class Screen:
    """The linear neighbourhood of a fit, in which candidates compete."""

    def __init__(self, engine: Engine, base: Fit, knobs, signals: Array):
        self.engine, self.base, self.knobs, self.signals = (
            engine,
            base,
            list(knobs),
            signals,
        )
        self.r = engine.white(base.residual, base.whiteners)
        A = np.stack([engine.white(j, base.whiteners) for j in signals], axis=1)
        sd = np.array([k.sd for k in knobs])
        off = np.array([(base.values[k.key] - k.value) / k.sd for k in knobs])
        self.A = np.vstack([A, np.diag(1 / sd)])
        self.full = np.concatenate([self.r, off])
        self.Q, self.R = np.linalg.qr(self.A)
        self.left = self.project(self.full)
        self.excess = float(self.left @ self.left) - len(self.r)

    def project(self, x: Array) -> Array:
        return x - self.Q @ (self.Q.T @ x)

    def freed(self, key: str) -> int | None:
        return next((i for i, k in enumerate(self.knobs) if k.key == key), None)

    def delta(self, values: dict[str, float]) -> Array:
        e = self.engine.residual({**self.base.values, **values})
        d = self.engine.white(e - self.base.residual, self.base.whiteners)
        return self.project(np.concatenate([d, np.zeros(len(self.knobs))]))

    def gain(self, d: Array) -> float:
        """Nats gained by adding the signal d as it is."""
        return float(-(self.left @ d) - 0.5 * d @ d)

    def screen(self, candidate: Candidate) -> Screened:
        values: dict[str, float] = {}
        gain = 0.0
        for s in candidate.searches:
            try:
                g, x = self._one(s)
            except InputError:  # a strength that no vehicle of this kind can have
                continue
            if g > gain:
                gain, values = g, {s.key: x}
        return Screened(candidate, gain, values)

    def _one(self, s) -> tuple[float, float]:
        best = (0.0, s.neutral)
        at0 = self.base.values.get(s.key, s.neutral)
        if s.grid:
            tried = []
            for x in s.grid:
                g = self.gain(self.delta({s.key: x}))
                tried.append((g, x))
                if g > best[0]:
                    best = (g, x)
            return best
        x = s.first
        if not s.low <= x <= s.high or x == at0:
            return best
        for _ in range(7):
            d = self.delta({s.key: x})
            size = float(d @ d)
            if size < 1e-6 * 1:
                x = at0 + (x - at0) * 100
            else:
                share = -float(self.left @ d) / size
                g = self.gain(d)
                if g > best[0]:
                    best = (g, x)
                ideal = 0.5 * share**2 * size
                new = at0 + (x - at0) * share
                # a linear guess far out is not to be trusted
                ratio = min(max(share, -10.0), 10.0)
                new = at0 + (x - at0) * ratio
                if abs(share - 1) < 0.05 or ideal < 0.5:
                    break
                x = new
            clipped = min(max(x, s.low), s.high)
            if clipped == at0:
                break
            x = clipped
        return best
