"""What a step of the plant draws from its battery, and where that energy goes."""

import math

from rcc_sim.blind.plant import GRAVITY
from rcc_sim.jit import jit


@jit
def drawn(p, tau, w, P_aux):
    """Motor current, battery current, voltage, and three losses.

    Of a torque [N m] at a motor speed [rad/s], beside a load [W]: 3/2 R i² in the
    windings, what the efficiency leaves, and what no library holds; u = u_0 - R_i i_b
    at the terminals, u i_b being all that is drawn.
    """
    i_q = tau / p.K_t
    P_shaft = tau * w
    lost = P_shaft / p.eta_motor - P_shaft
    if P_shaft < 0.0:
        lost = P_shaft * p.eta_motor - P_shaft
    copper = 1.5 * p.R_phase * i_q * i_q
    over = over_load(p, tau, P_shaft)
    P = P_shaft + copper + lost + over + P_aux
    i_b = P / p.u_0
    if p.R_i > 0.0:
        left = max(p.u_0 * p.u_0 - 4.0 * p.R_i * P, 0.0)
        i_b = (p.u_0 - math.sqrt(left)) / (2.0 * p.R_i)
    return i_q, i_b, p.u_0 - p.R_i * i_b, copper, lost, over


@jit
def over_load(p, tau, P_shaft):
    """Loss [W] of an inverter driven beyond a torque [N m], by how far it is."""
    if abs(tau) <= p.over_T:
        return 0.0
    return p.over_loss * abs(P_shaft) * (abs(tau) / p.over_T - 1.0)


@jit
def book_electrics(p, E, dt, i_b, copper, lost, over, P_aux):
    """Add to the books [J]: the source, and what becomes heat before the shaft."""
    E[0] += dt * p.u_0 * i_b
    E[1] += dt * copper
    E[2] += dt * P_aux
    E[3] += dt * p.R_i * i_b * i_b
    E[4] += dt * lost
    E[16] += dt * over


@jit
def book_motion(p, E, dt, m, w, v_y, r, f, tilt, brake, push, wind, T_more):
    """Add to the books [J] what a moving vehicle spends, halfway through a step.

    ``f`` is what ``plant.rates`` returns, ``tilt`` what it takes.
    """
    v = w / p.n
    _, sin, cos, rise, level = tilt
    v_air = v + wind
    roll = p.C_rr * m * GRAVITY * level
    across = v_y + p.l_F * r
    E[5] += dt * p.visc * w * w
    E[6] += dt * p.dry * w
    E[7] += dt * (p.hysteresis + p.eddy * w) * w
    E[8] += dt * f[7] * w
    E[9] += dt * roll * v
    E[10] += dt * p.half_rho_A * v_air * abs(v_air) * v
    E[11] += dt * m * GRAVITY * rise * v
    E[12] += dt * brake * v
    E[13] -= dt * f[5] * (across * cos - v * sin)
    E[14] -= dt * f[6] * (v_y - p.l_R * r)
    E[15] -= dt * push * v
    E[16] += dt * T_more * w
