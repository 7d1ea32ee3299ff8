"""How far a fit moved what the vehicle file states: each figure, and all together."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from math import isfinite, log

import numpy as np
from scipy.special import chdtrc, ndtri_exp

from rcc_sim.diagnose.fitting.fit import Fit
from rcc_sim.diagnose.fitting.knobs import RADIUS, Knob
from rcc_sim.physics.effect import Effect

STATED_RADIUS = "tyres.radius_m"

TOO_FAR = 3.0
"""Standard deviations beyond which a tolerance that is pulled stands for a cause."""


def pulled(fit: Fit, far: float) -> dict[str, float]:
    """Tolerances that were pulled farther -> by how many sds."""
    pulls = {k.key: _pull(fit, k) for k in fit.knobs}
    return {key: pull for key, pull in pulls.items() if abs(pull) > far}


def moved(fit: Fit, stated: Collection[str]) -> dict[str, float]:
    """Stated figures that a fit moved by their sds or more, in sds, farthest first.

    A wheel's radius is moved by its scale, where the file states none.
    """
    pulls = {told: _pull(fit, k) for told, k in _tolerances(fit, stated).items()}
    far = sorted((k for k in pulls if abs(pulls[k]) >= 1), key=lambda k: -abs(pulls[k]))
    return {key: pulls[key] for key in far}


def farthest(pulls: Mapping[str, float], together: float) -> float:
    """Return by how many sds figures are off, the farthest or all together."""
    return max([together, *map(abs, pulls.values())])


def moved_together(fit: Fit, stated: Collection[str]) -> float:
    """Sds by which one figure would be as unlikely as what all stated figures moved by.

    Σ z² of their pulls z is χ² of as many degrees of freedom as the logs determine
    figures, Σ (1 − (sd after / sd stated)²): what they tell nothing of stays where it
    is.
    """
    figures = _tolerances(fit, stated)
    if not figures:
        return 0.0
    after = dict(zip((k.key for k in fit.knobs), fit.sds().tolist(), strict=True))
    pulls = np.array([_pull(fit, k) for k in figures.values()])
    told = [1 - min(after[k.key] / k.sd, 1.0) ** 2 for k in figures.values()]
    chance = float(chdtrc(max(sum(told), 1.0), pulls @ pulls))
    if not chance:  # rarer than a float can be, whatever their number
        return float(np.linalg.norm(pulls))
    return -float(ndtri_exp(log(chance / 2)))


def is_of(effect: Effect, key: str) -> bool:
    """Tell whether an effect is that a stated figure is another than stated."""
    own = f"effects.{effect.id}."
    factors = (p.sought.same_as for p in effect.params if p.is_factor)
    radius = key == STATED_RADIUS and RADIUS.startswith(own)
    return key.startswith(own) or radius or key in factors


def _tolerances(fit: Fit, stated: Collection[str]) -> dict[str, Knob]:
    """Return what a fit could move of what a file states, by the file's own names."""
    names = {key: key for key in stated}
    names.setdefault(RADIUS, STATED_RADIUS)
    free = (k for k in fit.knobs if k.key in names and isfinite(k.sd))
    return {names[k.key]: k for k in free}


def _pull(fit: Fit, knob: Knob) -> float:
    return (fit.values[knob.key] - knob.value) / knob.sd
