"""Speed references that reach the controller late."""

from rcc_sim.jit import jit
from rcc_sim.physics.effect import Effect, Param, Sought
from rcc_sim.physics.effects.steering_delay import DEAD_TIMES


@jit
def sent_at(t, delay):
    """Instant [s] at which the reference was sent that is heard at t [s]."""
    return t - delay


EFFECT = Effect(
    id="reference_delay",
    title="dead time of the speed reference",
    equation="v_heard(t) = v_ref(t - delay)",
    params=(
        Param(
            "delay_s",
            neutral=0.0,
            bounds=(0.0, 2.0),
            typical=(0.01, 0.2),
            about="dead time from the sender to the controller",
            sought=Sought(tried=DEAD_TIMES),
        ),
    ),
    channels=("speed_mps", "motor_current_a"),
    seen_as="speed and current of the same shape, later; steering as prompt as before",
    source="definition; before the speed loop, where `actuation_delay` acts within it",
    shows_in=("commanded", "speed_loop"),
    also=("reference latency", "transport delay", "late command"),
)
