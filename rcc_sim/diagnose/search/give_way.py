"""Courses that were found before another cause was known, and give way to it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from math import inf

from rcc_sim.diagnose.causes.cause import ENOUGH, Cause
from rcc_sim.diagnose.fitting import descent
from rcc_sim.diagnose.fitting.engine import Engine
from rcc_sim.diagnose.fitting.fit import Fit
from rcc_sim.diagnose.profiles.gusts import WIND
from rcc_sim.diagnose.profiles.varying import anew, evened, with_another
from rcc_sim.diagnose.search.look import Look
from rcc_sim.diagnose.search.pursue import with_effect
from rcc_sim.diagnose.search.refine import Refined, beside, ranked
from rcc_sim.diagnose.search.screen import Screened
from rcc_sim.diagnose.search.winner import cause_of
from rcc_sim.side_by_side import each

CLOSE, MOST, FEW = 0.5, 4, 2
"""Share of the nats of the best that a candidate must have, and how many of those are
tried, once courses give way; and how many of those that a course displaced."""


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
    return changed(engine, fit, causes, anew)


def hills_beside_all(
    engine: Engine, fit: Fit, causes: Sequence[Cause]
) -> tuple[Engine, Fit, list[Cause]]:
    """Return a fit in which the mean of each hill was found beside all else."""
    return changed(
        engine, fit, causes, lambda e, f, c: evened(e, f, c) if c.along_way else None
    )


def changed(
    engine: Engine,
    fit: Fit,
    causes: Sequence[Cause],
    change: Callable[[Engine, Fit, Cause], tuple[Engine, Fit, Cause] | None],
) -> tuple[Engine, Fit, list[Cause]]:
    """Return a fit in which each course that gives way has changed, where it does."""
    causes = list(causes)
    for k, cause in enumerate(causes):
        found = change(engine, fit, cause) if gives_way(cause) else None
        if found:
            engine, fit, causes[k] = found
    return engine, fit, causes


def nats_of_courses(
    engine: Engine, fit: Fit, causes: Sequence[Cause]
) -> tuple[float, float]:
    """Return what a fit gains once courses give way to it, each in as many windows.

    All of it, and that of stated figures which go back.
    """
    fit = fitted(engine, fit)
    more = [with_another(engine, fit, cause) for cause in filter(gives_way, causes)]
    nats, eased = sum(f.score for f in more), sum(f.prior for f in more)
    return nats - len(more) * fit.score, eased - len(more) * fit.prior


def beside_courses(
    engine: Engine,
    look: Look,
    causes: Sequence[Cause],
    displaced: Sequence[Refined] = (),
) -> Look:
    """Return what candidates gain where courses give way to each.

    A course takes in what acts as it does, and what then is left of that cause may be
    little, or more like another. So those that it ``displaced`` are tried beside it as
    well, though they may seem to gain nothing more.
    """
    if not (look.best or displaced) or not any(map(gives_way, causes)):
        return look
    seen = {r.screened.candidate.effect for r in look.refined}
    gone = [r for r in displaced if r.screened.candidate.effect not in seen][:FEW]
    if not (look.best or gone):
        return look
    alone, alone_eased = nats_of_courses(engine, look.fit, causes)
    least = CLOSE * look.best.trusted if look.best else inf
    close = [r for r in look.refined[:MOST] if r.trusted > least]
    back = brought_back(engine, look.fit, [r.screened for r in gone])

    def one(r: Refined) -> Refined:
        nats, eased = nats_of_courses(engine, r.fit, causes)
        more, eased = nats - alone, eased - alone_eased
        if more <= 0:
            return r
        before, after = r.before + more, r.after + more
        return replace(r, before=before, after=after, eased=r.eased + eased)

    tried = each(one, [*close, *back])
    refined = ranked([*tried, *look.refined[len(close) :]])
    best = next((r for r in refined if r.reaches(ENOUGH)), None)
    won = cause_of(engine, best, look.fit.noise) if best else None
    return replace(look, refined=refined, best=best, one=won)


def brought_back(engine: Engine, base: Fit, gone: Sequence[Screened]) -> list[Refined]:
    """Return candidates refined beside a fit, from where they were without a course."""
    if not gone:
        return []
    along = engine.whitened(base.signals, base.noise)
    fits = each(lambda r: with_effect(engine, base, r, base.noise, along), gone)
    return [beside(base, r, fit) for r, fit in zip(gone, fits, strict=True) if fit]


def fitted(engine: Engine, refined: Fit) -> Fit:
    """Return a fit by its own noise, from where it was refined by another's."""
    return descent.refit(engine, refined, refined.noise)
