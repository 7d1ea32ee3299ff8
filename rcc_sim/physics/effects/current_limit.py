"""Saturation of the motor current."""

from math import inf

from rcc_sim.jit import jit
from rcc_sim.physics.effect import Effect, Param, Sought


@jit
def limited_current(i_file, i_limit):
    """Largest motoring q-current [A]: the file's own limit or the effect's."""
    return min(i_file, i_limit)


EFFECT = Effect(
    id="current_limit",
    title="limit of the motor current",
    equation="I_q <= I_max",
    params=(
        Param(
            "max_current_a",
            neutral=inf,
            bounds=(0.0, inf),
            typical=(10.0, 800.0),
            about="largest motoring q-current",
            sought=Sought(tried=(0.3, 0.45, 0.6, 0.75, 0.9), of="motor_current"),
        ),
    ),
    channels=("motor_current_a", "speed_mps"),
    needs=("motor.poles", "motor.flux_linkage_wb"),
    seen_as="a flat top of current in hard acceleration, speed falling behind",
    source="definition",
    shows_in=("commanded",),
)
