"""Mass that the vehicle file does not know of."""

from rcc_sim.jit import jit
from rcc_sim.physics.effect import Effect, Param, Sought


@jit
def loaded(figure, m, payload):
    """Mass or yaw inertia with a payload [kg] spread as the body's mass m [kg]."""
    return figure * (m + payload) / m


EFFECT = Effect(
    id="payload",
    title="mass that the file does not know",
    equation="m -> m + m_p, I_z -> I_z (m + m_p) / m",
    params=(
        Param(
            "mass_kg",
            neutral=0.0,
            bounds=(-1000.0, 50000.0),
            typical=(0.1, 1000.0),
            about="mass m_p, spread as the body's own",
            sought=Sought(limits=(-0.25, 1.0), of="mass", same_as="body.mass_kg"),
        ),
    ),
    channels=("motor_current_a", "battery_power_w", "speed_mps"),
    seen_as="more force in every acceleration and more rolling resistance",
    source="definition",
    also=("mass", "weight", "passengers", "cargo"),
)
