"""What is asserted: causes that stand, and their figures with their intervals."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from math import hypot
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rcc_sim.definitions.figure import Z_90
from rcc_sim.diagnose.causes.cause import Cause
from rcc_sim.diagnose.fitting.fit import Fit
from rcc_sim.diagnose.fitting.knobs import Knob
from rcc_sim.diagnose.judge.ties import Rival
from rcc_sim.diagnose.search.screen import CLOSER, TICK
from rcc_sim.physics.effect import Effect
from rcc_sim.physics.effects import EFFECTS, nil_of
from rcc_sim.units import unit_of

Array = NDArray[np.float64]

ROW_SHARE = 0.2
"""Share of a log's rows to which a time is told, one sd: when within a row a command
came or a reading was taken, no log says."""

INTERVAL = 1.45
"""Factor on standard deviations for what a model leaves out; from ``blind score``."""


@dataclass(frozen=True)
class Estimate:
    """A figure found, with its 90 % interval; ``stated`` is the vehicle file's.

    Of one that varies the mean, and the ``least`` and ``most`` over the drive; over all
    drives, where there are several, and in ``each``.
    """

    value: float
    low: float
    high: float
    sd: float
    stated: float | None = None
    least: float | None = None
    most: float | None = None
    each: tuple[Estimate, ...] = ()

    def document(self) -> dict[str, Any]:
        """Return what ``--json`` prints of it."""
        told: dict[str, Any] = {"value": self.value, "low": self.low, "high": self.high}
        names = ("stated", "least", "most")
        told |= {n: x for n in names if (x := getattr(self, n)) is not None}
        return told | ({"logs": [e.document() for e in self.each]} if self.each else {})


@dataclass(frozen=True)
class Asserted:
    """A cause that stands.

    Parameters
    ----------
    cause : Cause
        The effect and what it gained.
    probability : float
        That it, or one it is tied with, acts.
    figures : dict
        Parameter -> estimate.
    instead : dict
        Effect that the logs cannot tell from it -> the same of that, in its place.
    alike : tuple of Fit
        All figures with each of those in its place.
    """

    cause: Cause
    probability: float
    figures: dict[str, Estimate]
    instead: dict[str, dict[str, Estimate]] = field(default_factory=dict)
    alike: tuple[Fit, ...] = ()

    @property
    def parameters(self) -> dict[str, dict[str, Any]]:
        """What ``--json`` prints of its figures."""
        return {name: x.document() for name, x in self.figures.items()}


def estimates(
    fit: Fit,
    cause: Cause,
    stated: Mapping[str, float],
    row: float = 0.0,
    others: Sequence[Fit] = (),
) -> dict[str, Estimate]:
    """Return the figures of a cause with their intervals.

    ``stated`` holds what the vehicle file states: a profile acts on top of it. ``row``
    is the time between two rows of the log, or over which a drive is smeared. [s]
    ``others`` are fits that the logs cannot tell from this one.
    """
    out = {}
    knobs = {k.key: k for k in fit.knobs}
    for key in cause.keys:
        name = key.rpartition(".")[2]
        if cause.profiles:
            out[name] = _of_profile(fit, key, cause, stated.get(key, 0.0))
        elif key in knobs:
            value = fit.values[key]
            own = fit.sd_among(others, key) * INTERVAL
            sd = hypot(own, resolution(knobs[key], value, row))
            sd = min(sd, knobs[key].high - knobs[key].low)
            low = max(value - Z_90 * sd, knobs[key].low)
            high = min(value + Z_90 * sd, knobs[key].high)
            out[name] = Estimate(value, min(low, value), max(high, value), sd)
        else:  # a clock's period, found by trying
            value = fit.values[key]
            out[name] = Estimate(value, value - TICK, value + TICK, 0.5 * TICK)
        out[name] = replace(out[name], stated=stated.get(key))
    return out


def asserted_of(
    fit: Fit,
    causes: Sequence[Cause],
    rivals: Mapping[str, Sequence[Rival]],
    stated: Mapping[str, float],
    row: float,
    chances: Sequence[float],
) -> tuple[Asserted, ...]:
    """Return causes with their chances, figures, and what could stand in their place.

    Parameters
    ----------
    fit : Fit
        Tolerances and causes.
    causes : sequence of Cause
        Strongest first.
    rivals : mapping
        Cause -> other effects in its place.
    stated, row
        As for :func:`estimates`.
    chances : sequence of float
        Probability of each.
    """
    alike = {
        c.effect: [r for r in rivals.get(c.effect, ()) if r.effect in c.tied]
        for c in causes
    }

    def one(cause: Cause, chance: float) -> Asserted:
        tied = alike[cause.effect]
        beside = [r.fit for e, own in alike.items() if e != cause.effect for r in own]
        instead = {
            r.effect: estimates(r.fit, r.in_place_of(cause), stated, row) for r in tied
        }
        figures = estimates(fit, cause, stated, row, beside)
        return Asserted(cause, chance, figures, instead, tuple(r.fit for r in tied))

    return tuple(map(one, causes, chances))


def may_be_nil(
    fit: Fit,
    cause: Cause,
    stated: Mapping[str, float],
    row: float,
    known: Mapping[str, Effect],
) -> bool:
    """Tell whether all figures of a constant cause may be as if it were not there.

    A delay of a fraction of a row may be gained by what another effect does a little
    otherwise than its model: beside a stronger cause it is none.
    """
    if cause.profiles:
        return False
    found = estimates(fit, cause, stated, row)
    nil = {k.rpartition(".")[2]: nil_of(k, known) for k in cause.keys}
    return all(e.low <= nil[name] <= e.high for name, e in found.items())


def resolution(knob: Knob, value: float, row: float) -> float:
    """How exactly a figure can be told at all, one sd, whatever the curvature says."""
    if knob.is_stepped:
        return (CLOSER[-1] - 1) * abs(value)
    return ROW_SHARE * row if unit_of(knob.key) == "s" else 0.0


def _of_profile(fit: Fit, key: str, cause: Cause, stated: float) -> Estimate:
    """Mean and ends of profiles and what they act on: fitted, else as stated.

    Of several logs the mean over all that tell it, each as long as it is; what puts one
    off may put off all. One whose interval is all that the effect allows tells nothing.
    """
    bounds = EFFECTS[cause.effect].param(key.rpartition(".")[2]).bounds
    base = fit.values.get(key, stated)

    def estimate(mean: float, sd: float, values: Array) -> Estimate:
        told = [mean, mean - Z_90 * sd, mean + Z_90 * sd, values.min(), values.max()]
        value, low, high, least, most = np.clip(np.add(told, base), *bounds).tolist()
        return Estimate(value, low, high, sd, least=least, most=most)

    profiles = [cause.profiles[i] for i in sorted(cause.profiles)]
    each = tuple(estimate(p.mean, INTERVAL * p.mean_sd, p.value) for p in profiles)
    if len(each) == 1:
        return each[0]
    told = [p for p, e in zip(profiles, each, strict=True) if (e.low, e.high) != bounds]
    told = told or profiles
    long = [p.knots[-1] - p.knots[0] for p in told]
    mean = float(np.average([p.mean for p in told], weights=long))
    sd = INTERVAL * float(np.average([p.mean_sd for p in told], weights=long))
    whole = estimate(mean, sd, np.concatenate([p.value for p in told]))
    return replace(whole, each=each)
