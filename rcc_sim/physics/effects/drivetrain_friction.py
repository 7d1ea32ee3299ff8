"""Dry (Coulomb) friction of the driveline, felt at the motor shaft."""

from rcc_sim.jit import jit
from rcc_sim.physics.effect import Effect, Param


@jit
def friction_torque(torque):
    """Coulomb torque [N m] of a turning shaft; at rest it is the most that holds."""
    return torque


EFFECT = Effect(
    id="drivetrain_friction",
    title="dry friction of the driveline",
    equation="tau = T_C sign(omega); at rest whatever holds, up to T_C",
    params=(
        Param(
            "torque_nm",
            neutral=0.0,
            bounds=(0.0, 100.0),
            typical=(1e-4, 5.0),
            about="Coulomb torque T_C at the motor shaft",
        ),
    ),
    channels=("motor_current_a", "motor_torque_nm", "battery_power_w"),
    sink="drivetrain_friction",
    seen_as="the same torque at every speed, wheels on the ground or off it",
    source="B. Armstrong-Hélouvry et al., Automatica 30 (1994) 1083-1138",
    also=("coulomb friction", "dragging brake"),
)
