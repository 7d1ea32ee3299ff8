"""A steering linkage with another ratio than the command assumes."""

from rcc_sim.jit import jit
from rcc_sim.physics.effect import Effect, Param


@jit
def geared_angle(command, gain):
    """Angle [rad] that the linkage makes of a command [rad]."""
    return gain * command


EFFECT = Effect(
    id="steering_gain",
    title="gain of the steering linkage",
    equation="angle = gain * command",
    params=(
        Param(
            "gain",
            neutral=1.0,
            bounds=(-3.0, 3.0),
            typical=(0.8, 1.2),
            about="road-wheel angle over commanded angle",
        ),
    ),
    channels=("yaw_rate_radps", "accel_y_mps2"),
    seen_as="yaw rate in proportion to steer, at every speed",
    source="definition",
    shows_in=("steered",),
    also=("servo gain",),
)
