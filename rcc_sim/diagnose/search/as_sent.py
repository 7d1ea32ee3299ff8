"""Commands that were logged as they were sent, and hold until the next one."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Collection, Sequence
from dataclasses import replace
from functools import partial
from math import inf
from typing import Any

import numpy as np

from rcc_sim.analyse.sampled import SAMPLE, may_be_means
from rcc_sim.definitions.sensors import ACCELEROMETERS
from rcc_sim.diagnose.causes.cause import ENOUGH
from rcc_sim.diagnose.fitting import descent
from rcc_sim.diagnose.fitting.engine import Engine
from rcc_sim.diagnose.fitting.fit import Fit
from rcc_sim.diagnose.noise.whitener import log_likelihood
from rcc_sim.diagnose.residuals.problem import Problem
from rcc_sim.diagnose.residuals.shapes import LATERAL
from rcc_sim.diagnose.search.compete import Asked, Explanation, Way
from rcc_sim.physics.tables import BEFORE, LINE, SINCE
from rcc_sim.side_by_side import each
from rcc_sim.simulate.drive import Drive
from rcc_sim.simulate.spans import FLOWS

LATE = {
    "reference_delay": 0,
    "actuation_delay": 0,
    "motor_lag": 0,
    "steering_delay": 1,
    "steering_lag": 1,
    "tyre_relaxation": 1,
}
"""Effect -> the command that passes for it where it holds from row to row: the
reference or the throttle, or the steering."""

Explained = Callable[[Engine, Fit | None, Asked | None], Explanation]
"""How logs are explained: from a null, where known, and asked how they are driven."""


def as_sent(
    engine: Engine, null: Fit | None, explained: Explained
) -> tuple[Engine, Explanation]:
    """Return logs and explanation, commands running between rows as is likelier.

    A command that runs straight from row to row leads one that holds by half a row, and
    lags one that is logged while it acts by as much; and so do flows that are samples
    such as are means since the row before. The vehicle as it is stated may like it
    better so; but a motor or a steering that is late, or slow, may seem to hold it:
    with the first cause it is asked, and all is explained so if it still is; and with
    each, if logs are about as likely without it where the command holds. Where what
    was found may do as well, or fewer causes, another way, all is explained that way,
    too, and the likelier explanation stands. A cause fewer is worth what one must gain.

    ``null`` is what tolerances alone leave as the logs are, where that is known.
    """
    now = [p.drive.held for p in engine.problems]
    other = [d for d in every_way(engine.problems) if [x.held for x in d] != now]
    ways = each(partial(with_drives, engine), other)
    if not ways:
        return averaged(engine, null, explained)
    likely = each(likelihood, ways)
    best = ways[int(np.argmax(likely))]
    liked = max(likely) >= likelihood(engine) + ENOUGH
    some = parts_of(best, engine, ways) if liked else []
    found = explained(engine, null, Likelier(some, ways))
    begun = driven_as(engine, like=found.engine)
    if not found.causes and not liked:
        return begun, found
    others = [engine, best] if liked else []
    others += [way for way in ways if is_logged_later(way, begun)]
    others = [way for way in others if not are_driven_as(way, begun)]
    least = found.fit.score - (ENOUGH * len(found.causes) if liked else 0.0)
    again = likeliest(others, found.engine, found.fit, least)
    if again is None:
        return begun, found
    late = Likelier((), ways)  # a cause that a command which holds passes for
    anew = explained(again, null if again is engine else None, late)
    fewer = len(anew.causes) - len(found.causes)
    if found.fit.score + ENOUGH * fewer <= anew.fit.score:
        return driven_as(engine, like=anew.engine), anew
    return begun, found


def parts_of(best: Engine, engine: Engine, ways: Sequence[Engine]) -> list[Engine]:
    """Return the ways in which each command runs as in the best, or as it is."""

    def runs(one: Drive, other: Drive, now: Drive) -> bool:
        each = zip(one.held, other.held, now.held, strict=True)
        alike = averages_of(one) == averages_of(other)
        return alike and all(a in (b, c) for a, b, c in each)

    every = list(zip(best.problems, engine.problems, strict=True))
    return [
        way
        for way in ways
        if all(
            runs(p.drive, q.drive, now.drive)
            for p, (q, now) in zip(way.problems, every, strict=True)
        )
    ]


def is_logged_later(engine: Engine, begun: Engine) -> bool:
    """Tell whether logs are driven as others, but for references that act before."""
    pairs = [
        (p.drive, q.drive)
        for p, q in zip(engine.problems, begun.problems, strict=True)
        if not p.drive.imposed
    ]
    return bool(pairs) and all(
        way_of(d) == way_of(replace(other, held=(BEFORE, other.held[1])))
        for d, other in pairs
    )


class Likelier:
    """Tells how logs are driven where they are likelier by the same figures.

    That is one of ``some`` ways, with the first cause or as likely without it; or,
    where the cause is one that a command which holds passes for, one of all ``ways``
    that differs by that alone, and asks for no such cause: logs are about as likely by
    what was found before. Once they are driven another way, commands can but hold more.
    """

    def __init__(self, some: Sequence[Engine], ways: Sequence[Engine]) -> None:
        self._some, self._ways = some, ways

    def __call__(self, engine: Engine, fit: Fit, before: Fit) -> Way | None:
        """Tell it by a fit with one more cause, and the one before."""
        least = fit.score - ENOUGH
        best = likeliest(self._some, engine, fit, fit.score)
        best = best or likeliest(self._some, engine, before, least)
        self._some = []
        late = {LATE[effect] for effect in freed(fit) - freed(before) if effect in LATE}
        if best is None and late:
            others = [way for way in self._ways if holds_more(way, engine, late)]
            best = likeliest(others, engine, before, least)
        return None if best is None else partial(driven_as, like=best)


def freed(fit: Fit) -> set[str]:
    """Return the effects of which a figure is free."""
    keys = (k.key for k in fit.knobs if k.sd == inf)
    return {key.split(".")[1] for key in keys if key.startswith("effects.")}


def holds_more(way: Engine, begun: Engine, commands: Collection[int]) -> bool:
    """Tell whether logs are driven as others, but that some commands hold there."""

    def held(drive: Drive) -> Drive:
        first, second = (
            SINCE if i in commands else h for i, h in enumerate(drive.held)
        )
        return replace(drive, held=(first, second))

    return not are_driven_as(way, begun) and all(
        way_of(p.drive) == way_of(held(q.drive))
        for p, q in zip(way.problems, begun.problems, strict=True)
    )


def likeliest(
    ways: Sequence[Engine], engine: Engine, fit: Fit, least: float
) -> Engine | None:
    """Return the way in which logs are likeliest by the same figures, fitted anew.

    None where none scores more than the ``least``.
    """
    others = [driven_as(engine, like=way) for way in ways]
    scores = each(lambda e: descent.fit(e, fit.values, fit.knobs).score, others)
    best = int(np.argmax([least, *scores]))
    return ways[best - 1] if best else None


def averaged(
    engine: Engine, null: Fit | None, explained: Explained
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
        replace(p.drive, **way_of(q.drive))
        for p, q in zip(engine.problems, like.problems, strict=True)
    ]
    return with_drives(engine, drives)


def kept_alike(problems: Sequence[Problem], like: Engine) -> list[Problem]:
    """Return logs that were kept back, driven as those that were fitted were found.

    One logger wrote them: commands run, and flows are samples or means, as in the most
    of those that are imposed as they are, or commanded.
    """

    def one(p: Problem) -> Problem:
        same = [q for q in like.problems if q.drive.imposed == p.drive.imposed]
        if not same or (p.drive.imposed and not is_asked(p)):
            return p
        ways = Counter(
            (q.drive.held, q.drive.window <= SAMPLE, q.drive.felt) for q in same
        )
        held, samples, felt = max(ways, key=ways.__getitem__)
        means = inf if p.drive.imposed or can_be_means(p) else p.drive.window
        window = min(p.drive.window, SAMPLE) if samples else means
        drive = replace(p.drive, held=held, window=window, felt=felt)
        return replace(p, drive=drive)

    return [one(p) for p in problems]


def are_driven_as(engine: Engine, like: Engine) -> bool:
    """Tell whether the commands of logs hold, and flows are means, as in others."""
    pairs = zip(engine.problems, like.problems, strict=True)
    return all(way_of(p.drive) == way_of(q.drive) for p, q in pairs)


def way_of(drive: Drive) -> dict[str, Any]:
    """Return how commands run between rows, and over what flows are averaged."""
    return {"held": drive.held, **averages_of(drive)}


def averages_of(drive: Drive) -> dict[str, float]:
    """Return over what times before its rows flows and accelerations are averaged."""
    return {"window": drive.window, "felt": drive.felt}


def with_drives(engine: Engine, drives: Sequence[Drive]) -> Engine:
    """Return the logs with other drives."""
    pairs = zip(engine.problems, drives, strict=True)
    return Engine([replace(p, drive=drive) for p, drive in pairs])


def every_way(problems: Sequence[Problem]) -> list[list[Drive]]:
    """Return the drives of logs, commands and averages in every way.

    One logger wrote them: what is asked is asked of all that are driven by commands, of
    the steering also where the motion that was measured drives a car that is steered by
    commands. A car that takes its reference by a clock of its own
    (``reference_sampling``) may have been logged after it: a row then shows what has
    acted since that clock struck.
    """
    commanded = any(not p.drive.imposed for p in problems)
    if not commanded and not any(map(is_steered_by_commands, problems)):
        return []
    clocked = any("reference_sampling" in p.vehicle.effects for p in problems)
    references = (LINE, SINCE, BEFORE)[: 2 + clocked] if commanded else (LINE,)
    ways = [(r, s) for r in references for s in (LINE, SINCE)]
    every = dict.fromkeys(zip(*map(averages_in_turn, problems), strict=True))

    def one(p: Problem, way: tuple[int, int], over: tuple[float, float]) -> Drive:
        if not p.drive.imposed:
            return replace(p.drive, held=way, window=over[0], felt=over[1])
        if is_steered_by_commands(p):
            return replace(p.drive, held=(p.drive.held[0], way[1]))
        return p.drive

    return [
        [one(p, way, over) for p, over in zip(problems, averages, strict=True)]
        for way in ways
        for averages in every
    ]


def averages_in_turn(problem: Problem) -> list[tuple[float, float]]:
    """Return over what times before its rows flows and accelerations are averaged.

    All samples, all means, and means beside accelerometers that are sampled: an
    inverter tells what flowed since it was asked before, a chip what it feels.
    """
    own = problem.drive.window
    if problem.drive.imposed:
        return 3 * [(own, inf)]
    means = can_be_means(problem)
    over = inf if means else own
    felt = SAMPLE if means and set(ACCELEROMETERS) & set(problem.channels) else inf
    return [(min(own, SAMPLE), inf), (over, inf), (over, felt)]


def can_be_means(problem: Problem) -> bool:
    """Tell whether flows of a commanded drive are far enough apart to be means.

    As its logger was asked by commands that run straight between rows, it may have been
    told wrong of those that hold: those of a stiff loop come all at once.
    """
    flows = any(c in FLOWS for c in problem.channels) and not problem.drive.imposed
    return flows and may_be_means(problem.row, imposed=False)


def is_steered_by_commands(problem: Problem) -> bool:
    """Tell whether the steering that a log has was sent to the car, not turned by hand.

    Where it is asked as well if flows are means, the steering's half row tells that.
    """
    sent = problem.drive.steered and problem.vehicle.mode != "torque"
    return sent and not is_asked(problem)


def likelihood(engine: Engine) -> float:
    """Log-likelihood of the vehicle as it is stated, under the noise that it leaves."""
    left = engine.residuals({})
    return engine.loglik(left, engine.learn_noise(left))
