"""Viscous damping of the driveline, felt at the motor shaft."""

from rcc_sim.jit import jit
from rcc_sim.physics.effect import Effect, Param


@jit
def damping_torque(omega, B):
    """Viscous torque B ω [N m] at shaft speed omega [rad/s], B [N m s/rad]."""
    return B * omega


EFFECT = Effect(
    id="drivetrain_damping",
    title="viscous damping of the driveline",
    equation="tau = B omega",
    params=(
        Param(
            "damping_nms_per_rad",
            neutral=0.0,
            bounds=(0.0, 10.0),
            typical=(1e-6, 0.2),
            about="viscous coefficient B at the motor shaft",
        ),
    ),
    channels=("motor_current_a", "motor_torque_nm", "battery_power_w"),
    sink="drivetrain_damping",
    seen_as="a torque that grows in proportion to speed, at any load",
    source="S. Kumari et al., Development of a scaled setup, appendix A, eq. J dω/dt",
    also=("viscous friction",),
)
