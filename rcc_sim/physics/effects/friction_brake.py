"""The share of braking that friction brakes take beside the motor."""

from rcc_sim.jit import jit
from rcc_sim.physics.effect import Effect, Param, Sought


@jit
def motor_share(share):
    """Share of a braking torque [1] that is left to the motor."""
    return 1.0 - share


EFFECT = Effect(
    id="friction_brake",
    title="friction brakes that share all braking with the motor",
    equation="tau = (1 - share) tau_demanded while tau_demanded < 0",
    params=(
        Param(
            "share",
            neutral=0.0,
            bounds=(0.0, 1.0),
            typical=(0.05, 0.5),
            about="of each braking torque at the shaft, what friction brakes take; the "
            "motor's limit comes after it",
            sought=Sought(shows_in=("imposed",)),
        ),
    ),
    channels=("motor_torque_nm", "battery_power_w"),
    seen_as="less given back in every braking, in proportion to how hard it is",
    source="M. Ehsani et al., Modern Electric, Hybrid Electric and Fuel Cell "
    "Vehicles, CRC Press, 2018, ch. 14: parallel braking",
    also=("brakes", "braking"),
)
