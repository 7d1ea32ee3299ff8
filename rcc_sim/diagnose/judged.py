"""How sure causes are that stand, their figures, and what a diagnosis comes to."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from itertools import accumulate
from math import inf
from operator import or_
from typing import NamedTuple

from rcc_sim.analyse.gap import Gap
from rcc_sim.analyse.logcheck.finding import Finding
from rcc_sim.diagnose.causes.cause import Cause
from rcc_sim.diagnose.causes.prices import prices
from rcc_sim.diagnose.fitting.fit import Fit
from rcc_sim.diagnose.fitting.pulls import farthest, moved, moved_together
from rcc_sim.diagnose.fitting.tips import no_surer
from rcc_sim.diagnose.judge.apart_from_nil import apart_from_nil
from rcc_sim.diagnose.judge.asserted import Asserted, asserted_of
from rcc_sim.diagnose.judge.chances import EVEN, chances_of, ends_early
from rcc_sim.diagnose.judge.direct import felt_otherwise
from rcc_sim.diagnose.judge.mean_slope import mean_slopes
from rcc_sim.diagnose.judge.misread import findings_of
from rcc_sim.diagnose.judge.restless import is_doubtful, restless
from rcc_sim.diagnose.judge.verdict import (
    DOUBTLESS,
    Signs,
    Verdict,
    of_another,
    verdict,
)
from rcc_sim.diagnose.profiles.altimeter import Wander
from rcc_sim.diagnose.profiles.remainder import Remainder
from rcc_sim.diagnose.proof.by_log import noise_of
from rcc_sim.diagnose.proof.proven import Proven
from rcc_sim.diagnose.residuals.posed import at_own_rows
from rcc_sim.diagnose.residuals.problem import Problem
from rcc_sim.diagnose.residuals.sizes import size_of
from rcc_sim.diagnose.search.compete import Explanation


class Judged(NamedTuple):
    """What is said of causes that stand, beside what they leave.

    Attributes
    ----------
    gaps : tuple of Gap
        With what is to be said of each log once it is explained.
    left : Remainder
        What no cause explains.
    fit : Fit
        Tolerances and causes, none of them surer than it is.
    asserted : tuple of Asserted
        The causes, with their chances and figures.
    verdict : Verdict
        What all that comes to.
    """

    gaps: tuple[Gap, ...]
    left: Remainder
    fit: Fit
    asserted: tuple[Asserted, ...]
    verdict: Verdict


def judged(
    kept: Proven,
    found: Explanation,
    gaps: Sequence[Gap],
    wanders: Mapping[int, Wander],
    stated: Mapping[str, float],
    plain: Sequence[Problem],
) -> Judged:
    """Return how sure causes are that stand, their figures, and the verdict.

    Parameters
    ----------
    kept : Proven
        What stands, and what rows that no fit saw say of it.
    found : Explanation
        What the competition ended with.
    gaps : sequence of Gap
        Of each log, by the vehicle as it is stated.
    wanders : mapping
        Log -> by how much its heights are off, as far as its tolerances alone tell.
    stated : mapping
        Dotted key -> what the vehicle file states.
    plain : sequence of Problem
        Each log and the nominal vehicle, without any profile that was found.
    """
    engine, causes, left = kept.stands.engine, kept.stands.causes, kept.stands.left
    doubtless, known = is_doubtless(gaps), engine.vehicle.known
    if not causes and doubtless:
        left = replace(left, opens_gap=True)
    wanders = {r.log: r.heights for r in left.rivals if r.heights} | dict(wanders)
    loose = restless(engine, kept.stands.fit, found.null)
    fit = kept.stands.fit
    said = partial(findings_of, engine, fit, wanders, causes, left, loose)
    gaps = with_findings(gaps, said)
    findings = [f for g in gaps for f in g.findings]
    kinds = {f.kind for f in findings}
    fit = no_surer(engine, fit, {k for c in causes for k in c.keys})
    farthest = farthest_moved(fit, stated, gaps)
    # what was found beside a stronger cause that ends is no surer than that
    early = [*accumulate((ends_early(c, fit, known) for c in causes), or_)]
    doubtful = [
        end or kept.unproven or is_doubtful(c, loose) or felt_otherwise(c, findings)
        for c, end in zip(causes, early, strict=True)
    ]
    chances = chances_of(causes, left, farthest, doubtful)
    row = size_of(engine.problems[0], "row")
    asserted = asserted_of(fit, causes, kept.stands.rivals, stated, row, chances)
    asserted = apart_from_nil(engine, fit, asserted)
    gaps = with_findings(gaps, lambda i: mean_slopes(plain[i], asserted, i))
    # by a logged speed a prediction has that speed's noise, beyond its own sensor's
    commanded = not all(p.drive.imposed for p in engine.problems)
    large = any(g.energy.beyond(DOUBTLESS) for g in gaps)
    signs = Signs(
        before=kept.proof.before,
        after=kept.proof.after,
        doubtless=doubtless,
        noise=noise_of(gaps),
        large=doubtless if kept.refuted else large,
        explained=kept.proof.shrink.explained if commanded else 1.0,
        ends=any(early),
        farthest=farthest,
        disagree=any(one.disagrees for one in kept.by_log) or "opposed" in kinds,
        even=any(chance <= EVEN for chance in chances),
        wanders="restless" in kinds,
        taken_up=any(
            leaves_a_gap(p, g, causes, kept.stands.fit, i)
            for i, (p, g) in enumerate(zip(plain, gaps, strict=True))
        ),
    )
    return Judged(gaps, left, fit, asserted, verdict(causes, left, signs))


def with_findings(
    gaps: Sequence[Gap], said: Callable[[int], tuple[Finding, ...]]
) -> tuple[Gap, ...]:
    """Return the gaps of logs with what is said of each besides."""
    return tuple(replace(g, findings=g.findings + said(i)) for i, g in enumerate(gaps))


def leaves_a_gap(
    plain: Problem, gap: Gap, causes: Sequence[Cause], fit: Fit, log: int
) -> bool:
    """Tell whether an energy gap is one whatever the rows say, with all causes alike.

    What they cost, and what its meters were off by, is taken out of it; what stated
    figures cost is not. Of 157 drives of the blind plant with such a gap and causes
    that were named, one is left with as much: a wind beside them is missed.
    """
    if not causes or not gap.energy.beyond(DOUBTLESS):
        return False
    plain, stretches = at_own_rows(plain, gap.measured), plain.charge
    simulated = gap.energy.simulated_wh
    paid = prices(plain, causes, fit.values, log, stretches, simulated)
    if paid is None or simulated is None:
        return False
    known = sum(paid.causes.values()) + paid.meters_wh + paid.drive_wh
    return replace(gap.energy, simulated_wh=simulated + known).beyond(DOUBTLESS)


def is_doubtless(gaps: Sequence[Gap]) -> bool:
    """Tell whether the energy of a log is off beyond what is doubted of it."""
    return any(g.energy.within is False for g in gaps)


def farthest_moved(fit: Fit, stated: Mapping[str, float], gaps: Sequence[Gap]) -> float:
    """Return by how many sds stated figures are off, alone or all together.

    Without end where a log and the vehicle's file contradict each other.
    """
    if any(of_another(g.findings) for g in gaps):
        return inf
    return farthest(moved(fit, stated), moved_together(fit, stated))
