"""The speed below which regenerative braking fades out."""

from math import inf

from rcc_sim.jit import jit
from rcc_sim.physics.effect import Effect, Param, Sought

NIL = 1.0 / 3.0  # 1; of the speed at which it begins to fade, that at which it is nil


@jit
def regenerated_share(v, fade_speed):
    """Share of a braking torque [1] that the motor still takes at v [m/s]."""
    if v >= fade_speed:
        return 1.0
    return max((v / fade_speed - NIL) / (1.0 - NIL), 0.0)


EFFECT = Effect(
    id="regeneration_fade",
    title="regenerative braking that fades out at low speed",
    equation="tau = clip((v / v_f - 1/3) / (2/3), 0, 1) tau_demanded "
    "while tau_demanded < 0",
    params=(
        Param(
            "fade_speed_mps",
            neutral=0.0,
            bounds=(0.0, inf),
            typical=(1.0, 5.0),
            about="speed below which friction brakes take over, all of it at a third",
            sought=Sought(
                tried=(1.0, 2.0, 3.0, 5.0), shows_in=("imposed",), acts="steps"
            ),
        ),
    ),
    channels=("motor_torque_nm", "battery_power_w"),
    seen_as="nothing given back in the last metres before a stop",
    source="M. Ehsani et al., Modern Electric, Hybrid Electric and Fuel Cell "
    "Vehicles, CRC Press, 2018, ch. 14: braking torque of a motor at low speed",
    also=("regen fade",),
)
