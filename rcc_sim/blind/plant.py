"""The vehicle behind withheld data: written apart from the model under test.

It obeys the same description (DESIGN, section 3) by other means. The motor's speed is
the state that is integrated, the explicit midpoint rule moves everything at once, the
current follows its command with a lag, the road is rough, and energy is booked from
the rates at the middle of a step. Nothing of the model's physics is imported.
"""

from __future__ import annotations

import math
from math import inf
from typing import NamedTuple

from rcc_sim.jit import jit

GRAVITY = 9.80665  # m/s²
CLOCK = 0.01  # s; between entries of a command, and the window of a mean
SHAPE = 1.3  # 1; shape factor of the lateral tyre curve
CURRENT_LAG = 0.002  # s; of the current loop
COLUMNS = 10  # speed, yaw rate, a_x, a_y, I_q, u, i, elevation, distance, activity
SINKS = (
    "battery",
    "copper",
    "auxiliary",
    "sag",
    "conversion",
    "damping",
    "friction",
    "iron",
    "gear",
    "rolling",
    "air",
    "grade",
    "brakes",
    "slip_front",
    "slip_rear",
    "rough_road",
    "unknown",
    "kinetic",
)


class Truth(NamedTuple):
    """Every figure of one true vehicle, SI, neutral by default where it may be."""

    speed_mode: bool
    m: float
    I_z: float
    l_F: float
    l_R: float
    C_F: float
    C_R: float
    n: float  # motor speed per road speed, by the wheels' true radius [rad/m]
    n_file: float  # the same by the file's radius: what controller and log use
    K_t: float
    K_p: float = 0.0
    K_i: float = 0.0
    i_max: float = inf
    tau_max: float = inf
    J: float = 0.0
    visc: float = 0.0
    dry: float = 0.0
    hysteresis: float = 0.0
    eddy: float = 0.0
    eta_gear: float = 1.0
    R_phase: float = 0.0
    eta_motor: float = 1.0
    P_aux: float = 0.0
    u_0: float = 12.0
    R_i: float = 0.0
    regen: float = inf  # most braking torque of the motor [N m]
    brake_share: float = 0.0  # of all braking, what friction brakes take
    fade: float = 0.0  # speed below which they take over [m/s]
    i_limit: float = inf
    dead_zone: float = 0.0
    hold: float = CLOCK
    ref_delay: float = 0.0
    delay: float = 0.0
    lag: float = 0.0
    C_rr: float = 0.0
    half_rho_A: float = 0.0
    wind: float = 0.0
    slope: float = 0.0
    mu: float = inf
    sigma: float = 0.0
    v_low: float = 0.05
    steer_offset: float = 0.0
    steer_gain: float = 1.0
    steer_lag: float = 0.0
    steer_delay: float = 0.0
    play: float = 0.0
    yaw_late: float = 0.0
    T_driver: float = 0.8
    # what no library holds
    rub_at: float = inf
    rub_T: float = 0.0
    band_v: float = 0.0
    band_w: float = 1.0
    band_T: float = 0.0
    stick_T: float = 0.0
    stick_s: float = 1.0
    warm_T: float = 0.0
    warm_s: float = 1.0
    left_gain: float = 1.0
    patch_mu: float = inf
    patch_every: float = inf
    patch_from: float = 0.0
    patch_long: float = 0.0
    freeze_every: float = inf
    freeze_s: float = 0.0
    drop_m: float = 0.0
    drop_t: float = inf
    over_T: float = inf  # torque beyond which an inverter loses more [N m]
    over_loss: float = 0.0  # of the shaft's power, at twice that torque


class Drive(NamedTuple):
    """One drive: commands and road by the clock, rows by the step.

    Between two ticks of the clock a command runs straight. The speed loop samples its
    reference (``Truth.hold``); the steering follows its command at all times.
    """

    ref: object  # speed [m/s] at each tick of the clock
    steer: object  # road-wheel angle commanded [rad] at each tick of the clock
    rough: object  # random acceleration of the body [m/s²] at each tick
    slope: object  # profile over distance [1], every slope_step metres
    slope_step: float
    aux: object  # power [W] beside the constant, at each second
    wind: object  # against the drive [m/s] beside the constant, likewise
    rows: object  # step number of each row


@jit
def tyre(alpha, C, D):
    """Lateral force [N] of a tyre against slip alpha [rad]: linear, or with a peak D.

    D sin(1.3 atan(C α / (1.3 D))).
    """
    if D == inf:
        return C * alpha
    return D * math.sin(SHAPE * math.atan(C * alpha / (SHAPE * D)))


