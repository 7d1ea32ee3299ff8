"""From wheels to battery: shaft, motor, battery terminals."""

from math import inf

from rcc_sim.jit import jit
from rcc_sim.physics.effects.auxiliary_gain import drawn_power
from rcc_sim.physics.effects.auxiliary_load import auxiliary_power
from rcc_sim.physics.effects.battery_resistance import terminal_current
from rcc_sim.physics.effects.copper_loss import copper_power
from rcc_sim.physics.effects.friction_brake import motor_share
from rcc_sim.physics.effects.motor_efficiency import (
    conversion_loss,
    map_efficiency,
    outside_map,
)
from rcc_sim.physics.effects.regeneration_fade import regenerated_share
from rcc_sim.physics.extra import EXTRA, book_draw

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


@jit
def mapped_efficiency(p, c, u, f, flow, eta, dt):
    """Efficiency of motor and inverter [1] during the step; counts where the map ends.

    ``eta`` is the map: torque, speed, efficiency by both.
    """
    omega = c.n * f.w
    if outside_map(u.tau, omega, eta[0], eta[1]):
        flow.outside += dt
    scale = p.motor_efficiency.scale
    return map_efficiency(u.tau, omega, scale, eta[0], eta[1], eta[2])


@jit
def electrify(p, c, u, f, E, flow, eff, dt):
    """From shaft to battery terminals: P_b = tau ω + 3/2 R I_q² + losses + aux.

    ``eff`` is the efficiency of motor and inverter, beside the single loss terms.
    """
    omega = c.n * f.w
    i_q = q_current(u.tau, c.K_t)
    share = 1.0
    if f.moving < dt:
        share = f.moving / dt
    P_shaft = u.tau * omega * share
    P_copper = copper_power(i_q, p.copper_loss.phase_resistance_ohm)
    P_lost = conversion_loss(P_shaft, eff)
    beside = drawn_power(u.aux, p.auxiliary_gain.gain)
    P_aux = auxiliary_power(p.auxiliary_load.power_w, beside)
    P = P_shaft + P_copper + P_lost + P_aux
    if EXTRA:
        P += f.draw
    R_i = p.battery_resistance.resistance_ohm
    i = terminal_current(P, p.battery.u_0, R_i)
    flow.P_over = max(flow.P_over, P * c.per_P_max)
    sag = R_i * i * i
    if c.booked > 0.0:
        E.copper_loss += P_copper * dt
        E.motor_efficiency += P_lost * dt
        E.auxiliary_load += P_aux * dt
        E.battery_resistance += sag * dt
        if EXTRA:
            book_draw(f, E, dt)
    flow.dt += dt
    flow.i_q += i_q * dt
    flow.tau += u.tau * dt
    flow.P += P * dt
    flow.i += i * dt
    flow.u += (p.battery.u_0 - R_i * i) * dt
    flow.aux += u.aux * dt
    flow.E += (P + sag) * dt
    flow.E_abs += abs(P + sag) * dt
