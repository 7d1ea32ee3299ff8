"""What the label of a case tells of what acted: when, how much, and over the drive."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from rcc_sim.blind import sensors
from rcc_sim.blind.bases import Base
from rcc_sim.blind.drives import SLOPE_STEP
from rcc_sim.blind.plant import Truth
from rcc_sim.blind.strengths import Withheld

Array = NDArray[np.float64]

ACTING = 0.1
"""Share of its greatest activity above which an unknown acts. [1]"""

SCALES = {
    "wheel_radius": "r_w",
    "front_cornering_stiffness": "C_F",
    "rear_cornering_stiffness": "C_R",
    "yaw_inertia": "I_z",
}
"""Effects that scale a figure of the file, and which."""


def by_chance(time: Array, level: Array, read: dict[str, Array]) -> float:
    """Return the energy gap that the true car itself leaves, its road taken as smooth.

    It is what a rough road and the sensors' offsets add, which no model foresees. [%]
    """
    names = "battery_voltage_v", "battery_current_a"
    volts, amps = (level[:, sensors.SENSORS["rc"][c].place] for c in names)
    true = np.trapezoid(volts * amps, time)
    volts, amps = (read[c] for c in names)
    measured = np.trapezoid(volts * amps, time)
    return float(np.round(100 * (measured - true) / measured, 3))


def over_file(
    car: Base, file: Base, effects: Sequence[Withheld]
) -> dict[str, dict[str, float]]:
    """Return magnitudes against the file's figure, for effects that change one.

    ``magnitudes`` hold what was drawn, against the true figure; the file's is off by
    its own error, which a log cannot tell from the effect's.
    """
    found = {}
    for w in effects:
        if w.effect == "payload":
            more = car.m - file.m + w.magnitudes["mass_kg"]
            found["payload"] = {"mass_kg": more}
        elif w.effect in SCALES:
            name = SCALES[w.effect]
            share = getattr(car, name) / getattr(file, name)
            found[w.effect] = {"scale": w.magnitudes["scale"] * share}
    return found


def acting(time: Array, activity: Array) -> list[list[float]]:
    """Return the spans [s] in which something acted, joined across short gaps."""
    most = activity.max(initial=0.0)
    if most <= 0.0:
        return []
    on = activity > ACTING * most
    step = float(np.median(np.diff(time)))
    spans: list[list[float]] = []
    for t in time[on]:
        if spans and t - spans[-1][1] <= 5.0 * step + 1e-9:
            spans[-1][1] = float(t)
        else:
            spans.append([float(t - step), float(t)])
    return [[round(a, 4), round(b, 4)] for a, b in spans]


def profiles(
    effects: Sequence[Withheld], p: Truth, distance: float
) -> dict[str, dict[str, list[float]]]:
    """Return what varied over the drive as it truly was."""
    found: dict[str, dict[str, list[float]]] = {}
    for w in effects:
        if w.slope is not None:
            n = int(distance / SLOPE_STEP) + 2
            found["road_grade.slope"] = {
                "distance_m": (np.arange(n) * SLOPE_STEP).tolist(),
                "value": np.round(w.slope[:n], 7).tolist(),
            }
        for figure, by_second, constant in (
            ("auxiliary_load.power_w", w.aux, p.P_aux),
            ("headwind.speed_mps", w.wind, p.wind),
        ):
            if by_second is not None:
                found[figure] = {
                    "time_s": np.arange(len(by_second), dtype=float).tolist(),
                    "value": np.round(by_second + constant, 4).tolist(),
                }
    return found
