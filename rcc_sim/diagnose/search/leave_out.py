"""Causes that are left out once all are known: others do as well without them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from rcc_sim.diagnose.causes.cause import ENOUGH, Cause
from rcc_sim.diagnose.causes.profile import with_acting
from rcc_sim.diagnose.fitting import descent
from rcc_sim.diagnose.fitting.engine import Engine
from rcc_sim.diagnose.fitting.fit import Fit
from rcc_sim.diagnose.fitting.without import refitted_without
from rcc_sim.diagnose.profiles.varying import as_many, enough_of, instead
from rcc_sim.diagnose.search.refine import Refined
from rcc_sim.diagnose.search.winner import cause_of


def without_outdone(
    engine: Engine, causes: list[Cause], fit: Fit
) -> tuple[Engine, list[Cause], Fit]:
    """Drop each profile without which the others, fitted anew, do as well.

    It was taken in before them, and may have stood for what they are. By the noise that
    all of them leave: one that is learnt anew may take a load for its own.
    """
    for cause in [c for c in causes if c.profiles]:
        if len(causes) < 2:
            break
        less = {i: p.reversed for i, p in cause.profiles.items()}
        bare = with_acting(engine, less)
        others = descent.under_its_noise(bare, fit)
        if others is None:
            continue
        if fit.score - others.score < min(map(enough_of, cause.profiles.values())):
            causes = [c for c in causes if c is not cause]
            engine, fit = bare, descent.refit(bare, others)
    return engine, causes, fit


def without_idle(
    engine: Engine, causes: list[Cause], fit: Fit
) -> tuple[Engine, list[Cause], Fit]:
    """Drop each cause without which the others, fitted anew, do as well.

    A hill that was found beside a drag was made to suit it: beside the others it is
    found anew.
    """
    for cause in [c for c in causes if not c.profiles]:
        if len(causes) < 2:
            break
        less = refitted_without(engine, fit, cause.keys)
        if less is None:
            continue
        others = [c for c in causes if c is not cause]
        if needs(fit, less) < ENOUGH:
            causes, fit = others, descent.refit(engine, less, less.noise)
            continue
        hill = next((c for c in others if c.along_way and not c.weighed), None)
        if hill is None:
            continue
        _, _, most, _ = instead(engine, fit, hill, as_many(hill))
        _, there, rest, found = instead(engine, less, hill, as_many(hill))
        if needs(most, rest) < ENOUGH:
            engine, fit = there, rest
            new = replace(hill, profiles=found)
            causes = [new if c is hill else c for c in others]
    return engine, causes, fit


def needs(fit: Fit, less: Fit) -> float:
    """Nats by which logs need what a fit has more: those of stated figures twice."""
    return fit.score - less.score + max(fit.prior - less.prior, 0.0)


def one_alone(
    engine: Engine, causes: list[Cause], fit: Fit, close: Sequence[Refined]
) -> tuple[list[Cause], Fit]:
    """Return one cause in the place of several if it does as well alone.

    What came first by a nat may need a second to do what its twin does by itself.
    """
    if len(causes) < 2 or any(c.profiles for c in causes):
        return causes, fit
    taken = {c.effect for c in causes}
    for one in (r for r in close if r.screened.candidate.effect not in taken):
        alone = descent.refit(engine, one.fit, one.fit.noise)
        if alone.score > fit.score - ENOUGH * (len(causes) - 1):
            return [cause_of(engine, replace(one, fit=alone), alone.noise)], alone
    return causes, fit
