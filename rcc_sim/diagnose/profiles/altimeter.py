"""An altimeter that wanders: a slope, and so a drag, that is not there.

The heights of a barometer or a satellite receiver err slowly, by decimetres to metres.
The model climbs what they show, and what it then lacks or has too much looks like a
drag that comes and goes; but an accelerometer feels the slope that there is.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rcc_sim.diagnose.causes.profile import Profile
from rcc_sim.diagnose.causes.strengths import CLIMBS
from rcc_sim.diagnose.fitting.engine import Engine
from rcc_sim.diagnose.fitting.fit import Fit
from rcc_sim.diagnose.profiles.probe import Probe
from rcc_sim.diagnose.residuals.shapes import ALTIMETER
from rcc_sim.trace import integral_of

FAR = 10.0
"""Height by which a receiver's altitude wanders at most, as a root mean square. [m]"""

AS_WELL = 0.85
"""Share of a drag's nats from which on a slope explains it as well: without an
accelerometer it gains 0.96 to 0.99 of them."""

FELT = 20.0
"""Nats by which a slope must be likelier than a drag for the accelerometer to have told
that it is the slope which is off. Of 132 drives of the blind plant and the reference
set whose heights are exact none has a drag than which a slope is likelier at all."""


@dataclass(frozen=True)
class Wander:
    """Heights that would have to be off for a drag not to be there.

    Parameters
    ----------
    height : float
        By how much, as a root mean square about a straight line. [m]
    is_felt : bool
        The accelerometer says so: a slope is likelier than a drag.
    is_stated : bool
        The vehicle's file allows the altimeter as much.
    """

    height: float
    is_felt: bool
    is_stated: bool

    @property
    def is_known(self) -> bool:
        """Whether it is the altimeter, for all that log and file tell."""
        return self.is_felt or self.is_stated


def wander(
    engine: Engine, fit: Fit, drag: Profile, nats: float, log: int
) -> Wander | None:
    """Return what an altimeter that wanders would make of a drag over time.

    None where the log's road is not of its altimeter, where a slope explains the drag
    less well, or heights would have to be off by more than altimeters are. The height
    is that of the profile, int slope v dt, less a straight line over the distance.
    """
    problem = engine.problems[log]
    if not problem.drive.climbed:
        return None
    probe = Probe(engine, fit, CLIMBS[0])
    x = problem.coordinate(drag.along)
    slope = probe.profile(log, drag.along, x, len(drag.knots))
    if slope.evidence < AS_WELL * nats:
        return None
    height = integral_of(problem.log["time_s"], slope.at(x) * problem.speed)
    straight = np.polyfit(problem.distance, height, 1)
    off = float(np.std(height - np.polyval(straight, problem.distance)))
    sensor = problem.vehicle.sensors.get(ALTIMETER)
    stated = sensor.noise_sd.value if sensor and sensor.noise_sd else 0.0
    if off > max(FAR, stated):
        return None
    likelier = slope.evidence - nats
    if 0.0 < likelier < FELT:  # by the noise that each leaves
        count = (len(drag.knots),)
        other = Probe(engine, fit, drag.key)
        _, felt = probe.sharpest(slope, log, x, count)
        _, dragged = other.sharpest(drag, log, x, count)
        likelier = felt - dragged
    return Wander(off, likelier > FELT, off <= stated)
