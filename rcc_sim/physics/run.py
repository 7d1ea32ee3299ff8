"""The loops over time: a run that is commanded, and one that is imposed."""

import math

from rcc_sim.jit import jit
from rcc_sim.physics.book import book_state
from rcc_sim.physics.control import (
    driver,
    road_wheel_angle,
    speed_loop,
    split_force,
    throttle_force,
)
from rcc_sim.physics.effects.actuation_delay import command_of
from rcc_sim.physics.effects.motor_efficiency import ETA_MIN
from rcc_sim.physics.effects.motor_lag import mean_force
from rcc_sim.physics.effects.reference_delay import sent_at
from rcc_sim.physics.effects.reference_sampling import held_time
from rcc_sim.physics.effects.rotor_inertia import reflected_mass
from rcc_sim.physics.effects.steering_delay import delayed
from rcc_sim.physics.effects.steering_lag import lagged
from rcc_sim.physics.extra import EXTRA
from rcc_sim.physics.follower import lane_curvature, pursuit_steer
from rcc_sim.physics.params import FOLLOW, LOGGED, SPEED, THROTTLE, TORQUE
from rcc_sim.physics.powertrain import electrify, mapped_efficiency, motor_brakes
from rcc_sim.physics.step import (
    prepare,
    resist,
    step,
    step_imposed,
)
from rcc_sim.physics.tables import LINE, between, command_at, seek, slope_of

NEAR = 1e-3  # 1; share of a tick by which a row's time may fall short of it

STILL = 1e-6  # m/s; a car that yaws as it stops comes nearer and nearer to standing


@jit
def begin(p, c, s, u, v_0, r_0):
    """Set up the constants of a run, the wheels and the state at its first row."""
    prepare(p, c)
    u.cos_delta = 1.0
    s.v_x = v_0
    s.w = v_0
    s.r = r_0
    c.E_0 = 0.5 * (c.m * v_0 * v_0 + c.I_z * r_0 * r_0)
    c.E_rotor_0 = 0.5 * reflected_mass(c.J, c.n) * v_0 * v_0
    c.booked = 1.0


@jit
def open_window(flow):
    """Forget what has flowed: the means of the next row begin here."""
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
def write(c, s, u, E, flow, row):
    """Write one row: samples of the state, means of the flows since the last."""
    book_state(c, s, E)
    row.t = s.t
    row.v_ref = u.v_sent
    row.throttle = u.throttle
    row.steer = u.steer
    row.v = s.v_x
    row.w = s.w
    row.r = s.r
    row.x = s.x
    row.y = s.y
    row.psi = s.psi
    row.z = s.z
    row.slope = u.slope
    row.s = s.s
    row.E = flow.E
    if flow.dt > 0.0:
        per = 1.0 / flow.dt
        row.a_x = flow.a_x * per
        row.a_y = flow.a_y * per
        row.i_q = flow.i_q * per
        row.tau = flow.tau * per
        row.u = flow.u * per
        row.i = flow.i * per
        row.P = flow.P * per
        row.aux = flow.aux * per
    open_window(flow)


@jit
def look_up_reference(p, s, u, time, ref, how):
    """Read the speed reference that is sent at the state's time, and that is heard.

    ``how`` it runs between the entries of ``ref`` is told as in ``command_at``. Of what
    was sent a part of a tick ago, both ticks have their share, as with ``delayed``.
    """
    period, delay = p.reference_sampling.period_s, p.reference_delay.delay_s
    T = p.control.T_loop
    near = NEAR * T
    t_held = held_time(s.t, period)
    u.v_sent, s.ref_at = command_at(t_held, time, ref, s.ref_at, how, near)
    if delay <= 0.0:
        s.heard_at = s.ref_at
        u.v_ref = u.v_sent
        return
    ticks = sent_at(s.t, delay) / T
    whole = math.floor(ticks)
    t_held = held_time(whole * T, period)
    earlier, s.heard_at = command_at(t_held, time, ref, s.heard_at, how, near)
    t_held = held_time((whole + 1.0) * T, period)
    later, _ = command_at(t_held, time, ref, s.heard_at, how, near)
    u.v_ref = earlier + (later - earlier) * (ticks - whole)


