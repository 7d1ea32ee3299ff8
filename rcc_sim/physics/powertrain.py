"""From wheels to battery: shaft, motor, battery terminals."""

from math import inf

from rcc_sim.jit import jit
from rcc_sim.physics.effects.friction_brake import motor_share
from rcc_sim.physics.effects.regeneration_fade import regenerated_share

PER_SQRT_3 = 0.5773502691896258


@jit
def torque_constant(poles, flux_linkage):
    """Torque per q-current 3/2 N_p/2 λ [N m/A] of poles N_p, flux linkage λ [Wb]."""
    return 1.5 * (poles / 2.0) * flux_linkage


@jit
def torque_envelope(tau_max, P_max, omega):
    """Most torque [N m] at shaft speed omega [rad/s]: tau_max, then P_max / ω."""
    if P_max < inf and omega * tau_max > P_max:
        return P_max / omega
    return tau_max


@jit
def voltage_limited_current(u, omega, R, psi):
    """Most motoring q-current [A] that a battery of u [V] can drive at omega [rad/s].

    V_q = R I_q + psi ω may reach u / √3 (space-vector modulation, no field weakening);
    psi [V s] is N_p/2 λ, and 0 where the motor's constants are unknown.
    """
    if psi <= 0.0:
        return inf
    left = u * PER_SQRT_3 - psi * omega
    if left <= 0.0:
        return 0.0
    if R <= 0.0:
        return inf
    return left / R


@jit
def q_current(tau, K_t):
    """q-current [A] of torque tau [N m]; 0 where the motor's constants are unknown."""
    if K_t > 0.0:
        return tau / K_t
    return 0.0


def dq_voltages(i_q, omega, *, R, L_q, poles, flux_linkage):
    r"""Voltages V_d, V_q [V] of a motor that carries q-current alone.

    .. math:: V_d = -\omega_e L_q I_q, \quad V_q = R I_q + \omega_e \lambda

    with the electrical speed ω_e = N_p/2 ω; arrays or numbers. [1]_

    References
    ----------
    .. [1] P. Krause et al., Analysis of Electric Machinery, Wiley, 2013, ch. 4.
    """
    omega_e = poles / 2 * omega
    return -omega_e * L_q * i_q, R * i_q + omega_e * flux_linkage


@jit
def least_torque(p, c, omega):
    """Torque [N m] below which the motor does not brake at omega [rad/s]."""
    return max(c.tau_min, -torque_envelope(p.motor.tau_max, p.motor.P_max, omega))


@jit
def motor_brakes(p, tau, v):
    """Torque [N m] that friction brakes leave to the motor of a demand at v [m/s]."""
    if tau >= 0.0:
        return tau
    share = regenerated_share(v, p.regeneration_fade.fade_speed_mps)
    return tau * share * motor_share(p.friction_brake.share)
