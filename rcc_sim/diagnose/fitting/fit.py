"""What a fit found, and how residuals change with its figures."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from math import hypot, inf, sqrt
from typing import NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from rcc_sim.diagnose.fitting.knobs import Knob
from rcc_sim.diagnose.noise.whitener import Whitener, weights

Array = NDArray[np.float64]

Free: TypeAlias = Sequence[tuple[Knob, list[Array]]]
"""Figures that are free beside those of a fit, and what each does to each track."""

RIDGE, FIRM = 1e-10, 1e-9
"""Added to a diagonal of ones, for figures of which nothing is known; and where a step
is taken by it."""


class Weighted(NamedTuple):
    """Rows of a track, whitened and weighed.

    Attributes
    ----------
    root : ndarray, shape (n,)
        Roots of the rows' weights, by which the others are multiplied.
    residual : ndarray, shape (n,)
    signals : ndarray, shape (n, k)
        d(residual)/d(knob).
    """

    root: Array
    residual: Array
    signals: Array


@dataclass(frozen=True)
class Fit:
    """Figures found, and what they leave.

    Parameters
    ----------
    values : dict
        Knob -> figure.
    knobs : tuple of Knob
        What could move.
    loglik, prior : float
        Log-likelihood of the residuals and log-prior of the figures.
    noise : list of Whitener
        Noise model of each track.
    residuals : list of ndarray
        Measured minus predicted, a track each (a channel of a log).
    information : ndarray (k, k)
        Curvature of the log-posterior at the figures.
    signals : list of list of ndarray
        d(residual)/d(knob), per knob and track.
    near : bool
        Whether those were found near the figures: a step away that gained little.
    """

    values: dict[str, float]
    knobs: tuple[Knob, ...]
    loglik: float
    prior: float
    noise: list[Whitener]
    residuals: list[Array]
    information: Array = field(default_factory=lambda: np.zeros((0, 0)))
    signals: list[list[Array]] = field(default_factory=list)
    near: bool = False

    @property
    def score(self) -> float:
        """Log-posterior, up to a constant."""
        return self.loglik + self.prior

    @property
    def off(self) -> Array:
        """How far the figures are from what is expected of them, shape (k,)."""
        return np.array([self.values[k.key] - k.value for k in self.knobs])

    @property
    def prior_sd(self) -> Array:
        """Standard deviations of what is expected of them, shape (k,)."""
        return np.array([k.sd for k in self.knobs])

    @property
    def asleep(self) -> list[int]:
        """Which of the stated figures change nothing where they are stated."""
        if len(self.signals) != len(self.knobs):
            return []
        return [
            i
            for i, (knob, tracks) in enumerate(
                zip(self.knobs, self.signals, strict=True)
            )
            if knob.sd < inf
            and self.values[knob.key] == knob.value
            and not any(np.nan_to_num(x).any() for x in tracks)
        ]

    def signals_in(self, track: int) -> Array:
        """Return d(residual)/d(knob) in a track, shape (n, k)."""
        rows = len(self.residuals[track])
        signals = [signal[track] for signal in self.signals]
        return np.array(signals).reshape(len(signals), rows).T

    def weighted(self, track: int, noise: Whitener, left: Array) -> Weighted:
        """Return the rows of a track by a noise, weighed by what is left of them."""
        if noise is not self.noise[track] or left is not self.residuals[track]:
            return self._weighted(track, noise, left)
        if track not in self._by_own_noise:
            self._by_own_noise[track] = self._weighted(track, noise, left)
        return self._by_own_noise[track]

    def _weighted(self, track: int, noise: Whitener, left: Array) -> Weighted:
        W = np.sqrt(weights(noise(left)))
        J = noise(self.signals_in(track))
        return Weighted(W, W * noise(self.residuals[track]), W[:, None] * J)

    def told_by(self, track: int) -> tuple[Array, Array]:
        """Return what a track says of the knobs x: |R x + s|², R (m, k) and s (m,)."""
        if track not in self._told:
            noise, left = self.noise[track], self.residuals[track]
            _, r, J = self.weighted(track, noise, left)
            Q, R = np.linalg.qr(J)
            self._told[track] = R, Q.T @ r
        return self._told[track]

    @cached_property
    def _by_own_noise(self) -> dict[int, Weighted]:
        return {}

    @cached_property
    def _told(self) -> dict[int, tuple[Array, Array]]:
        return {}

    def holding(self, *keys: str) -> Fit:
        """Return the same with some figures held where they are."""
        kept = [i for i, k in enumerate(self.knobs) if k.key not in keys]
        return replace(
            self,
            knobs=tuple(self.knobs[i] for i in kept),
            information=self.information[np.ix_(kept, kept)],
            signals=[self.signals[i] for i in kept],
        )

    def beside(self, more: Free) -> Fit:
        """Return the same with more figures free, each with what it does to a track."""
        knobs = [knob for knob, _ in more]
        return replace(
            self,
            values=self.values | {k.key: k.value for k in knobs},
            knobs=(*self.knobs, *knobs),
            signals=[*self.signals, *(signal for _, signal in more)],
        )

    def without(self, keys: Sequence[str]) -> Fit:
        """Return the same without some figures, in whose place others act."""
        left = {k: x for k, x in self.values.items() if k not in keys}
        return replace(self.holding(*keys), values=left)

    def sd(self, key: str) -> float:
        """Standard deviation of a figure, the others being free."""
        return float(self.sds()[[k.key for k in self.knobs].index(key)])

    def sd_among(self, others: Sequence[Fit], key: str) -> float:
        """Standard deviation of a figure where other fits may be the right one.

        All are as likely: of the squares of their sds, and of how far they are off this
        one, it is the root of the mean.
        """
        x, alike = self.values[key], [f for f in (self, *others) if f.frees(key)]
        off = [part for f in alike for part in (f.sd(key), f.values[key] - x)]
        return hypot(*off) / sqrt(len(alike))

    def frees(self, key: str) -> bool:
        """Tell whether a figure was fitted."""
        return any(k.key == key for k in self.knobs)

    def sds(self) -> Array:
        """Standard deviations of all figures, each with the others free."""
        scaled, unit = of_unit_diagonal(self.information)
        spread: Array = np.sqrt(np.diag(np.linalg.inv(scaled))) * unit
        return spread


def of_unit_diagonal(A: Array, ridge: float = RIDGE) -> tuple[Array, Array]:
    """Return a curvature in units in which its diagonal is 1, and those units.

    Where one figure is counted in kilograms and another in radians, solving would cost
    digits else.
    """
    unit = 1 / np.sqrt(np.diag(A) + 1e-300)
    return A * np.outer(unit, unit) + ridge * np.eye(len(A)), unit


@dataclass(frozen=True)
class Tangent:
    """How residuals change with some knobs: as they are, and whitened (rows, knobs)."""

    signals: list[list[Array]]
    white: Array

    def but(self, which: Sequence[int]) -> Tangent:
        """Return it without some of the knobs."""
        kept = [i for i in range(len(self.signals)) if i not in which]
        return Tangent([self.signals[i] for i in kept], self.white[:, kept])

    def __add__(self, other: Tangent) -> Tangent:
        return Tangent(
            self.signals + other.signals, np.hstack([self.white, other.white])
        )