@jit
def look_up_steer(s, u, steer):
    """Read the commanded steering angle at the state's time."""
    s.steer_at = seek(s.t, steer[0], s.steer_at)
    u.steer = between(s.t, steer[0], steer[1], int(s.steer_at))


@jit
def look_up_road(p, s, u, grade, aux, t, distance):
    """Read slope and wind at a distance [m], the logged auxiliary power at a time."""
    s.grade_at = seek(distance, grade[0], s.grade_at)
    u.slope = between(distance, grade[0], grade[1], int(s.grade_at))
    u.slope += p.road_grade.slope
    u.wind = p.headwind.speed_mps
    s.aux_at = seek(t, aux[0], s.aux_at)
    u.aux = between(t, aux[0], aux[1], int(s.aux_at))


@jit
def follow_reference(p, c, s, u, f, flow, ref):
    """Let a driver decide torque [N m] and brake for the tick: torque mode."""
    middle = sent_at(s.t, p.reference_delay.delay_s) + 0.5 * p.control.T_loop
    u.a_ref = slope_of(middle, ref[0], ref[1], s.heard_at)
    resist(p, c, u, f, s.v_x, s.w)
    R = f.ground
    tau_loss = f.visc + f.dry + f.iron
    if EXTRA:
        R += f.pull
        tau_loss += f.twist
    F = driver(p, c, s, u, flow, R)
    if s.v_x <= STILL and s.w <= STILL and F <= 0.0:
        u.brake = -F  # what stands the brakes hold: its motor gives nothing back
        return 0.0
    tau, u.brake = split_force(p, c, flow, F, c.n * s.w, tau_loss)
    return tau


@jit
def obey_throttle(p, c, s, u, force, throttle, late_motor, k):
    """Torque [N m] that the logged throttle of a while ago asks for.

    ``throttle`` holds times, values and how they run from one to the next.
    """
    time, values, how = throttle
    T = p.control.T_loop
    at, near = s.throttle_at, NEAR * T
    u.throttle, s.throttle_at = command_at(s.t, time, values, at, how, near)
    late = command_of(late_motor, k, p.actuation_delay.delay_s, T, u.throttle)
    return throttle_force(p, late, s.v_x, force) / c.n


@jit
def brake_the_rest(p, c, u, v):
    """Hand to friction brakes what the motor may not brake of a torque [N m].

    Of a throttle's its limit too; a speed loop's own limit leaves the vehicle to coast.
    """
    u.brake = 0.0
    low = motor_brakes(p, u.tau, v)
    if p.control.mode == THROTTLE:
        low = max(low, c.tau_min)
    if u.tau < low:
        u.brake = (low - u.tau) * c.n
        u.tau = low


@jit
def actuate(p, c, s, u, tau, steer):
    """Bring torque [N m] and steering command [rad] to the wheels, with their lags."""
    T = p.control.T_loop
    lag = p.motor_lag.time_constant_s
    u.tau = mean_force(s.tau, tau, c.force_share, lag, T)
    s.tau = lagged(s.tau, tau, c.force_share)
    if p.control.mode != TORQUE:  # there the driver has done so
        brake_the_rest(p, c, u, s.v_x)
    steer_wheels(p, c, s, u, steer)


@jit
def steer_wheels(p, c, s, u, command):
    """Turn the wheels as a steering command [rad] has it, for the tick."""
    delta = road_wheel_angle(p, c, s, command)
    if delta != u.delta:
        u.delta = delta
        u.sin_delta = math.sin(delta)
        u.cos_delta = math.cos(delta)


