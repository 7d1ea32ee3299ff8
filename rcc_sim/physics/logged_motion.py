"""The loop over the rows of a log whose measured motion drives the vehicle.

There is no controller, and so no tick that it keeps: the time between two rows is
parted into steps as long as they may be, the last of them those over which the row's
means are taken.
"""

import math

from rcc_sim.jit import jit
from rcc_sim.physics.effects.motor_efficiency import ETA_MIN
from rcc_sim.physics.logged_steering import enter_cell, steering_at
from rcc_sim.physics.params import TURNED
from rcc_sim.physics.powertrain import electrify, mapped_efficiency
from rcc_sim.physics.run import actuate, begin, open_window, write
from rcc_sim.physics.slip import behind_wheels
from rcc_sim.physics.step import pace, step_along
from rcc_sim.physics.tables import between, seek
from rcc_sim.physics.under_way import settle

NEAR = 1e-3  # 1; share of a step by which a span may be longer than whole steps


@jit
def steps_in(span, longest):
    """Count the equal steps into which a span [s] is parted, none longer than that."""
    return math.ceil(span / longest - NEAR)


@jit
def look_up_inputs(p, s, u, t, row, drive, road):
    """Read what acts in the middle of the step that begins at t [s].

    That is steering, late by its dead time, slope, auxiliary power and wind.
    """
    time, commands, held = drive
    grade, slope = road
    half = 0.5 * p.control.T_loop
    asked = t + half - p.steering_delay.delay_s
    s.steer_at = seek(asked, time, s.steer_at)
    if s.steer_at != u.cell:
        enter_cell(u, time, commands.steer, int(s.steer_at), held[1])
    u.steer = steering_at(u, asked)
    u.aux = between(t + half, time, commands.aux, row)
    u.wind = between(t + half, time, commands.wind, row) + p.headwind.speed_mps
    at = s.s + half * s.v_x
    s.grade_at = seek(at, grade, s.grade_at)
    u.slope = between(at, grade, slope, int(s.grade_at)) + p.road_grade.slope


@jit
def speed_between(speed, accel, k, part, span):
    """Speed [m/s] a part of the way from row k to the next, span [s] apart.

    The acceleration runs straight from row to row; what is then missing to the next
    row's speed is added evenly.
    """
    a_0 = accel[k]
    a_1 = accel[k + 1]
    missing = speed[k + 1] - speed[k] - 0.5 * (a_0 + a_1) * span
    bent = (a_0 + 0.5 * (a_1 - a_0) * part) * part * span
    return speed[k] + bent + part * missing


@jit
def run_with_logged_motion(
    P, work, drive, road, measured, maps, rows, sinks, window, longest
):
    """Run the vehicle at the speeds of a log, one row each row of the log.

    P holds the parameters, work the other records, drive the rows' times, what was
    commanded at them, and whether reference and steering hold between them, road the
    slope over distance, measured the speed without gaps; maps as in ``run_commanded``.
    Where a torque was measured the power is of that, not of the one that the motion
    takes. Means are over ``window`` [s] before each row; no step is longer than
    ``longest`` [s].
    """
    p = P[0]
    c, s, u, f, flow = work[0][0], work[1][0], work[2][0], work[3][0], work[4][0]
    E = sinks[0]
    time, commands, held = drive
    speed, torque = measured.speed, measured.torque
    yaw_rate, accel = measured.yaw_rate, measured.accel
    eta = maps[0]
    eff = max(p.motor_efficiency.scale, ETA_MIN)
    begin(p, c, s, u, max(speed[0], 0.0), 0.0)
    settle(p, c, s, u, f, commands.steer[0], yaw_rate[0])
    c.booked = 0.0
    enter_cell(u, time, commands.steer, 0, held[1])
    look_up_inputs(p, s, u, time[0], 0, drive, road)
    u.steer = commands.steer[0]
    write(c, s, u, E, flow, rows[0])
    for k in range(1, len(rows)):
        rows[k] = rows[k - 1]
        before = k - 1
        span = time[k] - time[before]
        last = min(window, span)  # of the row's means
        first = steps_in(span - last, longest)
        begun = time[before]
        for part in range(2):
            n, length = first, span - last
            if part == 1:
                n, length = max(steps_in(last, longest), 1), last
                open_window(flow)
            dt = length / max(n, 1)
            if n > 0 and dt != p.control.T_loop:
                pace(p, c, dt)
            for i in range(n):
                s.t = begun + i * dt
                look_up_inputs(p, s, u, s.t, before, drive, road)
                actuate(p, c, s, u, 0.0, u.steer)
                way = min((begun + (i + 1) * dt - time[before]) / span, 1.0)
                v_1 = max(speed_between(speed, accel, before, way, span), 0.0)
                if c.slips > 0.0:
                    v_1 = behind_wheels(p, c, s, u, f, v_1, dt)
                if p.lanes.steer == TURNED:
                    u.yaw_rate = yaw_rate[before]
                    u.yaw_rate += way * (yaw_rate[k] - yaw_rate[before])
                step_along(p, c, s, u, f, flow, v_1, dt)
                asked = u.tau
                if torque[k] == torque[k]:
                    u.tau = torque[k]
                if len(eta[0]) > 1:
                    eff = mapped_efficiency(p, c, u, f, flow, eta, dt)
                electrify(p, c, u, f, E, flow, eff, dt)
                if u.tau != asked:
                    flow.tau += (asked - u.tau) * dt
                    if c.K_t > 0.0:
                        flow.i_q += (asked - u.tau) / c.K_t * dt
            begun += length
        s.t = time[k]
        write(c, s, u, E, flow, rows[k])
        rows[k].v = speed[k]
