"""A whole drive of the plant: clock, controller, steps, rows and books."""

import math
from math import inf

import numpy as np

from rcc_sim.blind.plant import (
    CLOCK,
    CURRENT_LAG,
    GRAVITY,
    at,
    axles,
    extra_drag,
    grip_at,
    is_slowed,
    rates,
    steered,
)
from rcc_sim.blind.plant_books import book_electrics, book_motion, drawn
from rcc_sim.blind.plant_commands import drive_command, speed_command
from rcc_sim.jit import makes_arrays


@makes_arrays
def run(p, d, T_tick, subs, out, E, line):
    """Drive the vehicle p over the drive d; fill rows ``out`` and the books ``E``.

    ``T_tick`` is the controller's interval [s], ``subs`` the steps in it. ``line``
    is room for the commands that are under way. Rows hold speed and yaw rate as they
    are at the row, and means over the 10 ms before it of the other channels.
    """
    dt = T_tick / subs
    per_clock = round(CLOCK / T_tick)
    window = per_clock * subs
    late = round(p.yaw_late / dt)
    fade_i = 1.0 - math.exp(-dt / CURRENT_LAG)
    fade_tau = 1.0 if p.lag <= 0.0 else 1.0 - math.exp(-dt / p.lag)
    fade_steer = 1.0 if p.steer_lag <= 0.0 else 1.0 - math.exp(-T_tick / p.steer_lag)
    behind = round(p.delay / T_tick)
    m, I_z = p.m, p.I_z
    w, v_y, r, a_F, a_R, s, z = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    i, tau, integral, i_wish, brake, held = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    next_hold = p.ref_delay
    play, angle, since_brake = p.steer_offset, p.steer_offset, inf
    sums, before, begun, act = np.zeros(5), np.zeros(5), 0, 0.0
    row, row_yaw, rows, step = 0, 0, len(d.rows), 0
    while row_yaw < rows and d.rows[row_yaw] <= late:
        row_yaw += 1
    for tick in range((len(d.ref) - 1) * per_clock):
        t = tick * T_tick
        k = tick // per_clock
        if t >= p.drop_t and m == p.m:
            m, I_z = p.m - p.drop_m, p.I_z * (p.m - p.drop_m) / p.m
        # the motor's command, as the controller gives it and as it arrives
        if p.speed_mode:
            if t >= next_hold - 1e-9:
                held = d.ref[int((t - p.ref_delay) / CLOCK + 1e-6)]
                next_hold += p.hold
            line[tick % len(line)], integral = speed_command(
                p, held, w, integral, T_tick
            )
        elif tick % per_clock == 0:
            i_wish, brake, integral = drive_command(
                p, p.m, d.ref[k], d.ref[k + 1], w, integral
            )
        if not p.speed_mode:
            line[tick % len(line)] = i_wish
        wish = line[(tick - behind) % len(line)] if tick >= behind else 0.0
        # steering: lag(play(gain command + offset)), and what may be wrong with it
        cmd = at(d.steer, (t + 0.5 * T_tick - p.steer_delay) / CLOCK)
        whole, goal = steered(p, cmd)
        act = max(act, abs(goal - whole))
        if t % p.freeze_every < p.freeze_s and t > p.freeze_every:
            act = max(act, abs(goal - angle))
            goal = angle
            play = angle
        play = min(max(play, goal - 0.5 * p.play), goal + 0.5 * p.play)
        angle += (play - angle) * fade_steer
        # road: slope, roughness, patches
        v = w / p.n
        slope = p.slope + at(d.slope, s / d.slope_step)
        push = m * at(d.rough, t / CLOCK) * min(v / (10.0 * p.v_low), 1.0)
        wind = p.wind + at(d.wind, t)
        mu = grip_at(p, s)
        # what no library holds, and how much of it acts
        since_brake += T_tick
        if is_slowed(p, tau, v, w, held, wish, brake):
            since_brake = 0.0
        T_more = extra_drag(p, v, angle, since_brake, t)
        if w > 0.0:
            act = max(act, T_more)
        if mu < p.mu and w > 0.0:
            f_1, g_1, _, _ = axles(p, m, p.mu, v, v_y, r, a_F, a_R, angle)
            f_2, g_2, _, _ = axles(p, m, mu, v, v_y, r, a_F, a_R, angle)
            act = max(act, abs(f_1 - f_2) + abs(g_1 - g_2))
        if t >= p.drop_t and w > 0.0:
            act = max(act, 1.0)
        P_aux = p.P_aux + d.aux[min(int(t), len(d.aux) - 1)]
        level = 1.0 / math.sqrt(1.0 + slope * slope)
        rise = slope * level
        sin, cos = math.sin(angle), math.cos(angle)
        tilt = (angle, sin, cos, rise, level)
        pushed = push - brake
        for _ in range(subs):
            i += (wish - i) * fade_i
            tau += (p.K_t * i - tau) * fade_tau
            w0 = w
            f = rates(
                p, m, I_z, mu, w, v_y, r, a_F, a_R, tilt, tau, pushed, wind, T_more
            )
            w_m, v_y_m, r_m = w, v_y, r
            g_F, g_R = a_F, a_R
            if w > 0.0 or f[0] > 0.0:
                h = 0.5 * dt
                w_m = max(w + h * f[0], 0.0)
                v_y_m, r_m = v_y + h * f[1], r + h * f[2]
                g_F, g_R = a_F + h * f[3], a_R + h * f[4]
                f = rates(
                    p, m, I_z, mu, w_m, v_y_m, r_m, g_F, g_R, tilt, tau, pushed, wind,
                    T_more,
                )  # fmt: skip
                w += dt * f[0]
                v_y += dt * f[1]
                r += dt * f[2]
                a_F += dt * f[3]
                a_R += dt * f[4]
            if w <= 0.0:
                w, v_y, r, a_F, a_R = 0.0, 0.0, 0.0, 0.0, 0.0
            w_m = 0.5 * (w + w0)
            v = w_m / p.n
            i_q, i_b, u, copper, lost, over = drawn(p, tau, w_m, P_aux)
            act = max(act, over)
            sums[0] += dt * ((w - w0) / (p.n * dt) - v_y_m * r_m + GRAVITY * rise)
            if w0 > 0.0 or w > 0.0:
                sums[1] += dt * (f[5] * cos + f[6]) / m
            sums[2] += dt * i_q
            sums[3] += dt * u
            sums[4] += dt * i_b
            s += v * dt
            z += v * dt * rise
            book_electrics(p, E, dt, i_b, copper, lost, over, P_aux)
            if w > 0.0 or w0 > 0.0:
                book_motion(
                    p, E, dt, m, w_m, v_y_m, r_m, f, tilt, brake, push, wind, T_more
                )
            step += 1
            if row_yaw < rows and step == d.rows[row_yaw] - late:
                out[row_yaw, 1] = r
                row_yaw += 1
            if row < rows and step == d.rows[row]:
                out[row, 0] = w / p.n_file
                out[row, 2:7] = (sums - before) / ((step - begun) * dt)
                out[row, 7] = z
                out[row, 8] = s
                out[row, 9] = act
                act = 0.0
                row += 1
            if row < rows and step == d.rows[row] - window:
                before[:] = sums
                begun = step
    v = w / p.n
    E[17] = 0.5 * m * (v * v + v_y * v_y) + 0.5 * I_z * r * r + 0.5 * p.J * w * w
    return s
