"""Ohmic loss of the three motor phases."""

from rcc_sim.jit import jit
from rcc_sim.physics.effect import Effect, Param


@jit
def copper_power(i_q, R):
    """Ohmic loss 3/2 R I_q² [W] of q-current i_q [A], phase resistance R [ohm]."""
    return 1.5 * R * i_q * i_q


EFFECT = Effect(
    id="copper_loss",
    title="ohmic loss of the motor's phases",
    equation="P = 3/2 R I_q^2",
    params=(
        Param(
            "phase_resistance_ohm",
            neutral=0.0,
            bounds=(0.0, 10.0),
            typical=(0.005, 0.1),
            about="resistance R of one phase",
        ),
    ),
    channels=("battery_power_w", "battery_current_a"),
    sink="copper_loss",
    needs=("motor.poles", "motor.flux_linkage_wb"),
    seen_as="battery power that grows with the square of torque, at any speed",
    source="P. Krause et al., Analysis of Electric Machinery, Wiley, 2013, ch. 4 "
    "(amplitude-invariant transform, hence 3/2)",
    also=("phase resistance", "winding resistance", "i2r"),
)
