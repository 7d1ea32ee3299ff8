"""Front tyres that are not as stiff as the file says."""

from rcc_sim.jit import jit
from rcc_sim.physics.effect import Effect, Param, Sought


@jit
def front_stiffness(C, scale):
    """Cornering stiffness [N/rad] of one front tyre: scale times the file's."""
    return C * scale


EFFECT = Effect(
    id="front_cornering_stiffness",
    title="front tyre stiffness not what the file says",
    equation="C -> scale C",
    params=(
        Param(
            "scale",
            neutral=1.0,
            bounds=(0.1, 10.0),
            typical=(0.7, 1.4),
            about="true stiffness of the front tyres over the file's",
            sought=Sought(same_as="tyres.front_cornering_stiffness_n_per_rad"),
        ),
    ),
    channels=("yaw_rate_radps", "accel_y_mps2"),
    seen_as="yaw gain that changes with speed",
    source="definition",
    shows_in=("steered",),
    also=("tyre stiffness", "tire stiffness", "understeer"),
)
