"""A cause that varies over a drive, as it was found: how strong it acted, and when."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from math import inf
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rcc_sim.diagnose.causes.strengths import WINDS, Prior, likeliest
from rcc_sim.diagnose.fitting.engine import Engine
from rcc_sim.diagnose.noise.whitener import Whitener
from rcc_sim.diagnose.residuals.problem import Problem

Array = NDArray[np.float64]

OWN = 0.04
"""Least share of a knot's variance that counts as its own, not as that of all of
them: what they have in common is no better known."""


@dataclass(frozen=True)
class Profile:
    """Strength of an effect over some coordinate, above what a fit holds.

    Parameters
    ----------
    key : str
        Dotted key of the figure that varies.
    along : str
        Coordinate: time_s, distance_m, speed_mps, steer_cmd_rad.
    knots, value, sd : ndarray, shape (k,)
        Coordinate, strength there, standard deviation.
    evidence : float
        Log of the marginal likelihood ratio to no profile. [nats]
    beside_drift : bool
        Whether it was weighed together with the drift of a sensor.
    normal : tuple of ndarray or None
        Normal equations of the strengths; None where they were weighed with the noise.
    held : ndarray or None
        What holds their sum (``strengths.Prior``).
    mean_sd : float
        Standard deviation of their mean, by which all may be off together.
    weighed : bool
        Whether it was weighed together with the noise that it leaves.
    """

    key: str
    along: str
    knots: Array
    value: Array
    sd: Array
    evidence: float
    beside_drift: bool = False
    normal: tuple[Array, Array] | None = None
    held: Array | None = None
    mean_sd: float = 0.0
    weighed: bool = False

    @property
    def mean(self) -> float:
        """Mean strength along the coordinate, from the first knot to the last."""
        return mean_over(self.knots, self.value)

    @property
    def rms(self) -> float:
        """Root mean square of the strength, likewise."""
        return float(np.sqrt(mean_over(self.knots, self.value**2)))

    @property
    def coherence(self) -> float:
        """Nats by which strengths that change little from knot to knot are likelier.

        Than such as know nothing of each other; infinite if weighed with the noise.
        """
        if self.normal is None:
            return inf
        apart = Prior(np.eye(len(self.knots)), self.held)
        return self.evidence - likeliest(*self.normal, apart)[0]

    @property
    def own_sd(self) -> Array:
        """Standard deviation at each knot, without what all have in common."""
        least = OWN * self.sd**2
        shared = min(self.mean_sd, float(self.sd.max(initial=0.0)))
        own: Array = np.sqrt(np.maximum(self.sd**2 - shared**2, least))
        return own

    def at(self, x: Array) -> Array:
        """Strength at a coordinate; the ends hold beyond them."""
        return np.interp(x, self.knots, self.value)

    @property
    def half_way(self) -> Array:
        """Coordinates at which it is half-way between its least and its greatest.

        >>> x, y = np.array([0.0, 10.0, 20.0]), np.array([1.0, 1.0, 3.0])
        >>> Profile("", "time_s", x, y, 0 * y, 0.0).half_way.tolist()
        [15.0]
        """
        off = self.value - 0.5 * (self.value.min() + self.value.max())
        i = np.flatnonzero(off[:-1] * off[1:] < 0)
        share = off[i] / (off[i] - off[i + 1])
        at: Array = self.knots[i] + share * np.diff(self.knots)[i]
        return at

    def raised(self, level: float) -> Profile:
        """Return it on top of so much more."""
        return replace(self, value=self.value + level)

    def document(self) -> dict[str, Any]:
        """Return what JSON says of it: a figure, and by how much it is off, and where.

        >>> x, y = np.array([0.0, 10.0]), np.array([1.0, 2.0])
        >>> Profile("effects.a.b", "time_s", x, y, 0 * y, 0.0).document()["at"]
        [0.0, 10.0]
        """
        told = {"at": self.knots, "value": self.value, "sd": self.sd}
        lists = {name: x.tolist() for name, x in told.items()}
        return {"figure": self.key, "along": self.along} | lists

    def cut_to(self, low: float, high: float) -> tuple[Profile, Profile]:
        """Return it where it is possible, else at the nearest bound; and the rest."""
        possible = np.clip(self.value, low, high)
        beyond = self.value - possible
        return replace(self, value=possible), replace(self, value=beyond)

    @property
    def reversed(self) -> Profile:
        """What takes it back."""
        return replace(self, value=-self.value)

    def plus(self, more: Profile) -> Profile:
        """Return it with more of the same effect, found in what it left."""
        knots = np.union1d(self.knots, more.knots)
        value = self.at(knots) + more.at(knots)
        sd = np.interp(knots, more.knots, more.sd)
        return replace(
            self, knots=knots, value=value, sd=sd, normal=None, mean_sd=more.mean_sd
        )

    def clear_at(self, x: Array, times: float = 2.0) -> NDArray[np.bool_]:
        """Tell where the strength is beyond some standard deviations.

        Of nil, or of what it usually is: that of all knots together, which a tolerance
        may make up for, is then no doubt.
        """
        usual = float(np.median(self.value))
        sd, own = (np.interp(x, self.knots, y) for y in (self.sd, self.own_sd))
        value = self.at(x)
        apart = (np.abs(value - usual) > times * own) & (np.abs(value) > abs(usual))
        return apart | (np.abs(value) > times * sd)


def mean_over(x: Array, y: Array) -> float:
    """Mean of y over x, straight between its knots; a car that stands has one place."""
    length = float(x[-1] - x[0])
    return float(np.trapezoid(y, x)) / length if length else float(np.mean(y))


def shares(signal: list[Array], noise: list[Whitener]) -> Array:
    """Share of each track in the power of a signal, whitened."""
    power = np.array(
        [float((w(e) ** 2).sum()) for e, w in zip(signal, noise, strict=True)]
    )
    return power / (power.sum() or 1.0)


def overlap(a: Array, b: Array) -> float:
    """Part of two signals that sits in the same tracks: 1 alike, 0 apart.

    Bhattacharyya's coefficient of their shares: who acts in the same tracks is alike,
    if more in some and less in others.
    """
    return float(np.sqrt(a * b).sum())


def acted_on(problem: Problem, profile: Profile) -> Problem:
    """The same drive with a profile acting: its road, a load on top, or a wind.

    On a way back, slope and wind are those of the way out.
    """
    sign = -1.0 if problem.drive.back else 1.0
    if profile.along == "distance_m":
        return problem.on_road(profile.knots, sign * profile.value)
    more = profile.at(problem.coordinate(profile.along))
    if profile.key in WINDS:
        return problem.in_wind(sign * more)
    return problem.with_load(more)


def with_acting(engine: Engine, profiles: Mapping[int, Profile]) -> Engine:
    """Return the same logs with profiles acting on them."""
    problems = list(engine.problems)
    for i, profile in profiles.items():
        problems[i] = acted_on(problems[i], profile)
    return Engine(problems)