@jit
def run_commanded(P, work, drive, maps, lines, rows, sinks, every, substeps):
    """Drive the vehicle by its controller; one row each `every` ticks of the loop.

    P holds the parameters, work the other records (chassis, state, inputs, forces,
    flow), drive the tables of what is asked for (reference, steer and throttle over
    time, slope over distance, auxiliary power over time), maps the motor's efficiency
    and the force of the throttle, lines the ring buffers of the motor's and the
    steering's dead time; rows and sinks are filled, the first with the start.
    """
    p = P[0]
    c, s, u, f, flow = work[0][0], work[1][0], work[2][0], work[3][0], work[4][0]
    E = sinks[0]
    ref, steer, throttle, grade, aux = drive
    eta, force = maps
    late_motor, late_steer = lines
    T = p.control.T_loop
    dt = T / substeps
    eff = max(p.motor_efficiency.scale, ETA_MIN)
    varies = len(grade[0]) > 1 or len(aux[0]) > 1
    begin(p, c, s, u, ref[1][0], 0.0)
    look_up_reference(p, s, u, ref[0], ref[1], LINE)
    look_up_road(p, s, u, grade, aux, s.t, s.s)
    write(c, s, u, E, flow, rows[0])
    for k in range(1, len(rows)):
        sinks[k] = sinks[k - 1]
        E = sinks[k]
        for j in range(every):
            tick = (k - 1) * every + j
            s.t = tick * T
            look_up_reference(p, s, u, ref[0], ref[1], LINE)
            if varies:
                look_up_road(p, s, u, grade, aux, s.t, s.s)
            if p.control.mode == SPEED:
                tau = speed_loop(p, c, s, u, flow)
            elif p.control.mode == THROTTLE:
                asked = throttle[0], throttle[1], LINE
                tau = obey_throttle(p, c, s, u, force, asked, late_motor, tick)
            else:
                tau = follow_reference(p, c, s, u, f, flow, ref)
            if p.actuation_delay.delay_s > 0.0 and p.control.mode != THROTTLE:
                delay = p.actuation_delay.delay_s
                tau = command_of(late_motor, tick, delay, T, tau)
            if p.lanes.steer == LOGGED:
                look_up_steer(s, u, steer)
            elif p.lanes.steer == FOLLOW:
                u.steer = pursuit_steer(p, c, s)
            angle = u.steer
            if p.steering_delay.delay_s > 0.0:
                angle = delayed(late_steer, tick, p.steering_delay.delay_s, T, angle)
            actuate(p, c, s, u, tau, angle)
            for _ in range(substeps):
                step(p, c, s, u, f, E, flow, dt)
                if len(eta[0]) > 1:
                    eff = mapped_efficiency(p, c, u, f, flow, eta, dt)
                electrify(p, c, u, f, E, flow, eff, dt)
        s.t = k * every * T
        # what a row samples holds from its time on
        look_up_reference(p, s, u, ref[0], ref[1], LINE)
        write(c, s, u, E, flow, rows[k])


@jit
def run_imposed(P, work, drive, maps, rows, sinks):
    """Take speed (and yaw rate) as they are, row by row, and find what they cost.

    ``drive`` holds time, speed and yaw rate at the rows, then slope over distance and
    auxiliary power over time, each a pair of arrays. A yaw rate of a single entry, 0,
    means: that of the lanes in P, or none.
    """
    p = P[0]
    c, s, u, f, flow = work[0][0], work[1][0], work[2][0], work[3][0], work[4][0]
    E = sinks[0]
    time, speed, yaw_rate, grade, aux = drive
    eta = maps[0]
    eff = max(p.motor_efficiency.scale, ETA_MIN)
    varies = len(grade[0]) > 1 or len(aux[0]) > 1
    begin(p, c, s, u, speed[0], yaw_rate[0])
    look_up_road(p, s, u, grade, aux, time[0], 0.0)
    u.v_sent = speed[0]
    s.t = time[0]
    write(c, s, u, E, flow, rows[0])
    for k in range(1, len(rows)):
        sinks[k] = sinks[k - 1]
        E = sinks[k]
        dt = time[k] - time[k - 1]
        if varies:
            middle = s.s + 0.25 * (speed[k] + speed[k - 1]) * dt
            look_up_road(p, s, u, grade, aux, time[k] - 0.5 * dt, middle)
        r = 0.0
        if len(yaw_rate) > 1:
            r = yaw_rate[k]
        elif p.lanes.steer == FOLLOW:
            x = s.s + 0.5 * (speed[k] + speed[k - 1]) * dt
            bend = lane_curvature(x, p.lanes.every, p.lanes.width, p.lanes.length)
            r = speed[k] * bend
        step_imposed(p, c, s, u, f, E, flow, speed[k], r, dt)
        if len(eta[0]) > 1:
            eff = mapped_efficiency(p, c, u, f, flow, eta, dt)
        electrify(p, c, u, f, E, flow, eff, dt)
        s.t = time[k]
        u.v_sent = speed[k]
        write(c, s, u, E, flow, rows[k])
