"""An efficiency that changes as slowly as noise remembers: a motor that grows hot.

By the noise of a fit next to nothing speaks for it. That noise was learnt from what the
fit leaves, grows with the power and remembers: it takes the change for its own.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rcc_sim.diagnose.causes.profile import Profile
from rcc_sim.diagnose.profiles.forms import DRAG_OVER_TIME, EFFICIENT, carrier_of
from rcc_sim.diagnose.profiles.probe import Probe

Array = NDArray[np.float64]

WARMS = (EFFICIENT, "time_s")
"""How it acts, and what it follows."""


def warming(
    probe: Probe, course: Profile, nats: float, log: int, x: Array, enough: float
) -> tuple[Profile, float]:
    """Return a course of an efficiency by the noise that it leaves, and its nats.

    Those that noise and knobs gain without it, found anew, are none of it, nor are
    those that a drag gains likewise: a rough road is noise that remembers. Where what
    remains is no more than ``nats``, it is as it was. Sharper if it is ``enough``.
    """
    count = len(course.knots)
    own = probe.with_noise(course, log, x) - max(probe.without(log), 0.0)
    if own > nats:
        key = carrier_of(probe.engine, probe.fit, DRAG_OVER_TIME[0])
        road = Probe(probe.engine, probe.fit, key)
        if road.shows_in(log):
            rough = road.profile(log, course.along, x, count)
            own -= max(road.with_noise(rough, log, x) - road.without(log), 0.0)
    if own <= nats:
        return course, nats
    if own > enough:
        course = probe.sharper(course, log, x, (count,))
    return course, own
