"""A servo that takes its time."""

import math

from rcc_sim.jit import jit
from rcc_sim.physics.effect import Effect, Param, Sought

ARRIVED = 1e-100  # N m or rad; what a lag has left to go below which it is there


@jit
def caught_up(dt, time_constant):
    """Share [1] of the way to its target that a first-order lag makes in dt [s]."""
    if time_constant <= 0.0:
        return 1.0
    return -math.expm1(-dt / time_constant)


@jit
def lagged(value, target, share):
    """Value after a tick in which a lag makes a share of the way to its target.

    What were left of the way to a target of 0 would become a number too small to be
    normal and stay one, with which a processor is a hundred times as slow.
    """
    if share >= 1.0:
        return target
    new = value + (target - value) * share
    if abs(new - target) < ARRIVED:
        return target
    return new


@jit
def mean_lagged(value, target, share, time_constant, dt):
    """Mean over dt [s] of what a lag brings from a value to a target.

    The lag makes a share of that way in dt.
    """
    if time_constant <= 0.0:
        return target
    return target + (value - target) * (share * time_constant / dt)


EFFECT = Effect(
    id="steering_lag",
    title="lag of the steering servo",
    equation="T dangle/dt + angle = command",
    params=(
        Param(
            "time_constant_s",
            neutral=0.0,
            bounds=(0.0, 2.0),
            typical=(0.02, 0.2),
            about="time constant T of the servo",
            sought=Sought(tried=(0.01, 0.03, 0.06, 0.1, 0.16)),
        ),
    ),
    channels=("yaw_rate_radps", "accel_y_mps2"),
    seen_as="yaw rate that rounds the corners of the steering command",
    source="definition; solved exactly for a command held over a tick",
    shows_in=("steered",),
    also=("servo lag", "servo time constant"),
)
