"""Tyres that are not as large as the file says."""

from rcc_sim.jit import jit
from rcc_sim.physics.effect import Effect, Param


@jit
def true_radius(r_w, scale):
    """Radius [m] that the wheels roll on; controller and log use the file's r_w."""
    return r_w * scale


EFFECT = Effect(
    id="wheel_radius",
    title="tyre radius not what the file says",
    equation="r -> scale r_w; the controller and speed_mps keep r_w",
    params=(
        Param(
            "scale",
            neutral=1.0,
            bounds=(0.5, 2.0),
            typical=(0.95, 1.05),
            about="true radius over the file's",
        ),
    ),
    channels=("motor_current_a", "yaw_rate_radps", "x_m"),
    seen_as="true distance and speed that differ from the motor's by a factor",
    source="definition",
    shows_in=("turning",),
    also=("tyre radius", "tire radius", "wheel diameter"),
)
