"""The loops over time: a run that is commanded, and one that is imposed."""

import math

from rcc_sim.jit import jit
from rcc_sim.physics.control import driver, speed_loop, split_force
from rcc_sim.physics.effects.reference_sampling import held_time
from rcc_sim.physics.follower import lane_curvature, pursuit_steer
from rcc_sim.physics.params import FOLLOW, LOGGED, SPEED
from rcc_sim.physics.step import book_state, prepare, resist, step, step_imposed


@jit
def seek(x, xs, at):
    """Last place in xs, from `at` on, whose entry is not above x."""
    i = int(at)
    while i + 2 < len(xs) and xs[i + 1] <= x:
        i += 1
    return i


@jit
def between(x, xs, ys, i):
    """Linear interpolation in the cell i of a table; its ends hold beyond it."""
    if len(xs) < 2 or x <= xs[0]:
        return ys[0]
    if x >= xs[-1]:
        return ys[-1]
    return ys[i] + (ys[i + 1] - ys[i]) * (x - xs[i]) / (xs[i + 1] - xs[i])


@jit
def begin(p, c, s, v_0, r_0):
    """Set up the constants of a run and the state at its first row."""
    prepare(p, c)
    s.v_x = v_0
    s.r = r_0
    c.E_0 = 0.5 * (c.m * v_0 * v_0 + c.I_z * r_0 * r_0)
    c.E_rotor_0 = 0.5 * c.J * c.n * c.n * v_0 * v_0


@jit
def write(c, s, u, E, flow, row):
    """Write one row: samples of the state, means of the flows since the last."""
    book_state(c, s, E)
    row.t = s.t
    row.v_ref = u.v_ref
    row.delta = u.delta
    row.v = s.v_x
    row.v_y = s.v_y
    row.r = s.r
    row.x = s.x
    row.y = s.y
    row.psi = s.psi
    row.z = s.z
    row.slope = u.slope
    row.s = s.s
    row.E = flow.E
    row.E_abs = flow.E_abs
    if flow.dt > 0.0:
        row.a_x = flow.a_x / flow.dt
        row.a_y = flow.a_y / flow.dt
        row.i_q = flow.i_q / flow.dt
        row.tau = flow.tau / flow.dt
        row.u = flow.u / flow.dt
        row.i = flow.i / flow.dt
        row.P = flow.P / flow.dt
        row.aux = flow.aux / flow.dt
    flow.dt = 0.0
    flow.a_x = 0.0
    flow.a_y = 0.0
    flow.i_q = 0.0
    flow.tau = 0.0
    flow.u = 0.0
    flow.i = 0.0
    flow.P = 0.0
    flow.aux = 0.0


@jit
def look_up(p, s, u, ref, steer, grade, aux):
    """Read reference, steer, slope and auxiliary power at the state's time and place.

    Each table is a pair of arrays (time or distance, value).
    """
    t_held = held_time(s.t, p.reference_sampling.period_s)
    s.ref_at = seek(t_held, ref[0], s.ref_at)
    i = int(s.ref_at)
    u.v_ref = between(t_held, ref[0], ref[1], i)
    if p.lanes.steer == LOGGED:
        s.steer_at = seek(s.t, steer[0], s.steer_at)
        u.delta = between(s.t, steer[0], steer[1], int(s.steer_at))
    s.grade_at = seek(s.s, grade[0], s.grade_at)
    u.slope = between(s.s, grade[0], grade[1], int(s.grade_at))
    u.slope += p.road_grade.slope
    s.aux_at = seek(s.t, aux[0], s.aux_at)
    u.aux = between(s.t, aux[0], aux[1], int(s.aux_at))


@jit
def slope_of(x, xs, ys, i):
    """Slope of a table at x, searched from cell i on; 0 beyond its ends."""
    if len(xs) < 2 or x < xs[0] or x >= xs[-1]:
        return 0.0
    k = seek(x, xs, i)
    return (ys[k + 1] - ys[k]) / (xs[k + 1] - xs[k])


@jit
def command(p, c, s, u, f, ref):
    """Let the controller decide torque, brake and steer for the next tick."""
    if p.control.mode == SPEED:
        u.tau = speed_loop(p, c, s, u)
    else:
        u.a_ref = slope_of(s.t + 0.5 * p.control.T_loop, ref[0], ref[1], s.ref_at)
        resist(p, c, u, f, s.v_x)
        F = driver(p, c, s, u, f.roll + f.aero + f.grade + f.road)
        u.tau, u.brake = split_force(p, c, F, c.n * s.v_x, f.visc + f.dry + f.iron)
    if p.lanes.steer == FOLLOW:
        u.delta = pursuit_steer(p, c, s)
    u.sin_delta = math.sin(u.delta)
    u.cos_delta = math.cos(u.delta)


@jit
def run_commanded(P, work, ref, steer, grade, aux, eta, rows, sinks, every, substeps):
    """Drive the vehicle by its controller; one row each `every` ticks of the loop.

    P holds the parameters, work the other records (chassis, state, inputs, forces,
    flow); rows and sinks are filled, the first with the state at the start.
    """
    p = P[0]
    c, s, u, f, flow = work[0][0], work[1][0], work[2][0], work[3][0], work[4][0]
    E = sinks[0]
    begin(p, c, s, ref[1][0], 0.0)
    T = p.control.T_loop
    dt = T / substeps
    look_up(p, s, u, ref, steer, grade, aux)
    write(c, s, u, E, flow, rows[0])
    for k in range(1, len(rows)):
        sinks[k] = sinks[k - 1]
        E = sinks[k]
        for j in range(every):
            s.t = ((k - 1) * every + j) * T
            look_up(p, s, u, ref, steer, grade, aux)
            command(p, c, s, u, f, ref)
            for _ in range(substeps):
                step(p, c, s, u, f, E, flow, eta, dt)
        s.t = k * every * T
        write(c, s, u, E, flow, rows[k])


@jit
def run_imposed(P, work, time, speed, yaw_rate, grade, aux, eta, rows, sinks):
    """Take speed (and yaw rate) as they are, row by row, and find what they cost.

    A yaw rate of a single entry, 0, means: that of the lanes in P, or none.
    """
    p = P[0]
    c, s, u, f, flow = work[0][0], work[1][0], work[2][0], work[3][0], work[4][0]
    E = sinks[0]
    begin(p, c, s, speed[0], yaw_rate[0])
    u.v_ref = speed[0]
    s.t = time[0]
    write(c, s, u, E, flow, rows[0])
    for k in range(1, len(rows)):
        sinks[k] = sinks[k - 1]
        E = sinks[k]
        dt = time[k] - time[k - 1]
        middle = s.s + 0.25 * (speed[k] + speed[k - 1]) * dt
        s.grade_at = seek(middle, grade[0], s.grade_at)
        u.slope = between(middle, grade[0], grade[1], int(s.grade_at))
        u.slope += p.road_grade.slope
        s.aux_at = seek(time[k] - 0.5 * dt, aux[0], s.aux_at)
        u.aux = between(time[k] - 0.5 * dt, aux[0], aux[1], int(s.aux_at))
        r = 0.0
        if len(yaw_rate) > 1:
            r = yaw_rate[k]
        elif p.lanes.steer == FOLLOW:
            x = s.s + 0.5 * (speed[k] + speed[k - 1]) * dt
            bend = lane_curvature(x, p.lanes.every, p.lanes.width, p.lanes.length)
            r = speed[k] * bend
        step_imposed(p, c, s, u, f, E, flow, eta, speed[k], r, dt)
        s.t = time[k]
        u.v_ref = speed[k]
        write(c, s, u, E, flow, rows[k])
