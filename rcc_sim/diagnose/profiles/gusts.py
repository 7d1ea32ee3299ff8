"""A wind that comes and goes: steady, and gusts about it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from rcc_sim.diagnose.causes.candidates import has_needs
from rcc_sim.diagnose.causes.cause import PROFILES, Cause
from rcc_sim.diagnose.causes.profile import with_acting
from rcc_sim.diagnose.fitting import descent
from rcc_sim.diagnose.fitting.engine import Engine
from rcc_sim.diagnose.fitting.fit import Fit
from rcc_sim.diagnose.fitting.knobs import Knob
from rcc_sim.diagnose.profiles.probe import Probe, probe_size
from rcc_sim.diagnose.profiles.remainder import likeliest_of
from rcc_sim.physics.effects import EFFECTS

WIND = "headwind"

STEADY = 5.0
"""Wind along a road that blows without gusts, one sd. [m/s]"""

OF_THE_AIR = (
    "effects.aerodynamic_drag.drag_area_m2",
    "effects.road_load.c_n_s2_per_m2",
)
"""What a wind acts by: in gusts, no log parts the two."""

COUNTS = (20, 60, 120)
"""Knots by which a wind may follow time beside a hill: as many as that its way."""

GALE = 24.0
"""Wind along a road that is none, but something else: Beaufort 9 ends there. [m/s]"""

SWING = 30.0
"""The same of the difference between any two of its gusts: six standard deviations of
one of 12.5 m/s, whose turbulence is 0.4 of that. [m/s]"""

ROUNDS, SETTLED = 6, 0.2
"""Rounds in which gusts are found about themselves at most, and the change, in their
sds, that is none."""


def in_gusts(engine: Engine, fit: Fit, cause: Cause) -> tuple[Engine, Fit, Cause]:
    """Let a wind blow in gusts, about the steady one that is likeliest without them.

    A drag grows with the square of the wind, (v + w)²: what is linear about none takes
    w + w² / 2v for w. The gusts are found anew about those that blow (Gauss and
    Newton). Beside them neither the steady wind nor a drag area can be fitted: what
    roughness adds where it is slow looks like gusts in a wind that is too strong, and a
    drag area too large makes up for gusts that were smoothed.
    """
    key, along = PROFILES[WIND]
    stated = engine.stated(key)
    about = fit.holding(key)
    bounds = EFFECTS[WIND].param("speed_mps").bounds
    steady = Knob(key, stated, STEADY, *bounds, probe_size(engine, key))
    alone = descent.fit(engine, {key: stated} | fit.values, [*about.knobs, steady])
    level, sd = alone.values[key] - stated, alone.sd(key)
    x = [problem.coordinate(along) for problem in engine.problems]
    gusts = {i: replace(p, value=0.0 * p.value) for i, p in cause.profiles.items()}
    about = fit = alone.without([key]).holding(*OF_THE_AIR)
    for _ in range(ROUNDS):
        blows = with_acting(engine, {i: p.raised(level) for i, p in gusts.items()})
        fit = descent.fit(blows, fit.values, about.knobs)
        probe = Probe(blows, fit, key).as_if_none(gusts)
        before, gusts = gusts, {}
        for i, p in before.items():
            n = len(p.knots)
            found = probe.profile(i, along, x[i], n)
            gusts[i] = probe.sharper(found, i, x[i], (n,))
        if all(
            np.all(np.abs(p.value - before[i].value) < SETTLED * p.sd)
            for i, p in gusts.items()
        ):
            break
    profiles = {
        i: replace(p.raised(level), sd=np.hypot(p.sd, sd), mean_sd=sd, normal=None)
        for i, p in gusts.items()
    }
    engine = with_acting(engine, profiles)
    fit = descent.fit(engine, fit.values, about.knobs)
    return engine, fit, replace(cause, profiles=profiles)


def nats_of_gusts(engine: Engine, fit: Fit) -> float:
    """Return the nats for gusts, where the motion drives the model; else none.

    It is what a hill is held against, and no remainder: as often as a hill, a rough
    road bends, too.
    """
    vehicle = engine.vehicle
    if not (is_imposed(engine) and has_needs(vehicle, EFFECTS[WIND])):
        return 0.0
    key, along = PROFILES[WIND]
    probe = Probe(engine, fit, key)
    return likeliest_of(probe, "wind", {along: COUNTS}).evidence


def is_imposed(engine: Engine) -> bool:
    """Tell whether the motion drives the model in all logs."""
    return all(p.drive.imposed for p in engine.problems)


def may_gust(engine: Engine, causes: Sequence[Cause]) -> bool:
    """Tell whether gusts are sought: where the motion drives the model.

    Not beside a figure that they act by, if a cause has it. In a scaled car's commanded
    drive what is in no library would pass for them: a wind is as fast as the car.
    """
    taken = any(key in OF_THE_AIR for c in causes for key in c.keys)
    return not taken and is_imposed(engine)


def may_blow(cause: Cause) -> bool:
    """Tell whether a cause that varies is no wind, or one that blows anywhere."""
    return cause.effect != WIND or all(
        np.abs(p.value).max() < GALE and np.ptp(p.value) < SWING
        for p in cause.profiles.values()
    )
