"""Wind along the road."""

from rcc_sim.jit import jit
from rcc_sim.physics.effect import Effect, Param, Sought


@jit
def air_speed(v_x, wind):
    """Speed [m/s] against the air at road speed v_x and headwind wind [m/s]."""
    return v_x + wind


EFFECT = Effect(
    id="headwind",
    title="headwind",
    equation="v_air = v_x + w",
    params=(
        Param(
            "speed_mps",
            neutral=0.0,
            bounds=(-60.0, 60.0),
            typical=(-5.0, 5.0),
            about="wind w against the drive; negative from behind",
            sought=Sought(limits=(-12.5, 12.5)),
        ),
    ),
    channels=("motor_current_a", "battery_power_w"),
    needs_any=(
        "effects.aerodynamic_drag.drag_area_m2",
        "effects.road_load.c_n_s2_per_m2",
    ),
    seen_as="drag that differs between the two directions of a road",
    source="definition; acts through aerodynamic_drag, or a road load's C as in "
    "SAE J2263's correction for wind",
    also=("tailwind",),
)
