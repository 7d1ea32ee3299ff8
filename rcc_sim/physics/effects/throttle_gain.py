"""A throttle that drives harder or softer than the vehicle's map says."""

from rcc_sim.jit import jit
from rcc_sim.physics.effect import Effect, Param


@jit
def given_force(mapped, gain):
    """Wheel force [N] that a throttle gives where the map says ``mapped``."""
    return gain * mapped


EFFECT = Effect(
    id="throttle_gain",
    title="gain of the throttle",
    equation="force = gain * force of the map",
    params=(
        Param(
            "gain",
            neutral=1.0,
            bounds=(0.1, 10.0),
            typical=(0.85, 2.0),
            about="drive force over the map's, at the same throttle and speed",
        ),
    ),
    channels=("speed_mps", "accel_x_mps2"),
    seen_as="launches harder or softer in proportion to the force, coasting as before",
    source="definition; as another charge, pack or setting of the controller makes it",
    shows_in=("commanded", "throttle"),
)
