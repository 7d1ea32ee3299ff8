"""The path: lanes changed by distance driven, and who keeps to it."""

import math

from rcc_sim.jit import jit

LOOK_WHEELBASES = 2.0  # 1; wheelbases that the follower looks ahead at a crawl
LOOK_TIMES = 4.0  # 1; characteristic times sqrt(m l / C_F) that it looks ahead besides
DRIFT_LOOKS = 4.0  # 1; distances of looking ahead over which a drift is learnt
MOST_DRIFT = 0.2  # rad; the most counter-steering that is learnt


@jit
def lane_phase(x, every, length):
    """How far [1] the lane change at x [m] has gone, and its direction, 1 or -1.

    One starts each `every` metres and takes `length`; to the left first, then back.
    """
    k = math.floor(x / every)
    if k < 1.0:
        return 0.0, 1.0
    return min((x - k * every) / length, 1.0), 2.0 * (k % 2.0) - 1.0


@jit
def lane_position(x, every, width, length):
    """Lateral place [m] of the path at x [m]: 10 q³ - 15 q⁴ + 6 q⁵ of the width.

    A quintic, without jerk at its ends.
    """
    q, way = lane_phase(x, every, length)
    rise = q * q * q * (10.0 + q * (6.0 * q - 15.0))
    if way > 0.0:
        return width * rise
    return width * (1.0 - rise)


@jit
def lane_slope(x, every, width, length):
    """First derivative [1] of :func:`lane_position`: nearly the path's heading."""
    q, way = lane_phase(x, every, length)
    return way * width * 30.0 * q * q * (1.0 - q) * (1.0 - q) / length


@jit
def lane_curvature(x, every, width, length):
    """Second derivative [1/m] of :func:`lane_position`: its curvature, nearly."""
    q, way = lane_phase(x, every, length)
    return way * width * 60.0 * q * (1.0 - q) * (1.0 - 2.0 * q) / (length * length)


@jit
def pursuit_steer(p, c, s):
    """Steering angle [rad] that keeps to the path: its curvature, and pure pursuit.

    (l + K v²) κ is what the path asks for in steady cornering, with the understeer
    gradient K = m/l (l_R/(2 C_F) - l_F/(2 C_R)); atan(2 l sin η / L) brings the rear
    axle back to the path's tangent, seen at angle η in the distance L ahead. What still
    drifts is learnt slowly and steered against, as a driver does. R. C.
    Coulter, CMU-RI-TR-92-01; T. D. Gillespie, 1992, ch. 6.
    """
    x = s.x - c.l_R * math.cos(s.psi)
    y = s.y - c.l_R * math.sin(s.psi)
    T = p.control.T_loop
    every = p.lanes.every
    width = p.lanes.width
    length = p.lanes.length
    look = LOOK_WHEELBASES * c.l + LOOK_TIMES * c.t_char * s.v_x
    y_path = lane_position(x, every, width, length)
    dy = y_path + look * lane_slope(x, every, width, length) - y
    course = s.psi + math.atan2(s.v_y - c.l_R * s.r, s.v_x + c.v_slip)
    eta = math.atan2(dy, look) - course
    L = math.sqrt(look * look + dy * dy)
    late = 0.5 * c.m * s.v_x / (c.C_F + c.C_R)
    K = c.m / c.l * (c.l_R / (2.0 * c.C_F) - c.l_F / (2.0 * c.C_R))
    kappa = lane_curvature(s.x + late * s.v_x, every, width, length)
    bend = (c.l + K * s.v_x * s.v_x) * kappa
    s.drift += 2.0 * c.l * (y_path - y) / (L * L) * s.v_x / (DRIFT_LOOKS * L) * T
    s.drift = min(max(s.drift, -MOST_DRIFT), MOST_DRIFT)
    delta = bend + math.atan(2.0 * c.l * math.sin(eta) / L) + s.drift
    return min(max(delta, -p.control.delta_max), p.control.delta_max)
