"""Whether the road was as its altimeter shows, or as the accelerometer felt it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rcc_sim.diagnose.causes.profile import Profile, with_acting
from rcc_sim.diagnose.causes.strengths import CLIMBS
from rcc_sim.diagnose.fitting import descent
from rcc_sim.diagnose.fitting.engine import Engine
from rcc_sim.diagnose.fitting.fit import Fit
from rcc_sim.diagnose.fitting.knobs import nuisance_knobs, scale_key
from rcc_sim.diagnose.profiles.altimeter import Wander
from rcc_sim.diagnose.profiles.forms import carrier_of
from rcc_sim.diagnose.profiles.probe import Probe
from rcc_sim.diagnose.profiles.remainder import acting_as, as_heights
from rcc_sim.diagnose.profiles.varying import WINDOW_COUNTS
from rcc_sim.diagnose.residuals.shapes import ALTIMETER

PASSES = 3
"""Times that a road is set right, each time by what the last left, at most."""


@dataclass(frozen=True)
class Felt:
    """Logs on the roads that were felt.

    Parameters
    ----------
    engine : Engine
        Those roads under the logs.
    wanders : dict
        Log -> by how much its heights were off, where they were.
    null : Fit or None
        What tolerances alone leave there, where heights were asked about.
    """

    engine: Engine
    wanders: dict[int, Wander]
    null: Fit | None


def as_felt(engine: Engine) -> Felt:
    """Return the logs on the roads that were felt.

    Where an altimeter that wanders
    (:class:`~rcc_sim.diagnose.profiles.altimeter.Wander`) is what tolerances leave, the
    road is set right by the slope that explains it, but for its median: a slope all
    along is a drag as well. (A mean would make a drag all along of one hill that the
    heights do not show.) None is taken on which the logs are less likely.
    """
    wanders: dict[int, Wander] = {}
    if not any(p.drive.climbed for p in engine.problems):
        return Felt(engine, wanders, None)
    null = descent.of_tolerances(engine)
    for _ in range(PASSES):
        drags = acting_as(engine, null, "drag", carrier_of(engine, null, "drag"))
        found = [as_heights(engine, null, r) for r in drags]
        known = {r.log: r.heights for r in found if r.heights and r.heights.is_known}
        if not known:
            break
        slopes = {i: felt_slope(engine, null, i) for i in known}
        there = with_acting(engine, slopes)
        new = descent.fit(there, null.values, nuisance_knobs(there.problems))
        if new.score < null.score:
            break
        wanders, engine, null = known | wanders, there, new
    return Felt(engine, wanders, null)


def felt_slope(engine: Engine, fit: Fit, log: int) -> Profile:
    """Return the slope by which a log's road is off, about a median of nil.

    Beside heights as steep as the fit has them: a share of all hills is none of it.
    """
    fit = fit.holding(scale_key(log, ALTIMETER))
    probe = Probe(engine, fit, CLIMBS[0])
    distance = engine.problems[log].distance
    tried = [probe.profile(log, "distance_m", distance, n) for n in WINDOW_COUNTS]
    best = max(tried, key=lambda p: p.evidence)
    evenly = np.linspace(distance[0], distance[-1], len(distance))
    return best.raised(-float(np.median(best.at(evenly))))
