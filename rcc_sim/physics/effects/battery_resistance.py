"""Internal resistance of the battery: sag under load."""

import math

from rcc_sim.jit import jit
from rcc_sim.physics.effect import Effect, Param


@jit
def terminal_current(P, u_0, R):
    """Battery current [A] for power P [W] at the terminals, open circuit u_0 [V].

    Solves P = (u_0 - R i) i for the root of small current, written without
    cancellation, i = 2 P / (u_0 + sqrt(u_0² - 4 R P)): P / u_0 without a resistance.
    Past the most power that the battery can give, u_0²/(4 R), the current
    stays at u_0/(2 R).
    """
    if R == 0.0:
        return P / u_0
    root = u_0 * u_0 - 4.0 * R * P
    if root < 0.0:
        return u_0 / (2.0 * R)
    return 2.0 * P / (u_0 + math.sqrt(root))


EFFECT = Effect(
    id="battery_resistance",
    title="internal resistance of the battery",
    equation="u = u_0 - R_i i",
    params=(
        Param(
            "resistance_ohm",
            neutral=0.0,
            bounds=(0.0, 10.0),
            typical=(0.005, 0.15),
            about="internal resistance R_i of the whole pack",
        ),
    ),
    channels=("battery_voltage_v",),
    sink="battery_resistance",
    needs_any=("battery.open_circuit_voltage_v", "battery.nominal_voltage_v"),
    seen_as="terminal voltage that falls in proportion to current",
    source="G. Plett, Battery Management Systems I, Artech House, 2015, ch. 2",
    also=("internal resistance",),
)
