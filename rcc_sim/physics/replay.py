"""The loop over the rows of a log: the vehicle driven by what was commanded to it.

Between two rows the vehicle runs as in any other drive. At each row its state may
be drawn towards what was measured, so that a rough road, which no model knows, does
not add up; what the measurement then adds at each row is the innovation.
"""

import math

from rcc_sim.jit import jit
from rcc_sim.physics.control import most_current, speed_loop
from rcc_sim.physics.effects.actuation_delay import command_of
from rcc_sim.physics.effects.motor_efficiency import ETA_MIN
from rcc_sim.physics.effects.speed_dead_zone import commands_nothing
from rcc_sim.physics.effects.steering_delay import delayed
from rcc_sim.physics.logged_steering import enter_cell, steering_at
from rcc_sim.physics.params import SPEED, TURNED
from rcc_sim.physics.powertrain import electrify, mapped_efficiency
from rcc_sim.physics.run import (
    NEAR,
    actuate,
    begin,
    look_up_reference,
    obey_throttle,
    open_window,
    write,
)
from rcc_sim.physics.step import step
from rcc_sim.physics.tables import between, seek
from rcc_sim.physics.under_way import settle

FREE = 0.98  # 1; share of the currents between the limits in which the loop is free

ROWS = 4.0  # 1; rows that a speed takes at least to come to what was measured


@jit
def weigh(flow, share):
    """Count what has flowed since the window opened by a share of itself."""
    flow.dt *= share
    flow.a_x *= share
    flow.a_y *= share
    flow.i_q *= share
    flow.tau *= share
    flow.u *= share
    flow.i *= share
    flow.P *= share
    flow.aux *= share


@jit
def look_up_inputs(p, s, u, rows_at, drive, road):
    """Read what acts at the time: reference, steering, slope, auxiliary power, wind."""
    time, commands, held = drive
    grade, slope = road
    t = s.t
    look_up_reference(p, s, u, time, commands.ref, held[0])
    half = 0.5 * p.control.T_loop
    u.steer = steering_at(u, t + half)
    u.aux = between(t, time, commands.aux, rows_at)
    u.wind = between(t, time, commands.wind, rows_at) + p.headwind.speed_mps
    s.grade_at = seek(s.s, grade, s.grade_at)
    u.slope = between(s.s, grade, slope, int(s.grade_at)) + p.road_grade.slope


@jit
def freedom(p, c, u, omega, row):
    """Return how free the speed loop is to hold the speed: 1, or 0 at a limit.

    At omega [rad/s] of the motor.
    """
    omega_ref = u.v_ref * c.n_file
    if omega_ref == 0.0:
        return 0.0
    if commands_nothing(omega_ref, p.speed_dead_zone.threshold_radps):
        return 0.0
    low = c.i_min
    high, _ = most_current(p, c, omega)
    near = (1.0 - FREE) * (high - low)
    if near <= 0.0:
        return 0.0
    return min(max(min(row.i_q - low, high - row.i_q) / near, 0.0), 1.0)


@jit
def recall(p, c, s, u, row, w, v, i_q, span, recall_v, recall_i, hold):
    """Draw speed, and the loop's integral, towards what was measured at a row.

    v [m/s], beside the model's w when it was so, and i_q [A] are NaN where they were
    not measured. The integral is drawn only while the loop is free, that is at none of
    its limits. Where it is not, the speed is drawn at a rate ``hold`` [1/s] besides, as
    the loop would hold it: a rough road then moves it as far. That is not within a few
    ``ROWS``, where it would follow their noise.
    """
    free, rate = 0.0, 1.0 / recall_v
    if p.control.mode == SPEED:
        free = freedom(p, c, u, c.n * s.w, row)
        if rate > 0.0:
            held = rate + hold * (1.0 - free)
            rate = max(rate, min(held, 1.0 / (ROWS * span)))
    if v == v:
        share = 1.0 - math.exp(-span * rate)
        s.v_x = max(s.v_x + share * (v - w), 0.0)
        s.w = max(s.w + share * (v - w), 0.0)
    if free > 0.0 and i_q == i_q:
        share = 1.0 - math.exp(-span / recall_i)
        s.integral += share * free * (i_q - row.i_q)


