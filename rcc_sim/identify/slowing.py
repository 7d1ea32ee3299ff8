"""How fast a vehicle slows when it coasts, by its fitted road load."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rcc_sim.identify.coastdown import RoadLoad

SPEEDS = 5
"""Speeds at which it is told."""


@dataclass(frozen=True)
class Slowing:
    """Deceleration at one speed, and one standard deviation of it."""

    speed_mps: float
    deceleration_mps2: float
    sd: float


def slowing(load: RoadLoad, inertia_kg: float) -> tuple[Slowing, ...]:
    r"""Deceleration over the range of speed that a coast-down has seen.

    .. math:: -\dot v = (A + B v + C v^2) / (m + m_e)

    Parameters
    ----------
    load : RoadLoad
        From :func:`rcc_sim.identify.coastdown.fit_coastdown`.
    inertia_kg : float
        Mass and what turns, as the fit had it. [kg]
    """
    powers = {"A": 0, "B": 1, "C": 2}
    sds = np.array([getattr(load, name).sd for name in load.terms])
    size = len(load.terms)
    shared = np.array(load.correlation)[:size, :size] * np.outer(sds, sds)
    out = []
    for v in np.linspace(load.speed_low, load.speed_high, SPEEDS):
        at = np.array([float(v) ** powers[name] for name in load.terms])
        values = np.array([getattr(load, name).value for name in load.terms])
        sd = float(np.sqrt(at @ shared @ at))
        out.append(Slowing(float(v), float(at @ values) / inertia_kg, sd / inertia_kg))
    return tuple(out)
