"""A servo that takes its time."""

import math

from rcc_sim.jit import jit
from rcc_sim.physics.effect import Effect, Param


@jit
def lagged(value, target, time_constant, dt):
    """First-order lag: value after dt [s] towards a target; none if there is no lag."""
    if time_constant <= 0.0:
        return target
    return value + (target - value) * (1.0 - math.exp(-dt / time_constant))


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
        ),
    ),
    channels=("yaw_rate_radps", "accel_y_mps2"),
    seen_as="yaw rate that rounds the corners of the steering command",
    source="definition; solved exactly for a command held over a tick",
)
