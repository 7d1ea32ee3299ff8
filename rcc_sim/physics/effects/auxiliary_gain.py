"""A logged auxiliary power that is not what the battery gives for it."""

from rcc_sim.jit import jit
from rcc_sim.physics.effect import Effect, Param


@jit
def drawn_power(logged, gain):
    """Draw [W] on the battery where ``logged`` is what a log says of it."""
    return gain * logged


EFFECT = Effect(
    id="auxiliary_gain",
    title="gain of the logged auxiliary power",
    equation="P_aux = ... + gain * aux_power_w",
    params=(
        Param(
            "gain",
            neutral=1.0,
            bounds=(0.1, 10.0),
            typical=(0.7, 1.5),
            about="auxiliary power drawn from the battery over the logged one",
        ),
    ),
    channels=("battery_power_w", "battery_current_a"),
    seen_as="battery power that is off in proportion to the auxiliary power",
    source="definition; a sensor behind a converter, or one of several loads logged",
    shows_in=("metered",),
    also=("dc/dc converter", "converter loss", "auxiliary sensor"),
)
