"""A load that switches, or grows slowly: what noise that remembers takes for its own.

A profile that changes little from knot to knot does not fit a load that jumps. Here
the moments of change are sought by a noise that remembers nothing, and paid for; the
levels between are then weighed against the noise that they leave, and so is a course of
a few knots, which a log of a minute tells from noise no other way.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import partial
from math import ceil, lgamma
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from rcc_sim.diagnose.causes.cause import ENOUGH, PROFILES, Cause
from rcc_sim.diagnose.causes.profile import Profile
from rcc_sim.diagnose.causes.strengths import Windows, smooth, windows
from rcc_sim.diagnose.fitting.engine import Engine
from rcc_sim.diagnose.fitting.fit import Fit
from rcc_sim.diagnose.profiles.forms import carrier_of
from rcc_sim.diagnose.profiles.partition import Levels, segments
from rcc_sim.diagnose.profiles.probe import Probe
from rcc_sim.diagnose.residuals.problem import Problem
from rcc_sim.side_by_side import each

Array = NDArray[np.float64]

LOAD = "auxiliary_load"

ALONG = dict(PROFILES.values())
"""Figure that varies -> what it varies along."""

BLOCKS = 1500
"""Blocks of rows at most between which a level may change."""

SHORTEST, MOST = 1.0, 60
"""Time that a level lasts at least, and levels at most: more are a noise. [s], [1]"""

PENALTIES = (10.0, 40.0, 160.0)
"""Nats that a change must gain by a noise that remembers nothing; the most of them by
one that does, is found by trying."""

FIRST = 3.0
"""Nats that a change must gain by the noise that the load is still in."""

TILT = 0.5
"""What the slope of a level must gain, in times what the level itself must: one figure
more, where that is two."""

LOG_2 = 0.693
"""Nats that it costs to say of one level whether it slopes."""

NORMAL = 0.455
"""Median of the square of a standard normal variable."""

NOTHING = 1e-9
"""Share of what a row tells at most below which it tells nothing: a slope, of a vehicle
that stands. A sum of the others would drown it in its rounding."""

LEAST = 1.0
"""Nats that a load is said to gain at least by a noise that takes it for its own."""

SLOW = (5, 10)
"""Knots of a course that changes slowly."""


class Way(NamedTuple):
    """How levels are sought.

    Attributes
    ----------
    shortest : float
        Time that a level lasts at least. [s]
    penalties : tuple of float
        Nats that a change must gain by a noise that remembers nothing.
    begun : bool
        Whether they are weighed from what they would be by that noise, and what is left
        then: rows by which they stand out by far count for nothing else.
    """

    shortest: float = SHORTEST
    penalties: tuple[float, ...] = PENALTIES
    begun: bool = False


OF_A_LOAD = Way()


class Course(NamedTuple):
    """How a load, or a hill, may have gone over a log.

    Attributes
    ----------
    profile : Profile
        Its strength, and the evidence for it beside the noise.
    windows : sparse array, shape (n, k)
        What each of its strengths does at the rows.
    shape : ndarray, shape (k, k)
        Inverse covariance of the strengths, at size 1.
    cost : float
        Nats that the choice of the windows costs.
    """

    profile: Profile
    windows: Windows
    shape: Array
    cost: float


def beside_noise(engine: Engine, fit: Fit, *, hidden: bool) -> Cause | None:
    """Return how a load may have switched or grown, if what is left of a fit asks.

    ``hidden``: no slower profile shows, so that pulses may be all that there is. Beside
    one, what is left holds the model's own errors, which come in pulses as well.
    Its ``gain`` is by the noise of the fit, as any other's; ``sharpened`` is how much
    more it is together with the noise that it leaves, ``rival`` the nats of a drag of
    the same course, likewise.
    """
    if any(w.drift is not None for w in fit.noise):
        return None
    key, along = PROFILES[LOAD]
    probe = Probe(engine, fit, key)
    courses: dict[int, Course] = {}
    for i, problem in enumerate(engine.problems):
        x = problem.coordinate(along)
        tried = courses_of(probe, i, x, hidden) if probe.shows_in(i) else []
        best = max(tried, key=lambda course: course.profile.evidence, default=None)
        if best and best.profile.evidence > ENOUGH:
            courses[i] = best
    if not courses:
        return None
    drag = carrier_of(engine, fit, "drag")
    other = Probe(engine, fit, drag)
    rivals = {
        i: other.beside_noise(i, c.windows, c.shape).evidence - c.cost
        for i, c in courses.items()
        if other.shows_in(i)
    }
    # in a log whose course might as well be a drag's, another's load proves nothing
    beyond = {i: c.profile.evidence - rivals.get(i, 0.0) for i, c in courses.items()}
    if max(beyond.values()) >= ENOUGH:
        courses = {i: c for i, c in courses.items() if beyond[i] >= ENOUGH}
    rival = sum(rivals.get(i, 0.0) for i in courses)
    return replace(weighed(probe, LOAD, courses, rival), shares=probe.shares)


def weighed(
    probe: Probe, effect: str, courses: Mapping[int, Course], rival: float
) -> Cause:
    """Return a cause that went as these courses, and nowhere in other logs.

    Its ``gain`` is by the noise of the fit, as any other's; ``sharpened`` is how much
    more it is together with the noise that it leaves, as ``rival`` is.
    """
    alone = sum(
        probe.evidence(i, c.windows, c.shape) - c.cost for i, c in courses.items()
    )
    both = sum(c.profile.evidence for c in courses.values())
    gain = max(alone, LEAST)
    profiles = {
        i: courses[i].profile if i in courses else flat(*PROFILES[effect], problem)
        for i, problem in enumerate(probe.engine.problems)
    }
    return Cause(
        effect,
        (probe.key,),
        gain,
        rival=rival,
        profiles=profiles,
        sharpened=both / gain,
        shares=probe.shares_of(profiles),
    )


def flat(key: str, along: str, problem: Problem) -> Profile:
    """Return a course that a log does not tell."""
    ends = problem.coordinate(along)[[0, -1]]
    return Profile(key, along, ends, np.zeros(2), np.zeros(2), 0.0)


def courses_of(probe: Probe, log: int, x: Array, hidden: bool) -> list[Course]:
    """Return how a load may have gone over x, by levels and by a few knots.

    Where levels are likeliest, some of them may slope, if that gains as much as a cause
    must: a heater that is switched on and cools, by and by, to what it holds.
    """
    probe.without(log)  # which is what each is held against
    ways = stepped(probe, log, x, hidden)
    ways += [partial(slow, probe, log, x, n) for n in SLOW]
    tried = each(lambda way: way(), ways)
    best = max(tried, key=lambda course: course.profile.evidence)
    if best.cost and best.profile.evidence > ENOUGH:
        more = stepped(probe, log, x, hidden, TILT)
        sloping = each(lambda way: way(), more)
        least = best.profile.evidence + ENOUGH
        tried += [course for course in sloping if course.profile.evidence > least]
    return tried


def slow(probe: Probe, log: int, x: Array, count: int) -> Course:
    """Return a course of a few knots that changes little from one to the next."""
    knots = np.linspace(x[0], x[-1], count)
    return course_of(probe, log, x, knots, np.arange(count), smooth(count))


def course_of(
    probe: Probe,
    log: int,
    x: Array,
    knots: Array,
    which: NDArray[np.intp],
    shape: Array,
    cost: float = 0.0,
    how: Way = OF_A_LOAD,
) -> Course:
    """Return a course over x, of whose strengths each knot has the one in ``which``."""
    H = windows(x, knots, which)
    found = probe.beside_noise(log, H, shape, begun=how.begun)
    profile = Profile(
        probe.key,
        ALONG[probe.key],
        knots,
        found.value[which],
        found.sd[which],
        found.evidence - cost,
        mean_sd=found.mean_sd,
        weighed=True,
    )
    return Course(profile, H, shape, cost)


def stepped(
    probe: Probe,
    log: int,
    x: Array,
    hidden: bool,
    tilt: float | None = None,
    how: Way = OF_A_LOAD,
) -> list[Callable[[], Course]]:
    """Return what makes the likeliest levels over x for each of the penalties.

    Those of a ``hidden`` load also by the noise that a first search leaves. Where a
    level may slope, that costs ``tilt`` of its penalty.
    """
    each, by_row = probe.per_row(log, scaled=how.begun)
    time = probe.engine.problems[log].log["time_s"]
    count = min(len(x), BLOCKS)
    block = np.arange(len(x)) * count // len(x)
    by_row = np.where(by_row > NOTHING * by_row.max(), by_row, 0.0)
    told = np.bincount(block, by_row, count).astype(float)
    value = np.bincount(block, by_row * each, count) / np.maximum(told, 1e-300)
    least = max(ceil(how.shortest * count / (time[-1] - time[0])), 2)
    found: list[Callable[[], Course]] = []
    weights = [told]
    if hidden:
        first = segments(value, told, least, FIRST)
        weights.append(told * sharpened(value, told, first.edges))
    for way in dict.fromkeys(
        segments(value, weight, least, nats, tilt and tilt * nats)
        for weight in weights
        for nats in how.penalties
    ):
        k = len(way.slope)
        if 2 <= k <= MOST and (tilt is None or any(way.slope)):
            ways = lgamma(count) - lgamma(k) - lgamma(count - k + 1)
            cost = ways if tilt is None else ways + k * LOG_2
            found.append(partial(levels, probe, log, x, block, way, cost, how))
    return found


def levels(
    probe: Probe,
    log: int,
    x: Array,
    block: NDArray[np.intp],
    way: Levels,
    cost: float,
    how: Way,
) -> Course:
    """Return a course of levels over the rows of some blocks.

    They cost the log of how many ways there are to choose them. Each end of a level
    that slopes is as free as a level.
    """
    edges = np.searchsorted(block, way.edges)
    knots = x[np.stack([edges[:-1], edges[1:] - 1], axis=1).ravel()]
    new = np.stack([np.ones(len(way.slope)), way.slope], axis=1).ravel()
    which = np.cumsum(new).astype(np.intp) - 1
    return course_of(probe, log, x, knots, which, np.eye(which[-1] + 1), cost, how)


def sharpened(value: Array, told: Array, edges: tuple[int, ...]) -> float:
    """Return how many times more each value tells by the noise that levels leave.

    A load that is on for much of the time makes most of what passes for noise itself.
    """
    begin = np.array(edges[:-1])
    weight = np.maximum(np.add.reduceat(told, begin), 1e-300)
    level = np.add.reduceat(told * value, begin) / weight
    left = value - np.repeat(level, np.diff(edges))
    usual = float(np.median(told * left**2)) / NORMAL
    return 1 / max(usual, 1e-12)
