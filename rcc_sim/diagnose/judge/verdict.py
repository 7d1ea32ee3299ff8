"""What is asserted: causes that stand, how sure, and the status of the whole."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from math import exp, hypot, inf
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from rcc_sim.analyse.logcheck.finding import Finding
from rcc_sim.definitions.figure import Z_90
from rcc_sim.diagnose.causes.cause import (
    ANOTHER_VEHICLE,
    ENOUGH,
    Cause,
    left_by_stronger,
)
from rcc_sim.diagnose.fitting.fit import Fit
from rcc_sim.diagnose.fitting.knobs import Knob
from rcc_sim.diagnose.judge.energies import SHRUNK, stays_off
from rcc_sim.diagnose.judge.ties import Rival
from rcc_sim.diagnose.profiles.remainder import Remainder
from rcc_sim.diagnose.search.screen import CLOSER, TICK
from rcc_sim.physics.effect import Effect
from rcc_sim.physics.effects import EFFECTS, neutral_of
from rcc_sim.units import unit_of

Array = NDArray[np.float64]

DOUBTLESS = 1.5
"""Times its expanded uncertainty from which on an energy gap is one, whatever the rows
say: three standard uncertainties. In 260 drives without a cause the largest is 2.9."""

TOLERATED = 5.0
"""Standard deviations up to which tolerances may explain a gap, each and all together.
Of 978 drives of the blind plant in which nothing unknown acts five have more at most;
in four of these one of two causes is missed."""

LEAST_SURE, EVEN, SUREST = 0.01, 0.5, 0.995
"""Least and largest probability that is stated: nats are surer than any model; and the
largest of a cause that needs another vehicle."""

SOFT = 4.0
"""Nats by which odds grow by e: model error blunts a likelihood by about so much."""

EQUAL = 1.0
"""Nats within which two are equally likely."""

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


UNSURE = "of one cause the chances are even"
"""What is said of a cause that is as likely as not."""


class Verdict(NamedTuple):
    """What a diagnosis comes to.

    Attributes
    ----------
    status : str
        no_gap, explained, partly_explained or unexplained.
    short : tuple of str
        In what the causes come short of explaining all, in words.
    """

    status: str
    short: tuple[str, ...] = ()


def verdict(
    causes: list[Cause],
    left: Remainder,
    before: float | None = None,
    after: float | None = None,
    *,
    doubtless: bool = True,
    noise: float = inf,
    large: bool = False,
    explained: float = 1.0,
    ends: bool = False,
    farthest: float = 0.0,
    disagree: bool = False,
    even: bool = False,
    wanders: bool = False,
) -> Verdict:
    """Return the status, and what the causes come short of.

    ``before`` and ``after`` are the energy gap [%] on rows that no fit saw. What does
    not shrink there, if it is ``doubtless`` or stays beyond ``noise`` [%], is not
    explained, nor what grows; nor is what does not shrink row by row (``explained``, a
    share), nor by a cause that ``ends`` where its search does, nor where stated
    figures are ``farthest`` off by more sds than is tolerated, nor where logs, or a
    channel and the model, ``disagree``, nor by a cause of which the chances are
    ``even``. A gap is ``large`` if it is one whatever the rows say; what no tolerance
    takes is one as well, and what ``wanders`` where the model has all commands.
    """
    if not causes:
        real = left.is_real or large or farthest > TOLERATED or disagree or wanders
        return Verdict("unexplained" if real else "no_gap")
    stays = stays_off(before, after, noise, doubtless=doubtless)
    short = {
        "structure remains that this does not explain": left.is_real,
        "where no fit saw, more than a third of what is beyond noise stays":
            explained < 1 - SHRUNK,
        "the energy of rows that no fit saw stays off": stays,
        "a figure ends where its search does": ends,
        UNSURE: even,
        "stated figures are too far off": farthest > TOLERATED,
        "logs, or channels, contradict what was found": disagree,
    }  # fmt: skip
    told = tuple(reason for reason, holds in short.items() if holds)
    return Verdict("partly_explained" if told else "explained", told)


def of_another(findings: Iterable[Finding]) -> str:
    """Return what a check found of another vehicle; else nothing."""
    kinds = "other_battery", "other_vehicle"
    return next((f"{f.channel} {f.what}" for f in findings if f.kind in kinds), "")


def ends_early(cause: Cause, fit: Fit, known: Mapping[str, Effect]) -> bool:
    """Tell whether a figure ends where its search does, short of the effect's bounds.

    What asks for more is not that figure.
    """
    for knob in (k for k in fit.knobs if k.key in cause.keys):
        _, effect, name = knob.key.split(".")
        x = fit.values[knob.key]
        if x in (knob.low, knob.high) and x not in known[effect].param(name).bounds:
            return True
    return False


def chances_of(
    causes: Sequence[Cause],
    left: Remainder,
    farthest: float,
    doubtful: Sequence[bool],
) -> list[float]:
    """Return the probability of each cause; of a ``doubtful`` one even at most."""
    return [
        probability(
            c, left, farthest, doubtful=doubt, spared=left_by_stronger(c, causes)
        )
        for c, doubt in zip(causes, doubtful, strict=True)
    ]


def probability(
    cause: Cause,
    left: Remainder,
    farthest: float = 0.0,
    *,
    doubtful: bool = False,
    spared: float = 0.0,
) -> float:
    """Return the probability that a cause, or one tied with it, acts.

    An even chance at most where it is ``doubtful``, as where it ends as its search
    does, or beside stated figures that are ``farthest`` off by as many sds as another
    vehicle's: one of them stands for what is not known. Of what is left so many nats
    are ``spared``, that stronger causes may leave. Nats by which stated figures go back
    count twice against no effect at all, as where it was taken in.
    """
    clear = cause.gain - cause.rival if cause.rival else inf  # no other gains a nat
    margin = min(cause.gain + cause.eased - 0.5 * ENOUGH, clear)
    if abs(margin) < EQUAL:
        margin = 0.0
    chance = 1 / (1 + exp(-min(margin, 200.0) / SOFT))
    if cause.profiles:  # something unknown of the same course is no likelier
        chance = max(chance, EVEN)
    if left.is_real:
        unknown = max(left.against(cause.effect, cause.shares) - spared, 0.0)
        chance *= cause.gain / (cause.gain + unknown)
    most = EVEN if doubtful or farthest > ANOTHER_VEHICLE else SUREST
    return min(max(chance, LEAST_SURE), most)


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
    neutral = {k.rpartition(".")[2]: neutral_of(k, known) for k in cause.keys}
    return all(e.low <= neutral[name] <= e.high for name, e in found.items())


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
