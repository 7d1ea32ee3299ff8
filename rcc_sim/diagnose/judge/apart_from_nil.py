"""Intervals of figures that act: none holds the value at which the effect vanishes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from rcc_sim.definitions.figure import Z_90
from rcc_sim.diagnose.fitting import descent
from rcc_sim.diagnose.fitting.engine import Engine
from rcc_sim.diagnose.fitting.fit import Fit
from rcc_sim.diagnose.judge.asserted import Asserted, Estimate
from rcc_sim.diagnose.judge.chances import EVEN
from rcc_sim.physics.effects import nil_of

LESS = 0.5 * Z_90**2
"""Nats by which the end of a 90 % interval is less likely than its middle."""

HALVINGS = 6
"""Times that the way to the end of an interval is halved."""


def apart_from_nil(
    engine: Engine, fit: Fit, asserted: Sequence[Asserted]
) -> tuple[Asserted, ...]:
    """Return causes whose intervals end where the likelihood has fallen as it must.

    An interval is as wide as slopes at the figure say. Where the model does no more
    than it does already, as beyond a play that is never taken up, they say nothing, and
    the interval of an effect that surely acts would hold its absence. There its end is
    found towards that, all other figures giving way.
    """
    return tuple(
        replace(a, figures={name: _ended(engine, fit, a, name) for name in a.figures})
        if len(a.cause.keys) == 1 and not a.cause.profiles and a.probability > EVEN
        else a
        for a in asserted
    )


def _ended(engine: Engine, fit: Fit, one: Asserted, name: str) -> Estimate:
    """Return an estimate whose interval holds its neutral value no more, if it may."""
    told, (key,) = one.figures[name], one.cause.keys
    nil = nil_of(key, engine.problems[0].vehicle.known)
    inside = told.low <= nil <= told.high and nil != told.value
    if not inside or not fit.frees(key) or _lost(engine, fit, key, nil) < LESS:
        return told
    likely, end = told.value, nil
    for _ in range(HALVINGS):
        middle = 0.5 * (likely + end)
        if _lost(engine, fit, key, middle) < LESS:
            likely = middle
        else:
            end = middle
    return replace(told, low=end) if nil < told.value else replace(told, high=end)


def _lost(engine: Engine, fit: Fit, key: str, value: float) -> float:
    """Nats lost by holding a figure at a value, the others giving way."""
    held = replace(fit, values=fit.values | {key: value}).holding(key)
    found = descent.under_its_noise(engine, held)
    # with what is expected of the figure itself
    there = engine.at(fit, found.values) if found else None
    return fit.score - there.score if there else 0.0
