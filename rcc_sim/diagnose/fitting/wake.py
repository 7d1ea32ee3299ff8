"""Stated figures that do nothing where they are stated, and would within their sds."""

from __future__ import annotations

import numpy as np

from rcc_sim.diagnose.fitting import descent
from rcc_sim.diagnose.fitting.engine import Engine
from rcc_sim.diagnose.fitting.fit import Fit
from rcc_sim.diagnose.fitting.knobs import BIAS, Knob
from rcc_sim.errors import InputError
from rcc_sim.side_by_side import each

OFF = (-3.0, -2.0, -1.5, -1.0, -0.5, 0.5, 1.0, 1.5, 2.0, 3.0)
"""Standard deviations by which a figure is tried off what is stated."""

LEAST = 1.0
"""Nats that it must gain there for the fit to begin there."""


def woken(engine: Engine, null: Fit) -> Fit:
    """Return the fit of the tolerances, none of which sleeps where it would gain.

    A limit that the nominal vehicle never comes to has no slope, and no fit moves it;
    it may be as much lower as its sd says, and is no cause then.
    """
    for knob in within_reach(engine, null):
        tried = [knob.within(knob.value + off * knob.sd) for off in OFF]

        def one(x: float, key: str = knob.key, base: Fit = null) -> Fit | None:
            return engine.at(base, {**base.values, key: x})

        fits = [f for f in each(one, tried) if f is not None]
        best = max(fits, key=lambda f: f.score, default=null)
        if best.score > null.score + LEAST:
            moved = descent.fit(engine, best.values, null.knobs)
            null = max(null, moved, key=lambda f: f.score)
    return null


def within_reach(engine: Engine, fit: Fit) -> list[Knob]:
    """Return the sleeping figures that do something at an end of where they may be."""
    sleeping = asleep(fit)
    if not sleeping:
        return []
    base = engine.residuals(fit.values, coarse=True)

    def acts(knob: Knob) -> bool:
        for off in (OFF[0], OFF[-1]):
            there = {**fit.values, knob.key: knob.within(knob.value + off * knob.sd)}
            try:
                tracks = engine.residuals(there, coarse=True)
            except InputError:  # no such vehicle
                continue
            pairs = zip(tracks, base, strict=True)
            if any(np.nan_to_num(x - y).any() for x, y in pairs):
                return True
        return False

    told = each(acts, sleeping)
    return [knob for knob, does in zip(sleeping, told, strict=True) if does]


def asleep(fit: Fit) -> list[Knob]:
    """Return the stated figures of the vehicle that change nothing in the logs."""
    sleeping = [fit.knobs[i] for i in fit.asleep]
    return [knob for knob in sleeping if not knob.key.startswith(BIAS)]
