"""Motor commands that arrive late."""

from rcc_sim.jit import jit
from rcc_sim.physics.effect import Effect, Param, Sought
from rcc_sim.physics.effects.steering_delay import DEAD_TIMES, delayed


@jit
def command_of(line, k, delay, T, value):
    """Motor command of `delay` [s] ago; see :func:`delayed`."""
    return delayed(line, k, delay, T, value)


EFFECT = Effect(
    id="actuation_delay",
    title="dead time of the motor command",
    equation="tau(t) = command(t - delay)",
    params=(
        Param(
            "delay_s",
            neutral=0.0,
            bounds=(0.0, 2.0),
            typical=(0.005, 0.1),
            about="dead time of the command",
            sought=Sought(tried=DEAD_TIMES),
        ),
    ),
    channels=("speed_mps", "motor_current_a"),
    seen_as="current and speed that answer late, a loop near to swinging",
    source="definition",
    shows_in=("commanded",),
    also=("motor delay", "dead time", "latency"),
)
