"""What a diagnosis comes to: no gap, one explained, in part, or not at all."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from math import inf
from typing import NamedTuple

from rcc_sim.analyse.logcheck.finding import Finding
from rcc_sim.diagnose.causes.cause import Cause
from rcc_sim.diagnose.judge.energies import SHRUNK, stays_off
from rcc_sim.diagnose.profiles.remainder import Remainder

DOUBTLESS = 1.5
"""Times its expanded uncertainty from which on an energy gap is one, whatever the rows
say: three standard uncertainties. In 260 drives without a cause the largest is 2.9."""

TOLERATED = 5.0
"""Standard deviations up to which tolerances may explain a gap, each and all together.
Of 978 drives of the blind plant in which nothing unknown acts five have more at most;
in four of these one of two causes is missed."""

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


@dataclass(frozen=True)
class Signs:
    """What speaks for a gap, or against its being explained, beside what is left.

    Parameters
    ----------
    before, after : float or None
        Energy gap on rows that no fit saw. [%]
    doubtless : bool
        It is a gap beyond doubt.
    noise : float
        What noise alone may make of it. [%]
    large : bool
        A gap is one whatever the rows say (``DOUBTLESS``).
    explained : float
        Share of what is beyond noise on such rows that is gone, row by row.
    ends : bool
        A figure of a cause ends where its search does.
    farthest : float
        Standard deviations by which stated figures are off, alone or together.
    disagree : bool
        Logs, or a channel and the model, contradict each other.
    even : bool
        The chances of a cause are even.
    wanders : bool
        What is left wanders where the model has all commands.
    taken_up : bool
        Of an energy gap that is one whatever the rows say, causes leave as much: stated
        figures, or nothing, take it up.
    """

    before: float | None = None
    after: float | None = None
    doubtless: bool = True
    noise: float = inf
    large: bool = False
    explained: float = 1.0
    ends: bool = False
    farthest: float = 0.0
    disagree: bool = False
    even: bool = False
    wanders: bool = False
    taken_up: bool = False


def verdict(causes: Sequence[Cause], left: Remainder, signs: Signs) -> Verdict:
    """Return the status, and what the causes come short of.

    Without a cause there is a gap if something real is left, or by any of the signs.
    With causes it is explained in part if something speaks against them: an energy that
    does not shrink where no fit saw and is beyond doubt, or stays beyond noise, or
    grows; rows of which more than a third of what is beyond noise stays.
    """
    far = signs.farthest > TOLERATED
    if not causes:
        gap = signs.large or far or signs.disagree or signs.wanders
        return Verdict("unexplained" if left.is_real or gap else "no_gap")
    before, after, doubtless = signs.before, signs.after, signs.doubtless
    short = {
        "structure remains that this does not explain": left.is_real,
        "where no fit saw, more than a third of what is beyond noise stays":
            signs.explained < 1 - SHRUNK,
        "the energy of rows that no fit saw stays off":
            stays_off(before, after, signs.noise, doubtless=doubtless),
        "a figure ends where its search does": signs.ends,
        UNSURE: signs.even,
        "stated figures are too far off": far,
        "stated figures, not what was found, take up an energy gap beyond doubt":
            signs.taken_up,
        "logs, or channels, contradict what was found": signs.disagree,
    }  # fmt: skip
    told = tuple(reason for reason, holds in short.items() if holds)
    return Verdict("partly_explained" if told else "explained", told)


def of_another(findings: Iterable[Finding]) -> str:
    """Return what a check found of another vehicle; else nothing."""
    kinds = "other_battery", "other_vehicle"
    return next((f"{f.channel} {f.what}" for f in findings if f.kind in kinds), "")
