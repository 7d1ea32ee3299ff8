"""Throttle below which nothing moves."""

from rcc_sim.jit import jit
from rcc_sim.physics.effect import Effect, Param, Sought


@jit
def felt_throttle(throttle, threshold):
    """Throttle that acts: what it is beyond the threshold, 0 below."""
    if throttle > threshold:
        return throttle - threshold
    if throttle < -threshold:
        return throttle + threshold
    return 0.0


EFFECT = Effect(
    id="throttle_dead_zone",
    title="dead zone of the throttle",
    equation="throttle -> throttle less the threshold, 0 below it",
    params=(
        Param(
            "threshold",
            neutral=0.0,
            bounds=(0.0, 1.0),
            typical=(0.02, 0.3),
            about="throttle below which nothing moves",
            sought=Sought(tried=(0.05, 0.1, 0.15, 0.2, 0.3)),
        ),
    ),
    channels=("speed_mps",),
    seen_as="a car that stands until the throttle passes a value",
    source="definition; as in the DART car's force map, F proportional to throttle "
    "less 0.1638 (L. Lyons et al., IEEE 10588526, 2024)",
    shows_in=("commanded", "throttle"),
)
