"""Rolling resistance of the tyres."""

from rcc_sim.jit import jit
from rcc_sim.physics.effect import Effect, Param


@jit
def rolling_force(F_z, coefficient):
    """Rolling resistance C_rr F_z [N] of a rolling vehicle of weight F_z [N].

    At rest it is the most that holds; the step sees to that.
    """
    return coefficient * F_z


EFFECT = Effect(
    id="rolling_resistance",
    title="rolling resistance",
    equation="F = C_rr m g cos(slope)",
    params=(
        Param(
            "coefficient",
            neutral=0.0,
            bounds=(0.0, 0.3),
            typical=(0.006, 0.05),
            about="rolling resistance coefficient C_rr",
        ),
    ),
    channels=("motor_current_a", "battery_power_w"),
    sink="rolling_resistance",
    seen_as="a coast-down that slows at nearly the same rate at every speed",
    source="T. D. Gillespie, Fundamentals of Vehicle Dynamics, SAE, 1992, ch. 4",
    also=("crr", "tyre pressure", "soft tyres"),
)
