"""A fit without some of its figures: back to what the vehicle's file says of them."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace

from rcc_sim.diagnose.fitting.descent import under_its_noise
from rcc_sim.diagnose.fitting.engine import Engine
from rcc_sim.diagnose.fitting.fit import Fit
from rcc_sim.diagnose.fitting.knobs import nuisance_knobs


def without(engine: Engine, fit: Fit, keys: Collection[str]) -> Fit | None:
    """Return a fit with some figures back at what the file states, the rest held.

    A figure that the file states with a tolerance keeps that tolerance. None where no
    vehicle can have the rest without them.
    """
    stated = {k.key: k for k in nuisance_knobs(engine.problems)}
    kept = [
        (j, stated[k.key] if k.key in keys else k)
        for j, k in zip(fit.signals, fit.knobs, strict=True)
        if k.key not in keys or k.key in stated
    ]
    values = {k: x for k, x in fit.values.items() if k not in keys}
    values |= {k: stated[k].value for k in keys if k in stated}
    base = engine.attempt(values, [k for _, k in kept], fit.noise)
    return base and replace(base, signals=[j for j, _ in kept])


def refitted_without(engine: Engine, fit: Fit, keys: Collection[str]) -> Fit | None:
    """Return the same with the rest fitted anew, by the noise and signals there are.

    What the file states with a tolerance begins where it was found: if it may well be
    there, nothing has to take its place.
    """
    base = without(engine, fit, keys)
    if base is None:
        return None
    found = {k.key: fit.values[k.key] for k in base.knobs}
    return under_its_noise(engine, replace(base, values=base.values | found))
