"""Magnetic drag of the motor's iron: hysteresis and eddy currents."""

from rcc_sim.jit import jit
from rcc_sim.physics.effect import Effect, Param, Sought


@jit
def iron_torque(omega, T_hysteresis, k_eddy):
    """Magnetic drag T_h + k_e ω [N m] of a turning shaft at omega [rad/s]."""
    return T_hysteresis + k_eddy * omega


EFFECT = Effect(
    id="iron_loss",
    title="magnetic drag of the motor",
    equation="tau = T_h sign(omega) + k_e omega",
    params=(
        Param(
            "hysteresis_torque_nm",
            neutral=0.0,
            bounds=(0.0, 20.0),
            typical=(1e-4, 1.0),
            about="hysteresis torque T_h",
            optional=True,
            sought=Sought(same_as="effects.drivetrain_friction.torque_nm"),
        ),
        Param(
            "eddy_nms_per_rad",
            neutral=0.0,
            bounds=(0.0, 1.0),
            typical=(1e-7, 5e-3),
            about="eddy-current coefficient k_e",
            optional=True,
            sought=Sought(same_as="effects.drivetrain_damping.damping_nms_per_rad"),
        ),
    ),
    channels=("motor_current_a", "motor_torque_nm", "battery_power_w"),
    sink="iron_loss",
    seen_as="drag at the shaft that is there with the wheels off the ground",
    source="J. Pyrhönen et al., Design of Rotating Electrical Machines, Wiley, 2014, "
    "ch. 3 (loss ∝ f and f², hence torque constant and ∝ speed)",
    also=("hysteresis", "eddy currents", "cogging"),
)
