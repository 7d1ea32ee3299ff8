"""Ways in which logs may be driven: how commands run between rows, what is averaged."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Sequence
from dataclasses import replace
from math import inf
from typing import Any

from rcc_sim.analyse.sampled import SAMPLE, may_be_means
from rcc_sim.definitions.sensors import ACCELEROMETERS
from rcc_sim.diagnose.fitting.engine import Engine
from rcc_sim.diagnose.residuals.problem import Problem
from rcc_sim.physics.tables import BEFORE, LINE, SINCE
from rcc_sim.simulate.drive import Drive
from rcc_sim.simulate.spans import FLOWS

AVERAGES = (1e-3, SAMPLE, inf)
"""Times before its rows over which a log's flows may be averaged: what a chip that does
not filter shows, an inverter's own, and all since the row before. [s]"""


def every_way(problems: Sequence[Problem]) -> list[list[Drive]]:
    """Return the drives of logs, commands and averages in every way.

    One logger wrote them: what is asked is asked of all that are driven by commands, of
    the steering also where the motion that was measured drives the car. A loop that
    steps the car, and then logs what it did, shows in a row what has acted until then.
    A car that takes its reference by a clock of its own (``reference_sampling``) may
    have been logged after it: a row then shows what has acted since that clock struck.
    """
    commanded = any(not p.drive.imposed for p in problems)
    if not commanded and not any(p.drive.steered for p in problems):
        return []
    references = (LINE, SINCE, BEFORE)[: 2 + are_clocked(problems)]
    references = references if commanded else (LINE,)
    ways = [(r, s) for r in references for s in (LINE, SINCE)]
    ways += [(BEFORE if commanded else LINE, BEFORE)]
    every = dict.fromkeys(zip(*map(averages_in_turn, problems), strict=True))

    def one(p: Problem, way: tuple[int, int], over: tuple[float, float]) -> Drive:
        if not p.drive.imposed:
            return replace(p.drive, held=way, window=over[0], felt=over[1])
        if p.drive.steered:
            return replace(p.drive, held=(p.drive.held[0], way[1]))
        return p.drive

    return [
        [one(p, way, over) for p, over in zip(problems, averages, strict=True)]
        for way in ways
        for averages in every
    ]


def are_clocked(problems: Sequence[Problem]) -> bool:
    """Tell whether a car takes its reference by a clock of its own."""
    return any("reference_sampling" in p.vehicle.effects for p in problems)


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
    both = all({*some} & {*problem.channels} for some in (FLOWS, ACCELEROMETERS))
    felt = SAMPLE if means and both else inf
    return [(min(own, SAMPLE), inf), (over, inf), (over, felt)]


def can_be_means(problem: Problem) -> bool:
    """Tell whether flows of a commanded drive, or what it feels, may be means.

    As its logger was asked by commands that run straight between rows, it may have been
    told wrong of those that hold: those of a stiff loop come all at once.
    """
    some = any(c in (*FLOWS, *ACCELEROMETERS) for c in problem.channels)
    commanded = not problem.drive.imposed
    return some and commanded and may_be_means(problem.row, imposed=False)


def is_asked(problem: Problem) -> bool:
    """Tell whether an accelerometer may tell if a log's flows are samples or means.

    Beside a gyro it does so of rows that are closer than those of which flows do: where
    half a row makes 5 ms, and a car corners as hard as it can.
    """
    turns = problem.drive.imposed and problem.drive.steered
    long = may_be_means(problem.row, imposed=False) and problem.charge is None
    return turns and long and "accel_y_mps2" in problem.channels


def with_drives(engine: Engine, drives: Sequence[Drive]) -> Engine:
    """Return the logs with other drives."""
    pairs = zip(engine.problems, drives, strict=True)
    return Engine([replace(p, drive=drive) for p, drive in pairs])


def driven_as(engine: Engine, like: Engine) -> Engine:
    """Return logs whose commands hold, and whose flows are means, as in others."""
    drives = [
        replace(p.drive, **way_of(q.drive))
        for p, q in zip(engine.problems, like.problems, strict=True)
    ]
    return with_drives(engine, drives)


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


def holds_more(way: Engine, begun: Engine, commands: Collection[int]) -> bool:
    """Tell whether the commands of logs run as in others, but that some hold there.

    What is averaged is free: accelerations that are means come half a row late.
    """

    def more(held: tuple[int, int]) -> tuple[int, ...]:
        return tuple(SINCE if i in commands else h for i, h in enumerate(held))

    pairs = [
        (p.drive.held, q.drive.held)
        for p, q in zip(way.problems, begun.problems, strict=True)
    ]
    others = any(there != held for there, held in pairs)
    return others and all(there == more(held) for there, held in pairs)


def is_logged_later(engine: Engine, begun: Engine) -> bool:
    """Tell whether logs are driven as others, but for commands that act before.

    The reference, or all of them.
    """
    pairs = [
        (p.drive, q.drive)
        for p, q in zip(engine.problems, begun.problems, strict=True)
        if not p.drive.imposed
    ]
    return bool(pairs) and all(
        averages_of(d) == averages_of(other)
        and d.held in ((BEFORE, other.held[1]), (BEFORE, BEFORE))
        for d, other in pairs
    )


def other_ways(engine: Engine, asked: Sequence[bool]) -> list[Engine]:
    """Return logs whose flows are samples, of 10 ms or none, or means: as they are not.

    The first of those that are ``asked`` tells which they are.
    """
    now = average_of(engine.problems[[*asked].index(True)].drive)
    return [
        with_drives(
            engine,
            [
                replace(p.drive, window=over) if yes else p.drive
                for p, yes in zip(engine.problems, asked, strict=True)
            ],
        )
        for over in AVERAGES
        if over != now
    ]


def average_of(drive: Drive) -> float:
    """Return which of the averages a drive's flows are. [s]"""
    return next(over for over in AVERAGES if drive.window <= over)


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
            (
                q.drive.held,
                min(w for w in AVERAGES if q.drive.window <= w),
                q.drive.felt,
            )
            for q in same
        )
        held, over, felt = max(ways, key=ways.__getitem__)
        means = inf if p.drive.imposed or can_be_means(p) else p.drive.window
        window = min(p.drive.window, over) if over <= SAMPLE else means
        drive = replace(p.drive, held=held, window=window, felt=felt)
        return replace(p, drive=drive)

    return [one(p) for p in problems]
