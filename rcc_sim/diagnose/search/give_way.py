"""Courses that were found before another cause was known, and give way to it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from rcc_sim.diagnose.causes.cause import ENOUGH, Cause
from rcc_sim.diagnose.fitting import descent
from rcc_sim.diagnose.fitting.engine import Engine
from rcc_sim.diagnose.fitting.fit import Fit
from rcc_sim.diagnose.profiles.gusts import WIND
from rcc_sim.diagnose.profiles.varying import anew, nats_of_another
from rcc_sim.diagnose.search.look import Look
from rcc_sim.diagnose.search.refine import Refined, ranked
from rcc_sim.diagnose.search.winner import cause_of
from rcc_sim.side_by_side import each

CLOSE, MOST = 0.5, 4
"""Share of the nats of the best that a candidate must have, and how many of those are
tried, once courses give way."""


def gives_way(cause: Cause) -> bool:
    """Tell whether a cause has a course that is found anew beside another.

    Gusts are found about a steady wind, and levels with the moments at which they
    change.
    """
    return bool(cause.profiles) and not cause.weighed and cause.effect != WIND


def give_way(
    engine: Engine, fit: Fit, causes: Sequence[Cause]
) -> tuple[Engine, Fit, list[Cause]]:
    """Return a fit in which each course was found anew, where that gains enough."""
    causes = list(causes)
    for k, cause in enumerate(causes):
        found = anew(engine, fit, cause) if gives_way(cause) else None
        if found:
            engine, fit, causes[k] = found
    return engine, fit, causes


def nats_of_courses(engine: Engine, fit: Fit, causes: Sequence[Cause]) -> float:
    """Return what a fit gains once courses give way to it, each in as many windows."""
    fit = fitted(engine, fit)
    courses = filter(gives_way, causes)
    return sum(nats_of_another(engine, fit, cause) for cause in courses)


def beside_courses(engine: Engine, look: Look, causes: Sequence[Cause]) -> Look:
    """Return what candidates gain where courses give way to each.

    A course takes in what acts as it does, and what then is left of that cause may be
    little, or more like another.
    """
    if not (look.best and any(map(gives_way, causes))):
        return look
    by_themselves = nats_of_courses(engine, look.fit, causes)
    least = CLOSE * look.best.trusted
    close = [r for r in look.refined[:MOST] if r.trusted > least]

    def one(r: Refined) -> Refined:
        more = max(nats_of_courses(engine, r.fit, causes) - by_themselves, 0.0)
        return replace(r, before=r.before + more, after=r.after + more)

    tried = each(one, close)
    refined = ranked([*tried, *look.refined[len(close) :]])
    best = next((r for r in refined if r.reaches(ENOUGH)), None)
    won = cause_of(engine, best, look.fit.noise) if best else None
    return replace(look, refined=refined, best=best, one=won)


def fitted(engine: Engine, refined: Fit) -> Fit:
    """Return a fit by its own noise, from where it was refined by another's."""
    return descent.refit(engine, refined, refined.noise)
