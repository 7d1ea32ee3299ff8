"""The planar bicycle: turning of the velocity, axle forces, cornering imposed."""

import math

from rcc_sim.jit import jit
from rcc_sim.physics.effects.tyre_relaxation import (
    felt_slip,
    mean_taken_up,
    taken_up,
)
from rcc_sim.physics.effects.tyre_saturation import (
    slip_angle,
    tyre_force,
    tyre_stiffness,
)

STRAIGHT = 1e-30  # m/s and rad/s; what of a turn below which it is over


@jit
def turn_velocity(c, s, dt):
    """Turn (v_x, v_y) as the body axes turn by r dt: the m v r terms of Newton's law.

    (m + J n²) dv_x/dt = m v_y r and m dv_y/dt = -m v_x r keep the kinetic energy of
    body and rotor; the Cayley map of the rotation of v_y and sqrt(1 + J n² / m) v_x
    keeps it to the last bit.
    """
    if s.r == 0.0:
        return
    q = 0.5 * s.r * dt * c.per_spin
    share = 1.0 / (1.0 + q * q)
    cos = (1.0 - q * q) * share
    sin = 2.0 * q * share
    w = c.spin * s.v_x
    v_y = cos * s.v_y - sin * w
    w1 = cos * w + sin * s.v_y
    if w1 < 0.0:  # sliding sideways past 90°: the wheels do not roll back
        v_y = math.copysign(math.sqrt(v_y * v_y + w1 * w1), v_y)
        w1 = 0.0
    s.v_x = w1 * c.per_spin
    s.v_y = v_y


@jit
def per_rolled(w, v_slip):
    """1 over the speed w [m/s] along an axle's wheels, smoothly kept above v_slip.

    A standing wheel then has no slip angle. A division takes as long as ten products,
    so that slip and slope share this one.
    """
    return 1.0 / math.sqrt(w * w + v_slip * v_slip)


@jit
def axle_slip(u, per_w):
    """Slip angle [rad] of an axle that moves at u [m/s] across and w along its wheels.

    atan(u / w), the same as atan2(v_y + l_F r, v_x) - delta when rolling; per_w is
    1 / w (:func:`per_rolled`).
    """
    return math.atan(u * per_w)


@jit
def slip_slope(u, w, per_w, cos, sin):
    """Slope [rad s/m] of an axle's slip angle in its speed across the body.

    The wheels stand at an angle of cosine cos and sine sin to the body, so that
    u and w both change with that speed.
    """
    tan = u * per_w
    return (cos - sin * tan * w * per_w) * per_w / (1.0 + tan * tan)


@jit
def corner(c, s, u, f, v, dt):
    """Axle forces F_F, F_R [N] and mid-step v_y, r: the two lateral equations.

    m dv_y/dt = F_F cos δ + F_R (the turning of the axes is done elsewhere) and
    I_z dr/dt = l_F F_F cos δ - l_R F_R by the implicit midpoint rule, tyre forces
    linear about the start of the step: second order, stable down to standstill.

    A turn dies away and never ends. Once nothing is left of it that any sum would hold,
    it has: in numbers too small to be normal a processor is a hundred times as slow.
    """
    if (u.delta == 0.0 or v == 0.0) and max(abs(s.v_y), abs(s.r)) < STRAIGHT:
        go_straight(s, f)
        return
    cos = u.cos_delta
    across = s.v_y + c.l_F * s.r
    u_F = cos * across - u.sin_delta * v
    w_F = cos * v + u.sin_delta * across
    u_R = s.v_y - c.l_R * s.r
    per_F = per_rolled(w_F, c.v_slip)
    per_R = per_rolled(v, c.v_slip)
    rolled = 0.0
    if c.sigma > 0.0:
        rolled = dt / per_R
    share = mean_taken_up(rolled, c.sigma)
    alpha_F = felt_slip(s.alpha_F, axle_slip(u_F, per_F), share)
    alpha_R = felt_slip(s.alpha_R, axle_slip(u_R, per_R), share)
    F_F = -2.0 * tyre_force(alpha_F, c.C_F, c.D_F)
    F_R = -2.0 * tyre_force(alpha_R, c.C_R, c.D_R)
    turn_F = slip_slope(u_F, w_F, per_F, cos, u.sin_delta)
    turn_R = slip_slope(u_R, v, per_R, 1.0, 0.0)
    K_F = 2.0 * tyre_stiffness(alpha_F, c.C_F, c.D_F) * turn_F * share
    K_R = 2.0 * tyre_stiffness(alpha_R, c.C_R, c.D_R) * turn_R * share
    K = K_F * cos
    twice = 2.0 / dt
    a11 = twice * c.m + K + K_R
    a12 = K * c.l_F - K_R * c.l_R
    a22 = twice * c.I_z + K * c.l_F * c.l_F + K_R * c.l_R * c.l_R
    b1 = F_F * cos + F_R
    b2 = c.l_F * F_F * cos - c.l_R * F_R
    per_det = 1.0 / (a11 * a22 - a12 * a12)
    dv_y = (b1 * a22 - b2 * a12) * per_det
    dr = (b2 * a11 - b1 * a12) * per_det
    f.F_F = F_F - K_F * (dv_y + c.l_F * dr)
    f.F_R = F_R - K_R * (dv_y - c.l_R * dr)
    f.v_y = s.v_y + dv_y
    f.r = s.r + dr
    if c.sigma > 0.0:
        relax(c, s, u, f, v, taken_up(rolled, c.sigma))