@jit
def axles(p, m, mu, v, v_y, r, a_F, a_R, delta):
    """Forces [N] and slip angles [rad] of both axles; slip fades out at standstill."""
    v_c = math.sqrt(v * v + p.v_low * p.v_low)
    s_F = math.atan2(v_y + p.l_F * r, v_c) - delta * v / v_c
    s_R = math.atan2(v_y - p.l_R * r, v_c)
    load = mu * m * GRAVITY / (2.0 * (p.l_F + p.l_R))
    if p.sigma <= 0.0:
        F_F = -2.0 * tyre(s_F, p.C_F, load * p.l_R)
        F_R = -2.0 * tyre(s_R, p.C_R, load * p.l_F)
        return F_F, F_R, 0.0, 0.0
    F_F = -2.0 * tyre(a_F, p.C_F, load * p.l_R)
    F_R = -2.0 * tyre(a_R, p.C_R, load * p.l_F)
    return F_F, F_R, v_c / p.sigma * (s_F - a_F), v_c / p.sigma * (s_R - a_R)


@jit
def rates(p, m, I_z, mu, w, v_y, r, a_F, a_R, tilt, tau, push, wind, T_more):
    """Time derivatives of motor speed, lateral speed, yaw rate and felt slip.

    Newton along the body, n k (τ - T_loss - J ẇ) = m (v̇ - v_y r) + R with v = w / n;
    k is the gears' transmission. ``tilt`` holds the steering angle, its sine and
    cosine, and those of the slope; ``push`` is roughness less brakes [N]; ``wind``
    [m/s] blows against the drive. Also returns the forces, for the books.
    """
    v = w / p.n
    delta, sin, cos, rise, level = tilt
    F_F, F_R, d_F, d_R = 0.0, 0.0, 0.0, 0.0
    if delta != 0.0 or v_y != 0.0 or r != 0.0 or a_F != 0.0 or a_R != 0.0:
        F_F, F_R, d_F, d_R = axles(p, m, mu, v, v_y, r, a_F, a_R, delta)
    v_air = v + wind
    R = p.C_rr * m * GRAVITY * level + p.half_rho_A * v_air * abs(v_air)
    R += m * GRAVITY * rise - push + F_F * sin
    R -= m * v_y * r
    T = tau - (p.visc + p.eddy) * w - p.dry - p.hysteresis - T_more
    k = p.eta_gear
    if T + p.J * p.n * R / m < 0.0:
        k = 1.0 / k
    w_dot = p.n * (k * p.n * T - R) / (m + k * p.J * p.n * p.n)
    v_y_dot = (F_F * cos + F_R) / m - v * r
    r_dot = (p.l_F * F_F * cos - p.l_R * F_R) / I_z
    T_L = T - p.J * w_dot
    return w_dot, v_y_dot, r_dot, d_F, d_R, F_F, F_R, (1.0 - k) * T_L


@jit
def extra_drag(p, v, delta, since_brake, t):
    """Shaft torque [N m] of what no library holds: rub, band, sticking, warm-up."""
    T = p.warm_T * math.exp(-t / p.warm_s)
    if abs(delta) > p.rub_at:
        T += p.rub_T
    if p.band_T > 0.0:
        x = (v - p.band_v) / p.band_w
        T += p.band_T * math.exp(-0.5 * x * x)
    if since_brake < p.stick_s:
        T += p.stick_T
    return T


@jit
def is_slowed(p, tau, v, w, held, wish, brake):
    """Tell whether the vehicle is being slowed, so that a brake may stick after it."""
    if brake > 0.0:
        return True
    if p.speed_mode and held * p.n_file < 0.9 * w and wish <= 0.0:
        return True
    return tau < -0.02 * p.stick_T and v > 5.0 * p.v_low


@jit
def grip_at(p, s):
    """Grip [1] of the road after a distance [m], patches of it being slippery."""
    if (s - p.patch_from) % p.patch_every < p.patch_long and s > p.patch_from:
        return min(p.patch_mu, p.mu)
    return p.mu


@jit
def steered(p, cmd):
    """Angle [rad] that the servo aims at, as it should, and as a weak side lets it."""
    whole = p.steer_gain * cmd + p.steer_offset
    if cmd > 0.0:
        return whole, whole + (p.left_gain - 1.0) * p.steer_gain * cmd
    return whole, whole


@jit
def at(table, x):
    """Value of a table at x, in steps of it; linear, flat beyond both ends."""
    if x <= 0.0:
        return table[0]
    k = int(x)
    if k >= len(table) - 1:
        return table[-1]
    return table[k] + (x - k) * (table[k + 1] - table[k])
