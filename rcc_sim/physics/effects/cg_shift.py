"""A centre of mass that is not where the file says."""

from rcc_sim.jit import jit
from rcc_sim.physics.effect import Effect, Param


@jit
def shifted_axles(l_F, l_R, shift):
    """Distances [m] to front and rear axle with the centre of mass moved forward."""
    return l_F - shift, l_R + shift


EFFECT = Effect(
    id="cg_shift",
    title="centre of mass not where the file says",
    equation="l_F -> l_F - s, l_R -> l_R + s",
    params=(
        Param(
            "shift_m",
            neutral=0.0,
            bounds=(-2.0, 2.0),
            typical=(-0.3, 0.3),
            about="shift s of the centre of mass, positive forward",
        ),
    ),
    channels=("yaw_rate_radps", "accel_y_mps2"),
    seen_as="under- or oversteer that the file does not have",
    source="definition",
    shows_in=("steered",),
    also=("centre of gravity", "center of gravity", "weight distribution"),
)
