"""Throttle below which nothing moves."""

from rcc_sim.jit import jit
from rcc_sim.physics.effect import Effect, Param


@jit
def felt_throttle(throttle, threshold):
    """Throttle that acts: 0 below the threshold."""
    if abs(throttle) < threshold:
        return 0.0
    return throttle


EFFECT = Effect(
    id="throttle_dead_zone",
    title="dead zone of the throttle",
    equation="throttle -> 0 below the threshold",
    params=(
        Param(
            "threshold",
            neutral=0.0,
            bounds=(0.0, 1.0),
            typical=(0.02, 0.3),
            about="throttle below which nothing moves",
        ),
    ),
    channels=("speed_mps",),
    seen_as="a car that stands until the throttle passes a value",
    source="definition",
)
