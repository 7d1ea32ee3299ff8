"""Stated figures that do nothing where they are stated, and would within their sds."""

from __future__ import annotations

from collections.abc import Sequence
from math import inf

import numpy as np
from numpy.typing import NDArray

from rcc_sim.diagnose import descent
from rcc_sim.diagnose.engine import Engine
from rcc_sim.diagnose.fit import Fit
from rcc_sim.diagnose.knobs import BIAS, Knob
from rcc_sim.errors import InputError

Array = NDArray[np.float64]

OFF = (-3.0, -2.0, -1.5, -1.0, -0.5, 0.5, 1.0, 1.5, 2.0, 3.0)
"""Standard deviations by which a figure is tried off what is stated."""

LEAST = 1.0
"""Nats that it must gain there for the fit to begin there."""


def woken(engine: Engine, null: Fit) -> Fit:
    """Return the fit of the tolerances, none of which sleeps where it would gain.

    A limit that the nominal vehicle never comes to has no slope, and no fit moves it;
    it may be as much lower as its sd says, and is no cause then.
    """
    for knob in asleep(null):
        ends = [knob.within(knob.value + off * knob.sd) for off in (OFF[0], OFF[-1])]
        if not changes(engine, null, knob.key, ends):
            continue
        tried = [knob.within(knob.value + off * knob.sd) for off in OFF]

        def one(x: float, key: str = knob.key, base: Fit = null) -> Fit | None:
            return engine.attempt({**base.values, key: x}, base.knobs, base.noise)

        fits = [f for f in engine.each(one, tried) if f is not None]
        best = max(fits, key=lambda f: f.score, default=null)
        if best.score > null.score + LEAST:
            moved = descent.fit(engine, best.values, null.knobs)
            null = max(null, moved, key=lambda f: f.score)
    return null


def changes(engine: Engine, fit: Fit, key: str, to: Sequence[float]) -> bool:
    """Tell whether a figure changes anything at either end of where it may be."""

    def left(x: float) -> list[Array]:
        try:
            return engine.residuals({**fit.values, key: x}, coarse=True)
        except InputError:  # no such vehicle
            return []

    base, *there = engine.each(left, [fit.values[key], *to])
    return any(
        np.nan_to_num(a - b).any()
        for tracks in there
        for a, b in zip(tracks, base, strict=bool(tracks))
    )


def asleep(fit: Fit) -> list[Knob]:
    """Return the stated figures of the vehicle that change nothing in the logs."""
    return [
        knob
        for knob, tracks in zip(fit.knobs, fit.signals, strict=True)
        if knob.sd < inf
        and not knob.key.startswith(BIAS)
        and not any(np.nan_to_num(x).any() for x in tracks)
    ]
