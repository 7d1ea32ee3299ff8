"""Constant draw of everything on board that does not move the vehicle."""

from rcc_sim.jit import jit
from rcc_sim.physics.effect import Effect, Param


@jit
def auxiliary_power(power, beside):
    """Draw [W] on the battery: what the file states plus what a log says beside it."""
    return power + beside


EFFECT = Effect(
    id="auxiliary_load",
    title="auxiliary load",
    equation="P_b = ... + P_aux",
    params=(
        Param(
            "power_w",
            neutral=0.0,
            bounds=(0.0, 20000.0),
            typical=(2.0, 3000.0),
            about="constant electrical power beside the motor's",
        ),
    ),
    channels=("battery_power_w", "battery_current_a"),
    sink="auxiliary_load",
    seen_as="battery power at standstill, and the same on top of every other",
    source="definition",
    also=(
        "heater",
        "air conditioning",
        "hvac",
        "hotel load",
        "accessories",
        "electronics",
        "computer",
    ),
)
