"""Which run would tell apart what these logs cannot."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

RATE = 0.02
"""Time between two rows of a run to drive. [s]"""

SEPARATES: dict[str, tuple[frozenset[str], ...]] = {
    "drive the same stretch out and back, once in each direction": (
        frozenset({"road_grade", "headwind"}),
    ),
    "spin the wheels off the ground at several speeds, 5 min": (
        frozenset(
            {
                *("drivetrain_friction", "drivetrain_damping", "iron_loss"),
                *("rotor_inertia", "gear_loss"),
            }
        ),
    ),
    "stand still with the electronics on, 2 min, a second current meter in line": (
        frozenset({"auxiliary_load", "current_sensor_scale"}),
    ),
    "coast down from top speed in both directions, no torque": (
        frozenset({"rolling_resistance", "aerodynamic_drag", "copper_loss"}),
        frozenset({"headwind", "road_grade"}),
    ),
    "drive with a known load of 10 % of the mass on board": (
        frozenset({"payload", "rolling_resistance"}),
    ),
    "hold a constant radius at rising speed, both ways round": (
        frozenset(
            {
                *("front_cornering_stiffness", "rear_cornering_stiffness"),
                *("cg_shift", "steering_gain", "steering_offset"),
                *("tyre_saturation", "yaw_rate_bias"),
            }
        ),
    ),
    "step the steering at three speeds": (
        frozenset(
            {
                *("steering_lag", "steering_delay", "yaw_inertia"),
                *("tyre_relaxation", "steering_backlash", "sensor_delay"),
            }
        ),
    ),
    "step the speed reference up and down, straight ahead": (
        frozenset(
            {
                *("actuation_delay", "motor_lag", "speed_loop"),
                *("reference_sampling", "speed_dead_zone", "current_limit"),
            }
        ),
    ),
}
"""A run -> effects that it shows alone: it parts each of these from all others."""


@dataclass(frozen=True)
class Experiment:
    """A run to drive next.

    Parameters
    ----------
    do : str
        What to do.
    separates : tuple of str
        The effects that it would tell apart.
    """

    do: str
    separates: tuple[str, ...]


def next_experiments(tied: Sequence[str]) -> list[Experiment]:
    """Return the runs that part most of the tied effects first."""
    found = []
    for do, groups in SEPARATES.items():
        shown = {e for group in groups for e in group if e in tied}
        if shown and (len(shown) < len(set(tied)) or len(groups) > 1):
            rest = set(tied) - shown
            found.append((min(len(shown), len(rest)), Experiment(do, tuple(tied))))
    found.sort(key=lambda pair: -pair[0])
    return [experiment for _, experiment in found[:3]]


def next_run(
    top_speed: float, top_steer: float, wheelbase: float
) -> tuple[Array, Array, Array]:
    """Return time [s], speed [m/s] and steering angle [rad] of a run that tells much.

    Steps of the speed up and down, two coasts to a stand, and at three speeds a step,
    a held circle and a slalom of the steering, both ways round.
    """
    parts: list[tuple[float, float, float]] = [(2.0, 0.0, 0.0)]
    for share in (0.3, 0.6, 1.0):
        v = share * top_speed
        turn = max(2 * np.pi * wheelbase / max(v, 0.1), 1.0)
        parts += [(3.0, v, 0.0), (turn, v, top_steer), (turn, v, -top_steer)]
        parts += [(0.5 * turn, v, s * 0.5 * top_steer) for s in (1, -1, 1, -1)]
        parts += [(2.0, v, 0.0)]
    parts += [(6.0, 0.0, 0.0), (4.0, top_speed, 0.0), (8.0, 0.0, 0.0)]
    ends = np.cumsum([seconds for seconds, _, _ in parts])
    time = np.arange(0.0, ends[-1], RATE)
    part = np.searchsorted(ends, time, side="right")
    speed = np.array([v for _, v, _ in parts])[part]
    steer = np.array([angle for _, _, angle in parts])[part]
    return time, speed, steer
