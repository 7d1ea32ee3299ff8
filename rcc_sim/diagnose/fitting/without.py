"""A fit without some of its figures: back to what the vehicle's file says of them."""

from __future__ import annotations

from collections.abc import Collection

from rcc_sim.diagnose.fitting.descent import under_its_noise
from rcc_sim.diagnose.fitting.engine import Engine
from rcc_sim.diagnose.fitting.fit import Fit
from rcc_sim.diagnose.fitting.knobs import nuisance_knobs


def without(engine: Engine, fit: Fit, keys: Collection[str]) -> Fit | None:
    """Return a fit with some figures back at what the file states, the rest held.

    A figure that the file states with a tolerance keeps that tolerance. None where no
    vehicle can have the rest without them.
    """
    bare = _less(engine, fit, keys)
    back = {k.key: k.value for k in bare.knobs if k.key in keys}
    return engine.at(bare, bare.values | back)


def refitted_without(engine: Engine, fit: Fit, keys: Collection[str]) -> Fit | None:
    """Return the same with the rest fitted anew, by the noise and signals there are.

    What the file states with a tolerance begins where it was found: if it may well be
    there, nothing has to take its place.
    """
    return under_its_noise(engine, _less(engine, fit, keys))


def _less(engine: Engine, fit: Fit, keys: Collection[str]) -> Fit:
    """Return a fit, not judged yet, that knows of some figures what the file states.

    Those with a tolerance are where they were found; the others are as in the file.
    """
    stated = {k.key: k for k in nuisance_knobs(engine.problems) if k.key in keys}
    kept = [
        (j, stated.get(k.key, k))
        for j, k in zip(fit.signals, fit.knobs, strict=True)
        if k.key not in keys or k.key in stated
    ]
    free = {k.key for _, k in kept}
    return Fit(
        {k: x for k, x in fit.values.items() if k not in keys or k in free},
        tuple(k for _, k in kept),
        fit.loglik,
        fit.prior,
        fit.noise,
        fit.residuals,
        signals=[j for j, _ in kept],
    )
