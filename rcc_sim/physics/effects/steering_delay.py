"""Steering commands that arrive late."""

from rcc_sim.jit import jit
from rcc_sim.physics.effect import Effect, Param, Sought

DEAD_TIMES = (0.01, 0.03, 0.06, 0.1, 0.16)  # s; those of a command that are tried


@jit
def delayed(line, k, delay, T, value):
    """Value of `delay` [s] ago, fractions of a tick T [s] interpolated.

    The line is a ring that holds at least delay / T + 2 values, 0 before the start;
    k counts the ticks.
    """
    if delay <= 0.0:
        return value
    line[k % len(line)] = value
    ticks = delay / T
    whole = int(ticks)
    later = line[(k - whole) % len(line)]
    earlier = line[(k - whole - 1) % len(line)]
    return later + (earlier - later) * (ticks - whole)


EFFECT = Effect(
    id="steering_delay",
    title="dead time of the steering",
    equation="angle(t) = command(t - delay)",
    params=(
        Param(
            "delay_s",
            neutral=0.0,
            bounds=(0.0, 2.0),
            typical=(0.01, 0.2),
            about="dead time of the command",
            sought=Sought(tried=DEAD_TIMES),
        ),
    ),
    channels=("yaw_rate_radps", "accel_y_mps2"),
    seen_as="yaw rate that answers late, with the same shape",
    source="definition",
    shows_in=("steered",),
    also=("servo delay",),
)