@jit
def go_straight(s, f):
    """End a turn: no axle force is left, and no motion across."""
    s.v_y = 0.0
    s.r = 0.0
    f.F_F = 0.0
    f.F_R = 0.0
    f.v_y = 0.0
    f.r = 0.0


@jit
def relax(c, s, u, f, v, share):
    """Move the slip angles that the tyres hold towards those of the middle step."""
    across = f.v_y + c.l_F * f.r
    u_F = u.cos_delta * across - u.sin_delta * v
    w_F = u.cos_delta * v + u.sin_delta * across
    u_R = f.v_y - c.l_R * f.r
    alpha_F = axle_slip(u_F, per_rolled(w_F, c.v_slip))
    alpha_R = axle_slip(u_R, per_rolled(v, c.v_slip))
    s.alpha_F = felt_slip(s.alpha_F, alpha_F, share)
    s.alpha_R = felt_slip(s.alpha_R, alpha_R, share)


@jit
def carry_round(c, s, u, f, v, dt):
    """Axle forces [N] and mid-step v_y of a vehicle whose yaw rate alone is known.

    From m dv_y/dt = F_F + F_R and I_z dr/dt = l_F F_F - l_R F_R as in :func:`corner`.
    The rear wheels' slip gives their force, the turning that of the front wheels, which
    stand at the angle at which they have it. No bend is tighter than the wheelbase.
    """
    if u.yaw_rate == 0.0 and max(abs(s.v_y), abs(s.r)) < STRAIGHT:
        go_straight(s, f)
        u.delta = 0.0
        u.sin_delta = 0.0
        u.cos_delta = 1.0
        return
    f.r = 0.5 * (s.r + no_tighter(c, u.yaw_rate, v))
    turning = c.I_z * 2.0 * (f.r - s.r) / (dt * c.l_F)  # N; what it takes in front
    u_R = s.v_y - c.l_R * f.r
    per_R = per_rolled(v, c.v_slip)
    alpha_R = axle_slip(u_R, per_R)
    both = c.l / c.l_F  # F_F + F_R over F_R, but for the turning
    F_R = -2.0 * tyre_force(alpha_R, c.C_R, c.D_R)
    K_R = 2.0 * tyre_stiffness(alpha_R, c.C_R, c.D_R)
    K_R *= slip_slope(u_R, v, per_R, 1.0, 0.0)
    dv_y = (both * F_R + turning) / (2.0 * c.m / dt + both * K_R)
    f.v_y = s.v_y + dv_y
    f.F_R = F_R - K_R * dv_y
    f.F_F = f.F_R * c.l_R / c.l_F + turning
    across = axle_slip(f.v_y + c.l_F * f.r, per_R)
    u.delta = across + slip_angle(0.5 * f.F_F, c.C_F, c.D_F)
    u.sin_delta = math.sin(u.delta)
    u.cos_delta = math.cos(u.delta)


@jit
def no_tighter(c, r, v):
    """Yaw rate [rad/s] of a bend no tighter than the wheelbase at v [m/s]."""
    return min(max(r, -v / c.l), v / c.l)


@jit
def steady_axle_forces(c, f, v, r, r_dot):
    """Axle forces [N] that carry a vehicle round at v [m/s], r [rad/s], r_dot.

    From m v r = F_F + F_R and I_z dr/dt = l_F F_F - l_R F_R at small steer; the
    sideslip is taken as settled.
    """
    a_y = v * r
    f.F_F = (c.m * a_y * c.l_R + c.I_z * r_dot) / c.l
    f.F_R = (c.m * a_y * c.l_F - c.I_z * r_dot) / c.l
    f.r = r
    f.v_y = 0.0
