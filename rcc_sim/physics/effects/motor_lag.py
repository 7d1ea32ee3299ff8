"""A drive force that builds up gradually."""

import math

from rcc_sim.jit import jit
from rcc_sim.physics.effect import Effect, Param
from rcc_sim.physics.effects.steering_lag import lagged


@jit
def built_up(value, target, time_constant, dt):
    """First-order lag of the drive force: value after dt [s] towards a target."""
    return lagged(value, target, time_constant, dt)


@jit
def mean_force(value, target, time_constant, dt):
    """Mean of the drive force over dt [s], on its way from a value to a target."""
    if time_constant <= 0.0:
        return target
    share = -math.expm1(-dt / time_constant) * time_constant / dt
    return target + (value - target) * share


EFFECT = Effect(
    id="motor_lag",
    title="lag of the drive force",
    equation="T dtau/dt + tau = command",
    params=(
        Param(
            "time_constant_s",
            neutral=0.0,
            bounds=(0.0, 5.0),
            typical=(0.02, 0.3),
            about="time constant T of the force",
        ),
    ),
    channels=("speed_mps", "accel_x_mps2"),
    seen_as="acceleration that rounds the corners of the throttle",
    source="definition; solved exactly for a command held over a tick",
)
