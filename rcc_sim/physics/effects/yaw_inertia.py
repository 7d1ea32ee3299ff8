"""A yaw inertia that is not what the file says."""

from rcc_sim.jit import jit
from rcc_sim.physics.effect import Effect, Param, Sought


@jit
def true_yaw_inertia(I_z, scale):
    """Yaw inertia [kg m²]: scale times the file's."""
    return I_z * scale


EFFECT = Effect(
    id="yaw_inertia",
    title="yaw inertia not what the file says",
    equation="I_z -> scale I_z",
    params=(
        Param(
            "scale",
            neutral=1.0,
            bounds=(0.1, 10.0),
            typical=(0.8, 1.25),
            about="true yaw inertia over the file's",
            sought=Sought(same_as="body.yaw_inertia_kgm2"),
        ),
    ),
    channels=("yaw_rate_radps",),
    seen_as="yaw rate that follows quick steering sooner or later",
    source="definition",
    shows_in=("steered",),
    also=("moment of inertia",),
)
