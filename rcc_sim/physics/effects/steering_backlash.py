"""Play in the steering linkage."""

from rcc_sim.jit import jit
from rcc_sim.physics.effect import Effect, Param, Sought


@jit
def with_play(value, target, width):
    """Angle [rad] behind a play of whole width [rad]: it moves only when pushed."""
    return min(max(value, target - 0.5 * width), target + 0.5 * width)


EFFECT = Effect(
    id="steering_backlash",
    title="play of the steering linkage",
    equation="|angle - command| <= width / 2; moves only when pushed",
    params=(
        Param(
            "width_rad",
            neutral=0.0,
            bounds=(0.0, 0.5),
            typical=(0.005, 0.05),
            about="whole width of the play",
            sought=Sought(tried=(0.05, 0.12, 0.25), of="steering"),
        ),
    ),
    channels=("yaw_rate_radps", "accel_y_mps2"),
    seen_as="steer reversals that do nothing at first",
    source="J. Hedrick, A. Girard, Control of Nonlinear Dynamic Systems, 2010, ch. 1",
    shows_in=("steered",),
    also=("play", "slop"),
)
