"""Aerodynamic drag, in still air or in wind along the road."""

from rcc_sim.jit import jit
from rcc_sim.physics.effect import Effect, Param, Sought


@jit
def drag_force(v_air, drag_area, rho):
    """Drag ½ ρ C_d A v|v| [N] at air speed v_air [m/s], C_d A [m²], rho [kg/m³]."""
    return 0.5 * rho * drag_area * v_air * abs(v_air)


EFFECT = Effect(
    id="aerodynamic_drag",
    title="aerodynamic drag",
    equation="F = 1/2 rho C_d A v_air |v_air|",
    params=(
        Param(
            "drag_area_m2",
            neutral=0.0,
            bounds=(0.0, 20.0),
            typical=(0.01, 1.2),
            about="drag area C_d A",
        ),
        Param(
            "air_density_kg_per_m3",
            neutral=1.2,
            bounds=(0.2, 2.0),
            typical=(1.0, 1.3),
            about="density of the air rho",
            optional=True,
            sought=Sought(fitted=False),
        ),
    ),
    channels=("motor_current_a", "battery_power_w"),
    sink="aerodynamic_drag",
    seen_as="power that grows with the cube of speed",
    source="T. D. Gillespie, Fundamentals of Vehicle Dynamics, SAE, 1992, ch. 4",
    also=("air drag", "air resistance", "roof box", "cda"),
)
