"""The speed reference reaches the controller in steps."""

import math

from rcc_sim.jit import jit
from rcc_sim.physics.effect import Effect, Param, Sought

TICK = 1e-9  # 1; a clock that is this fraction of a period short has struck


@jit
def held_time(t, period):
    """Instant [s] whose reference holds at t [s]: the last whole period before it."""
    if period <= 0.0:
        return t
    return math.floor(t / period + TICK) * period


EFFECT = Effect(
    id="reference_sampling",
    title="zero-order hold of the speed reference",
    equation="v_ref(t) = v_ref(T floor(t / T))",
    params=(
        Param(
            "period_s",
            neutral=0.0,
            bounds=(0.0, 10.0),
            typical=(0.01, 0.5),
            about="time T between two references, counted from time 0",
            sought=Sought(
                tried=tuple(range(2, 51)), of="clock", longest=2.0, acts="clock"
            ),
        ),
    ),
    channels=("speed_mps", "motor_current_a"),
    seen_as="a staircase in speed and a current pulse at each stair",
    source="S. Kumari et al., Development of a scaled setup, appendix A.3",
    shows_in=("commanded", "speed_loop"),
)
