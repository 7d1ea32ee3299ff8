"""A speed loop whose gains are not what the file says."""

from rcc_sim.jit import jit
from rcc_sim.physics.effect import Effect, Param


@jit
def true_gain(K, scale):
    """Gain of the loop, proportional or integral: scale times the file's."""
    return K * scale


EFFECT = Effect(
    id="speed_loop",
    title="gains of the speed loop not what the file says",
    equation="K_p -> s_p K_p, K_i -> s_i K_i",
    params=(
        Param(
            "proportional_scale",
            neutral=1.0,
            bounds=(0.0, 20.0),
            typical=(0.5, 2.0),
            about="true proportional gain over the file's",
            optional=True,
        ),
        Param(
            "integral_scale",
            neutral=1.0,
            bounds=(0.0, 20.0),
            typical=(0.5, 2.0),
            about="true integral gain over the file's",
            optional=True,
        ),
    ),
    channels=("speed_mps", "motor_current_a"),
    seen_as="speed that follows the reference more or less tightly",
    source="definition",
    shows_in=("commanded", "speed_loop"),
    also=("controller gains", "pid", "pi gains"),
)
