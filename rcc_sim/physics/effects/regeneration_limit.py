"""The most that the motor may brake with."""

from math import inf

from rcc_sim.jit import jit
from rcc_sim.physics.effect import Effect, Param, Sought


@jit
def braking_limit(max_current, max_torque, K_t):
    """Largest braking torque [N m] from either limit, torque constant K_t [N m/A]."""
    if K_t > 0.0:
        return min(max_torque, max_current * K_t)
    return max_torque


EFFECT = Effect(
    id="regeneration_limit",
    title="limit of regenerative braking",
    equation="tau >= -min(tau_max, K_t I_max)",
    params=(
        Param(
            "max_current_a",
            neutral=inf,
            bounds=(0.0, inf),
            typical=(0.0, 400.0),
            about="largest braking q-current; 0: none, as the RC car",
            optional=True,
            sought=Sought(
                tried=(0.0, 0.1, 0.25, 0.5, 0.75),
                of="braking_current",
                shows_in=("commanded",),
            ),
        ),
        Param(
            "max_torque_nm",
            neutral=inf,
            bounds=(0.0, inf),
            typical=(0.0, 1000.0),
            about="largest braking torque at the motor shaft",
            optional=True,
            sought=Sought(
                tried=(0.0, 0.1, 0.25, 0.5, 0.75),
                of="braking_torque",
                shows_in=("imposed",),
            ),
        ),
    ),
    channels=("motor_current_a", "battery_power_w", "speed_mps"),
    seen_as="no current, or a flat one, where braking would give energy back",
    source="S. Kumari et al., Development of a scaled setup, appendix A.3",
    either=True,
    also=("regen limit", "recuperation"),
)
