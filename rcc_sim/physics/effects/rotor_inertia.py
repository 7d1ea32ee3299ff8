"""Inertia of everything that turns with the motor."""

from rcc_sim.jit import jit
from rcc_sim.physics.effect import Effect, Param


@jit
def reflected_mass(J, n):
    """Mass [kg] that a shaft inertia J [kg m²] adds at n = N_d / r_w [1/m]."""
    return J * n * n


EFFECT = Effect(
    id="rotor_inertia",
    title="inertia of motor, driveline and wheels",
    equation="tau = J domega/dt",
    params=(
        Param(
            "inertia_kgm2",
            neutral=0.0,
            bounds=(0.0, 100.0),
            typical=(1e-6, 0.3),
            about="inertia J of all that turns, at the motor shaft",
        ),
    ),
    channels=("motor_current_a", "motor_torque_nm", "speed_mps"),
    sink="rotor_inertia",
    seen_as="more torque in every acceleration, given back in the deceleration",
    source="S. Kumari et al., Development of a scaled setup, appendix A, eq. J dω/dt",
    also=("flywheel",),
)
