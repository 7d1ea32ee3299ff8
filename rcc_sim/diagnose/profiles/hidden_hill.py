"""A hill of few slopes: what noise that remembers takes for its own.

A road that climbs evenly for a minute is a force that comes, stays and goes. A noise
that remembers expects no less of what was just before, and nothing is left to explain
but the few rows at which the slope changes. Here slopes are sought, as the levels of a
load that switches are (:mod:`~rcc_sim.diagnose.profiles.switched`), by a noise that
remembers nothing, and weighed against the noise that they leave.
"""

from __future__ import annotations

from functools import partial

import numpy as np
from numpy.typing import NDArray

from rcc_sim.definitions.figure import Z_90
from rcc_sim.diagnose.causes.cause import ENOUGH, PROFILE_ENOUGH, PROFILES, Cause
from rcc_sim.diagnose.causes.strengths import smooth
from rcc_sim.diagnose.fitting.engine import Engine
from rcc_sim.diagnose.fitting.fit import Fit
from rcc_sim.diagnose.fitting.knobs import bounds_of
from rcc_sim.diagnose.profiles.forms import carrier_of
from rcc_sim.diagnose.profiles.probe import Probe
from rcc_sim.diagnose.profiles.switched import (
    PENALTIES,
    Course,
    Way,
    course_of,
    stepped,
    weighed,
)
from rcc_sim.side_by_side import each

Array = NDArray[np.float64]

HILL = "road_grade"

HIDES = 0.5
"""Share of what is left of a channel that its own past must foresee for a hill to be
hidden in it."""

SMOOTH = (10, 20, 60, 120)
"""Knots of a road that rolls."""

EVEN = Way(shortest=4.0, penalties=(*PENALTIES, 640.0, 2560.0), begun=True)
"""How even slopes are sought: what a model errs by where a drive is brisk stands out,
too, by a noise of which most rows have little."""

APART = 1e-6
"""Way that a second at rest counts, so that rows at one place stay in order. [m]"""


def hidden_hill(engine: Engine, fit: Fit, constant: Fit | None = None) -> Cause | None:
    """Return a hill that passes for noise, if what is left of a fit asks for one.

    And if what is left of the best fit with a ``constant`` cause does, where there is
    one: if its past foresees nothing of that, it was this cause that was hidden.

    Its ``rival`` are the nats of a drag of the same course; none of one that would have
    to push. None where a drag,
    pushing or not, is clearly likelier: something else then comes and goes. Of 44
    drives of the blind plant without a hill (seeds 810101, 820101, 830101) 16 with
    nothing wrong gained 22 nats at most; of 28 with something of no library, 12 of
    which gained 60 or more, none was left.
    """
    probe = Probe(engine, fit, PROFILES[HILL][0])
    left = [fit] if constant is None else [fit, constant]
    logs = range(len(engine.problems))
    asked = [i for i in logs if all(hides(engine, one, probe, i) for one in left)]
    if not asked:
        return None
    other = Probe(engine, fit, carrier_of(engine, fit, "drag"))
    courses: dict[int, Course] = {}
    both = drags = rival = 0.0
    for i in asked:
        tried = courses_of(probe, i)
        best = max(tried, key=lambda c: c.profile.evidence)
        if best.profile.evidence > PROFILE_ENOUGH:
            courses[i] = best
            both += best.profile.evidence
            nats, pushes = max(each(partial(as_a_drag, other, i), tried))
            drags += nats
            rival += 0.0 if pushes else nats
    if not courses or drags > both + ENOUGH:
        return None
    return weighed(probe, HILL, courses, rival)


def hides(engine: Engine, fit: Fit, probe: Probe, log: int) -> bool:
    """Tell whether the noise of a channel in which a slope shows may hold a hill."""
    mine = (k for k in probe.tracks if engine.tracks[k][0] == log)
    return any(fit.noise[k].foresees(fit.residuals[k]) > HIDES for k in mine)


def courses_of(probe: Probe, log: int) -> list[Course]:
    """Return how the road may have climbed, by even slopes and by a few knots."""
    problem = probe.engine.problems[log]
    time = problem.log["time_s"]
    x = problem.coordinate(PROFILES[HILL][1]) + APART * (time - time[0])
    probe.without(log)  # which is what each is held against
    ways = stepped(probe, log, x, hidden=True, how=EVEN)
    for n in SMOOTH:
        knots = np.linspace(x[0], x[-1], n)
        which, shape = np.arange(n), smooth(n)
        ways.append(partial(course_of, probe, log, x, knots, which, shape, how=EVEN))
    return each(lambda way: way(), ways)


def as_a_drag(other: Probe, log: int, course: Course) -> tuple[float, bool]:
    """Nats of a drag of the same course, with the noise that it leaves.

    And whether it would have to push: then no drag is in the place of the hill.
    """
    if not other.shows_in(log):
        return 0.0, False
    found = other.beside_noise(log, course.windows, course.shape, begun=EVEN.begun)
    low, _ = bounds_of(other.engine.problems[log], other.key)
    pushes = bool((other.base + found.value + Z_90 * found.sd < low).any())
    return found.evidence - course.cost, pushes