@jit
def run_replayed(
    P, work, drive, road, measured, maps, lines, rows, sinks, windows, recalls
):
    """Run the vehicle along a log, one row each row of the log.

    P holds the parameters, work the other records, drive the rows' times, what was
    commanded at them, and whether reference and steering hold between them, road the
    slope over distance, maps and lines as in ``run_commanded``. Means are over
    ``windows`` [s] before each row, of flows and of accelerations, which are no longer
    than those. ``recalls`` holds the times [s] in which state and measurement come
    together (speed, integral; infinite: never), the rate [1/s] at which the speed does
    besides, where no loop holds it, and how long before each row the speed was what it
    then holds.
    """
    p = P[0]
    c, s, u, f, flow = work[0][0], work[1][0], work[2][0], work[3][0], work[4][0]
    E = sinks[0]
    time, commands, held = drive
    speed, current = measured.speed, measured.current
    eta, force = maps
    late_motor, late_steer = lines
    recall_v, recall_i, hold, ago = recalls
    window, felt = windows
    T = p.control.T_loop
    eff = max(p.motor_efficiency.scale, ETA_MIN)
    r_0 = 0.0
    w_0 = 0.0
    first = speed[0]
    if first != first:
        first = 0.0
    begin(p, c, s, u, max(first, 0.0), 0.0)
    late_steer[:] = commands.steer[0]
    settle(p, c, s, u, f, commands.steer[0], measured.yaw_rate[0])
    c.booked = 0.0
    enter_cell(u, time, commands.steer, 0, held[1])
    s.t = time[0]
    look_up_inputs(p, s, u, 0, drive, road)
    write(c, s, u, E, flow, rows[0])
    tick = math.floor(time[0] / T + NEAR)
    for k in range(1, len(rows)):
        rows[k] = rows[k - 1]
        t_end = time[k]
        ends = t_end / T
        last = math.floor(ends + NEAR)
        more = 1.0 + max(ends - last, 0.0)  # the tick under way, like the one before
        opened = max(ends - window / T, float(tick))
        opens = min(math.floor(opened + NEAR), max(last - 1, tick))
        before = k - 1
        opened_felt = max(ends - felt / T, opened)
        feels = min(math.floor(opened_felt + NEAR), max(last - 1, tick))
        felt_t, felt_x, felt_y = 0.0, 0.0, 0.0
        w_was = s.w
        span = time[k] - time[before]
        enter_cell(u, time, commands.steer, before, held[1])
        while tick < last:
            if tick == opens:
                open_window(flow)
            if tick == feels:
                felt_t, felt_x, felt_y = flow.dt, flow.a_x, flow.a_y
            if tick == last - 1 and tick != opens:
                weigh(flow, 1.0 / more)
            s.t = max(tick * T, time[0])
            look_up_inputs(p, s, u, before, drive, road)
            angle = u.steer
            r_0 = s.r
            w_0 = s.w
            if p.steering_delay.delay_s > 0.0:
                angle = delayed(late_steer, tick, p.steering_delay.delay_s, T, angle)
            if p.control.mode == SPEED:
                tau = speed_loop(p, c, s, u, flow)
                delay = p.actuation_delay.delay_s
                if delay > 0.0:
                    tau = command_of(late_motor, tick, delay, T, tau)
            else:
                asked = time, commands.throttle, held[0]
                tau = obey_throttle(p, c, s, u, force, asked, late_motor, tick)
            actuate(p, c, s, u, tau, angle)
            if p.lanes.steer == TURNED:
                u.yaw_rate = between(s.t + T, time, measured.yaw_rate, before)
            step(p, c, s, u, f, E, flow, T)
            if len(eta[0]) > 1:
                eff = mapped_efficiency(p, c, u, f, flow, eta, T)
            electrify(p, c, u, f, E, flow, eff, T)
            if tick == opens:
                weigh(flow, min(opens + 1.0 - opened, 1.0))
            if tick == last - 1:
                weigh(flow, more)
            tick += 1
        s.t = t_end
        if flow.dt > 0.0:
            felt_t = flow.dt - felt_t
            felt_x, felt_y = flow.a_x - felt_x, flow.a_y - felt_y
            write(c, s, u, E, flow, rows[k])
            rows[k].a_x, rows[k].a_y = felt_x / felt_t, felt_y / felt_t
        rows[k].t = t_end
        rows[k].r = s.r + (s.r - r_0) * (ends - tick)
        rows[k].psi = s.psi + s.r * (ends - tick) * T
        rows[k].w = max(s.w + (s.w - w_0) * (ends - tick), 0.0)
        rows[k].v = max(s.v_x + s.a_x * (ends - tick) * T, 0.0)
        back = min(ago[k] / span, 1.0)
        recall(
            p, c, s, u, rows[k], rows[k].w + back * (w_was - rows[k].w),
            speed[k], current[k], span, recall_v, recall_i, hold,
        )  # fmt: skip
