"""What a run asked beyond the vehicle's means, in words."""

from __future__ import annotations

from collections.abc import Mapping
from math import inf

import numpy as np
from numpy.typing import NDArray

from rcc_sim.definitions.cycle import Cycle
from rcc_sim.definitions.figure import Figure
from rcc_sim.definitions.vehicle import Vehicle
from rcc_sim.errors import InputError
from rcc_sim.units import G

FARTHER = 0.02
"""Share by which a drive may be longer or shorter than its cycle without a word."""

LINEAR_SLIP = 0.15
"""Slip up to which a tyre's longitudinal force is about proportional to it."""

STEPS_PER_CHANGE = 8
"""Rows that a lane change needs to be seen as one."""


def run_notes(
    vehicle: Vehicle,
    cycle: Cycle,
    columns: Mapping[str, NDArray[np.float64]],
    beyond: Mapping[str, float],
    lane_length: float = inf,
) -> tuple[str, ...]:
    """Return a sentence for each thing that went beyond the vehicle's means.

    Parameters
    ----------
    columns : mapping
        The trace, by edge name.
    beyond : mapping
        What the kernel counted.
    lane_length : float
        Distance of a lane change; infinite where there is none. [m]

    Raises
    ------
    InputError
        If the battery was asked for more power than it can ever give.
    """
    if beyond["P_over"] > 1:
        raise InputError(
            f"{vehicle.where}: effects.battery_resistance: the drive asks for "
            f"{beyond['P_over']:.2g} times the most power that the battery can give",
            "u_0²/(4 R_i) is that most; is the resistance in ohm?",
        )
    notes = []
    if beyond["short"] > 0:
        notes.append(
            f"the motor falls short for {beyond['short']:.3g} s: up to "
            f"{beyond['tau_over']:.3g} times its torque is asked for"
        )
    if beyond["limited"] > 0:
        notes.append(
            f"for {beyond['limited']:.3g} s the reference asks for more speed or "
            "torque than the battery's voltage or the motor's speed limit allows"
        )
    if beyond["outside"] > 0:
        notes.append(
            f"{beyond['outside']:.3g} s outside the motor's efficiency map, "
            "taken at its edge"
        )
    if beyond["slip"] > LINEAR_SLIP:
        notes.append(
            f"the driven tyres slip by up to {100 * beyond['slip']:.2g} %: past about "
            f"{100 * LINEAR_SLIP:g} % the stiffness alone does not describe them"
        )
    return (
        *notes,
        *coarse(columns, lane_length),
        *_distance(cycle, columns),
        *_grip(vehicle, columns),
    )


def coarse(
    columns: Mapping[str, NDArray[np.float64]], lane_length: float
) -> tuple[str, ...]:
    """Say if rows lie too far apart to show lane changes of a length [m]."""
    step = float(np.diff(columns["distance_m"]).max(initial=0.0))
    if step <= lane_length / STEPS_PER_CHANGE:
        return ()
    return (
        f"rows up to {step:.3g} m apart are too few for lane changes of "
        f"{lane_length:.3g} m: give the cycle more rows (scale-cycle --rate), or drive "
        "it commanded",
    )


def _distance(
    cycle: Cycle, columns: Mapping[str, NDArray[np.float64]]
) -> tuple[str, ...]:
    driven, asked = float(columns["distance_m"][-1]), cycle.distance
    if asked <= 0 or abs(driven / asked - 1) <= FARTHER:
        return ()
    worst = float((columns["speed_mps"] - columns["speed_ref_mps"]).max())
    why = (
        f": it runs up to {worst:.3g} m/s over the reference" if driven > asked else ""
    )
    return (f"drives {driven:.4g} m where the cycle has {asked:.4g} m{why}",)


def _grip(
    vehicle: Vehicle, columns: Mapping[str, NDArray[np.float64]]
) -> tuple[str, ...]:
    mu = vehicle.tyres.friction_coefficient
    limited = vehicle.effects.get("tyre_saturation", {}).get("friction_coefficient")
    if isinstance(limited, Figure) or mu is None:
        return ()
    a_y = float(np.abs(columns["accel_y_mps2"]).max())
    if a_y <= mu.value * G:
        return ()
    return (
        f"corners at up to {a_y:.3g} m/s² where the tyres give {mu.value * G:.3g}: "
        f"--with tyre_saturation:friction_coefficient={mu.value:g} limits them",
    )
