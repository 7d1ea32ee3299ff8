"""Slope of the road."""

import math
from typing import Any

from rcc_sim.jit import jit
from rcc_sim.physics.effect import Effect, Param, Sought
from rcc_sim.units import G

STEEPEST = 0.35
"""Rise over way beyond which no road is, but a fault of its altimeter. [1]"""


@jit
def grade_force(m, slope):
    """Weight m g sin(θ) [N] against the drive; slope = tan θ, positive uphill."""
    if slope == 0.0:
        return 0.0
    return m * G * slope / math.sqrt(1.0 + slope * slope)


@jit
def wheel_load(m, slope):
    """Force m g cos(θ) [N] of the vehicle on the road; slope = tan θ."""
    if slope == 0.0:
        return m * G
    return m * G / math.sqrt(1.0 + slope * slope)


@jit
def climbed(way, slope):
    """Height [m] gained over a way [m] along a road; slope = tan θ."""
    if slope == 0.0:
        return 0.0
    return way * slope / math.sqrt(1.0 + slope * slope)


def rise_over_run(rise: Any, way: Any) -> Any:
    """Slope tan θ = Δh / sqrt(Δs² - Δh²) of rises over the way along the road. [1]"""
    return rise / (way**2 - rise**2) ** 0.5


EFFECT = Effect(
    id="road_grade",
    title="slope of the road",
    equation="F = m g sin(atan(slope))",
    params=(
        Param(
            "slope",
            neutral=0.0,
            bounds=(-0.4, 0.4),
            typical=(-0.06, 0.06),
            about="rise over run, positive uphill",
            sought=Sought(limits=(-0.15, 0.15)),
        ),
    ),
    channels=("accel_x_mps2", "motor_current_a", "battery_power_w"),
    files=("profile",),
    sink="road_grade",
    seen_as="a force with the sign of the direction driven",
    source="T. D. Gillespie, Fundamentals of Vehicle Dynamics, SAE, 1992, ch. 4",
    shows_in=("unsurveyed",),
    also=("hill", "incline", "gradient", "altitude", "elevation"),
)
