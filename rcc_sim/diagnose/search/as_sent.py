"""Commands that were logged as they were sent, and hold until the next one."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from math import inf

import numpy as np

from rcc_sim.analyse.sampled import SAMPLE, may_be_means
from rcc_sim.diagnose.causes.cause import ENOUGH
from rcc_sim.diagnose.fitting import descent
from rcc_sim.diagnose.fitting.engine import Engine
from rcc_sim.diagnose.fitting.fit import Fit
from rcc_sim.diagnose.noise.whitener import log_likelihood
from rcc_sim.diagnose.residuals.problem import Problem
from rcc_sim.diagnose.residuals.shapes import LATERAL
from rcc_sim.diagnose.search.compete import Explanation
from rcc_sim.simulate.drive import Drive

Way = Callable[[Engine, Fit | None, Callable[[Engine], Engine] | None], Explanation]
"""How logs are explained: from a null, where known, and with the other way to drive."""


def as_sent(
    engine: Engine, null: Fit | None, explained: Way
) -> tuple[Engine, Explanation]:
    """Return logs and explanation, commands holding between rows where likelier.

    A command that runs straight from row to row leads one that holds by half a row; and
    so do flows that are samples such as are means since the row before. The vehicle as
    it is stated may like it better so; but a motor or a steering that is late, or slow,
    may seem to hold it: with the first cause it is asked, and all is explained so if it
    still is. Where what was found may do as well, or fewer causes, the other way, all
    is explained that way, too, and the likelier explanation stands. A cause fewer is
    worth what one must gain.

    ``null`` is what tolerances alone leave as the logs are, where that is known.
    """
    ways = list(zip(*(held(p.drive) for p in engine.problems), strict=False))
    others = engine.each(partial(with_drives, engine), ways)
    each = engine.each(likelihood, others)
    if not others or max(each) < likelihood(engine) + ENOUGH:
        return averaged(engine, null, explained)
    begun, other = engine, others[int(np.argmax(each))]
    found = explained(engine, null, partial(driven_as, like=other))
    if are_driven_as(found.engine, other):
        begun, other = other, begun
    now = descent.fit(
        driven_as(found.engine, like=other), found.fit.values, found.fit.knobs
    )
    if now.score + ENOUGH * len(found.causes) <= found.fit.score:
        return begun, found
    again = explained(other, null if other is engine else None, None)
    fewer = len(again.causes) - len(found.causes)
    if found.fit.score + ENOUGH * fewer <= again.fit.score:
        return other, again
    return begun, found


def averaged(
    engine: Engine, null: Fit | None, explained: Way
) -> tuple[Engine, Explanation]:
    """Return logs and explanation, flows being samples or means as the steering says.

    The flows of a drive that its own noisy speed drives do not always tell within half
    a row. How the car answers its steering does, once what else is late or slow there
    is found: half a row amiss moves its centre of gravity by three standard deviations,
    or makes a cause of where the load lies. Where what was found does better the other
    way, all is explained so, too, a cause being worth what one must gain.
    """
    asked = [is_asked(p) for p in engine.problems]
    found = explained(engine, null, None)
    if not any(asked):
        return engine, found
    other = other_way(engine, asked)
    as_found = driven_as(found.engine, like=other)
    now = descent.fit(as_found, found.fit.values, found.fit.knobs)
    if answered(as_found, now) <= answered(found.engine, found.fit) + ENOUGH:
        return engine, found
    again = explained(other, None, None)
    more = len(again.causes) - len(found.causes)
    better = answered(again.engine, again.fit) - answered(found.engine, found.fit)
    return (other, again) if better > ENOUGH * (1 + more) else (engine, found)


def other_way(engine: Engine, asked: Sequence[bool]) -> Engine:
    """Return logs whose flows are means where they were samples, or the reverse."""
    drives = [p.drive for p in engine.problems]
    for i, drive in enumerate(drives):
        if asked[i]:
            window = inf if drive.window < inf else SAMPLE
            drives[i] = replace(drive, window=window)
    return with_drives(engine, drives)


def answered(engine: Engine, fit: Fit) -> float:
    """Log-likelihood of how a car answers its steering, and prior of all figures.

    What the noisy speed makes of the other channels is less of it in a mean.
    """
    each = zip(engine.tracks, fit.residuals, fit.noise, strict=True)
    return fit.prior + sum(
        log_likelihood(noise, left)
        for (_, channel), left, noise in each
        if channel in LATERAL
    )


def is_asked(problem: Problem) -> bool:
    """Tell whether an accelerometer may tell if a log's flows are samples or means."""
    turns = problem.drive.imposed and problem.drive.steered
    long = may_be_means(problem.row, imposed=True) and problem.charge is None
    return turns and long and "accel_y_mps2" in problem.channels


def driven_as(engine: Engine, like: Engine) -> Engine:
    """Return logs whose commands hold, and whose flows are means, as in others."""
    drives = [
        replace(p.drive, held=q.drive.held, window=q.drive.window)
        for p, q in zip(engine.problems, like.problems, strict=True)
    ]
    return with_drives(engine, drives)


def are_driven_as(engine: Engine, like: Engine) -> bool:
    """Tell whether the commands of logs hold, and flows are means, as in others."""
    pairs = zip(engine.problems, like.problems, strict=True)
    return all(
        (p.drive.held, p.drive.window) == (q.drive.held, q.drive.window)
        for p, q in pairs
    )


def with_drives(engine: Engine, drives: Sequence[Drive]) -> Engine:
    """Return the logs with other drives."""
    pairs = zip(engine.problems, drives, strict=True)
    return Engine([replace(p, drive=drive) for p, drive in pairs])


def held(drive: Drive) -> list[Drive]:
    """Return a drive with reference, steering or both held, by samples and means."""
    if drive.imposed:
        return []
    windows = sorted({min(drive.window, SAMPLE), drive.window})
    ways = [(True, False), (False, True), (True, True)]
    return [
        replace(drive, held=either(drive.held, way), window=window)
        for way in ways
        for window in windows
    ]


def either(one: tuple[bool, bool], other: tuple[bool, bool]) -> tuple[bool, bool]:
    """Return what either of two says of reference and steering."""
    return one[0] or other[0], one[1] or other[1]


def likelihood(engine: Engine) -> float:
    """Log-likelihood of the vehicle as it is stated, under the noise that it leaves."""
    left = engine.residuals({})
    return engine.loglik(left, engine.learn_noise(left))
