"""Wheels that do not stand straight when told to."""

from rcc_sim.jit import jit
from rcc_sim.physics.effect import Effect, Param


@jit
def offset_angle(angle, offset):
    """Angle [rad] with the constant offset of the linkage, positive to the left."""
    return angle + offset


EFFECT = Effect(
    id="steering_offset",
    title="offset of the steering",
    equation="angle = command + offset",
    params=(
        Param(
            "angle_rad",
            neutral=0.0,
            bounds=(-0.6, 0.6),
            typical=(-0.05, 0.05),
            about="offset of the road wheels, positive to the left",
        ),
    ),
    channels=("yaw_rate_radps", "accel_y_mps2"),
    seen_as="drift to one side, and counter-steering where somebody follows a path",
    source="definition",
    shows_in=("steered",),
    also=("trim",),
)
