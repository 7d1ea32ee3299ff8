"""The path: lanes changed by distance driven, followed by pure pursuit."""

import math

from rcc_sim.jit import jit

LOOK_WHEELBASES = 2.0  # 1; wheelbases that the follower looks ahead at a crawl
LOOK_TIMES = 1.0  # 1; characteristic times sqrt(m l / C_F) that it looks ahead besides


@jit
def lane_position(x, every, width, length):
    """Lateral place [m] of the path at x [m]: a lane change each `every` metres.

    From lane to lane and back, each change a quintic (no jerk at its ends) over
    `length` m, 10 q³ - 15 q⁴ + 6 q⁵.
    """
    if x < every:
        return 0.0
    k = math.floor(x / every)
    q = min((x - k * every) / length, 1.0)
    rise = q * q * q * (10.0 + q * (6.0 * q - 15.0))
    if k % 2.0 == 1.0:
        return width * rise
    return width * (1.0 - rise)


@jit
def lane_curvature(x, every, width, length):
    """Second derivative [1/m] of :func:`lane_position`: its curvature, nearly."""
    if x < every:
        return 0.0
    k = math.floor(x / every)
    q = (x - k * every) / length
    if q >= 1.0:
        return 0.0
    bend = width * 60.0 * q * (1.0 + q * (2.0 * q - 3.0)) / (length * length)
    if k % 2.0 == 1.0:
        return bend
    return -bend


@jit
def pursuit_steer(p, c, s):
    """Steering angle [rad] towards the point of the path ahead (pure pursuit).

    δ = atan(2 l sin η / L): the arc of a kinematic bicycle through that point, seen
    from the rear axle at angle η and distance L. R. C. Coulter, CMU-RI-TR-92-01.
    """
    look = LOOK_WHEELBASES * c.l + LOOK_TIMES * c.t_char * s.v_x
    x = s.x - c.l_R * math.cos(s.psi)
    y = s.y - c.l_R * math.sin(s.psi)
    target = lane_position(x + look, p.lanes.every, p.lanes.width, p.lanes.length)
    dy = target - y
    eta = math.atan2(dy, look) - s.psi
    L = math.sqrt(look * look + dy * dy)
    delta = math.atan(2.0 * c.l * math.sin(eta) / L)
    return min(max(delta, -p.control.delta_max), p.control.delta_max)
