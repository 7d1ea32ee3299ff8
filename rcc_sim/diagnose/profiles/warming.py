"""An efficiency that changes as slowly as noise remembers: a motor that grows hot.

By the noise of a fit next to nothing speaks for it. That noise was learnt from what the
fit leaves, grows with the power and remembers: it takes the change for its own.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rcc_sim.diagnose.causes.profile import Profile
from rcc_sim.diagnose.profiles.forms import (
    DRAG_OVER_TIME,
    EFFICIENT,
    ITSELF,
    carrier_of,
)
from rcc_sim.diagnose.profiles.probe import Probe

Array = NDArray[np.float64]

POWER = ITSELF["auxiliary_load"]

WARMS = (EFFICIENT, "time_s")
"""How it acts, and what it follows."""


def warming(
    probe: Probe, course: Profile, nats: float, log: int, x: Array, enough: float
) -> tuple[Profile, float]:
    """Return a course of an efficiency by the noise that it leaves, and its nats.

    Those that noise and knobs gain without it, found anew, are none of it, nor are
    those that a drag gains likewise: a rough road is noise that remembers. Where what
    remains is no more than ``nats``, or what a load that varies gains likewise, it is
    as it was. Sharper if it is ``enough``.
    """
    own = beside_noise(probe, course, log, x)
    if own > nats:
        road, load = (
            likewise(probe, name, course, log, x) for name in (DRAG_OVER_TIME[0], POWER)
        )
        own = own - road if own > load else 0.0
    if own <= nats:
        return course, nats
    if own > enough:
        course = probe.sharper(course, log, x, (len(course.knots),))
    return course, own


def likewise(probe: Probe, name: str, course: Profile, log: int, x: Array) -> float:
    """Return what another way of acting gains, in as many windows. [nats]"""
    other = Probe(probe.engine, probe.fit, carrier_of(probe.engine, probe.fit, name))
    if not other.shows_in(log):
        return 0.0
    found = other.profile(log, course.along, x, len(course.knots))
    return max(beside_noise(other, found, log, x), 0.0)


def beside_noise(probe: Probe, course: Profile, log: int, x: Array) -> float:
    """Return what a course gains with the noise that it leaves, beyond that alone."""
    return probe.with_noise(course, log, x) - max(probe.without(log), 0.0)
