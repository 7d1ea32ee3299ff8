"""Loss of the gears in proportion to the power that passes through them."""

from rcc_sim.jit import jit
from rcc_sim.physics.effect import Effect, Param


@jit
def gear_transmission(T_load, efficiency):
    """Wheel torque per shaft torque [1]: eta when driving, 1/eta when braking.

    T_load is the torque [N m] that the shaft hands to the gears.
    """
    if T_load >= 0.0:
        return efficiency
    return 1.0 / efficiency


EFFECT = Effect(
    id="gear_loss",
    title="load-dependent gear loss",
    equation="F_x r_w / N_d = eta T_L when driving, T_L / eta when braking",
    params=(
        Param(
            "efficiency",
            neutral=1.0,
            bounds=(0.3, 1.0),
            typical=(0.85, 0.99),
            about="efficiency of one pass, the same in both directions",
        ),
    ),
    channels=("motor_torque_nm", "battery_power_w"),
    sink="gear_loss",
    seen_as="torque short in proportion to load: most in hard acceleration",
    source="G. Niemann, H. Winter, Maschinenelemente II, Springer, 2003, ch. 21",
    also=("gear efficiency", "transmission efficiency"),
)
