"""Drives of the pick-up by hand: F = m a + drag, P = tau w; nothing of the model."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rcc_sim.units import G
from tests.cars import TRUCK

Array = NDArray[np.float64]

ROLL, AREA, AUX, RHO = 0.012, 1.1, 600.0, 1.225
STATED = {
    "rolling_resistance": {"coefficient": {"value": ROLL, "sd": 0.0008}},
    "aerodynamic_drag": {
        "drag_area_m2": {"value": AREA, "sd": 0.06}, "air_density_kg_per_m3": RHO,
    },
    "auxiliary_load": {"power_w": {"value": AUX, "sd": 60.0}},
}  # fmt: skip
"""What its file says."""

PER_SPEED = TRUCK["drivetrain"]["gear_ratio"] / TRUCK["tyres"]["radius_m"]
"""Speed of the motor per road speed. [rad/m]"""


def shaft_torque(t: Array, v: Array, wind: Array | float = 0.0) -> Array:
    """Torque [N m] that a motion takes, against a wind [m/s]."""
    mass, air = TRUCK["body"]["mass_kg"], v + wind
    drag = 0.5 * RHO * AREA * air * np.abs(air) + mass * G * ROLL
    return (v > 0) * (mass * np.gradient(v, t) + drag) / PER_SPEED


def logged(
    t: Array, v: Array, torque: Array, rng: np.random.Generator, watts: float = 200.0
) -> dict[str, Array]:
    """Columns of a drive: no loss but the load, and what each meter scatters by."""
    power = torque * v * PER_SPEED + AUX
    return {
        "time_s": t,
        "speed_mps": v + 0.01 * rng.normal(size=len(t)),
        "battery_power_w": power + watts * rng.normal(size=len(t)),
        "motor_torque_nm": torque + rng.normal(size=len(t)),
    }
