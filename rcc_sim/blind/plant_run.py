"""A whole drive of the plant: clock, controller, steps, rows and books."""

import math
from math import inf

from rcc_sim.blind.plant import (
    CLOCK,
    CURRENT_LAG,
    GRAVITY,
    at,
    axles,
    extra_drag,
    rates,
)
from rcc_sim.blind.plant_commands import drive_command, speed_command
from rcc_sim.jit import jit


@jit
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
    i, tau, integral, i_wish, brake, held, next_hold = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    play, angle, since_brake = p.steer_offset, p.steer_offset, inf
    c_x, c_y, c_i, c_u, c_b, act = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    b_x, b_y, b_i, b_u, b_b, begun = 0.0, 0.0, 0.0, 0.0, 0.0, 0
    row, row_yaw, rows, step = 0, 0, len(d.rows), 0
    while row_yaw < rows and d.rows[row_yaw] <= late:
        row_yaw += 1
    for tick in range((len(d.ref) - 1) * per_clock):
        t = tick * T_tick
        k = tick // per_clock
        if t >= p.drop_t and m == p.m:
            m, I_z = p.m - p.drop_m, p.I_z * (p.m - p.drop_m) / p.m
        if p.speed_mode:
            if t >= next_hold - 1e-9:
                held = d.ref[k]
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
        whole = p.steer_gain * cmd + p.steer_offset
        goal = whole
        if cmd > 0.0:
            goal += (p.left_gain - 1.0) * p.steer_gain * cmd
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
        mu = p.mu
        if (s - p.patch_from) % p.patch_every < p.patch_long and s > p.patch_from:
            mu = min(p.patch_mu, mu)
        if p.stick_T > 0.0:
            since_brake += T_tick
            slowing = tau < -0.02 * p.stick_T and v > 5.0 * p.v_low
            coasting = p.speed_mode and held * p.n_file < 0.9 * w and wish <= 0.0
            if slowing or coasting or brake > 0.0:
                since_brake = 0.0
        T_more = extra_drag(p, v, angle, since_brake, t)
        P_aux = p.P_aux + d.aux[min(int(t), len(d.aux) - 1)]
        wind = p.wind + at(d.wind, t)
        if w > 0.0:
            act = max(act, T_more)
        if mu < p.mu and w > 0.0:
            f_1, g_1, _, _ = axles(p, m, p.mu, v, v_y, r, a_F, a_R, angle)
            f_2, g_2, _, _ = axles(p, m, mu, v, v_y, r, a_F, a_R, angle)
            act = max(act, abs(f_1 - f_2) + abs(g_1 - g_2))
        if t >= p.drop_t and w > 0.0:
            act = max(act, 1.0)
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
            i_q = tau / p.K_t
            P_shaft = tau * w_m
            lost = P_shaft / p.eta_motor - P_shaft
            if P_shaft < 0.0:
                lost = P_shaft * p.eta_motor - P_shaft
            copper = 1.5 * p.R_phase * i_q * i_q
            P = P_shaft + copper + lost + P_aux
            i_b = P / p.u_0
            if p.R_i > 0.0:
                left = max(p.u_0 * p.u_0 - 4.0 * p.R_i * P, 0.0)
                i_b = (p.u_0 - math.sqrt(left)) / (2.0 * p.R_i)
            u = p.u_0 - p.R_i * i_b
            c_x += dt * ((w - w0) / (p.n * dt) - v_y_m * r_m + GRAVITY * rise)
            if w0 > 0.0 or w > 0.0:
                c_y += dt * (f[5] * cos + f[6]) / m
            c_i += dt * i_q
            c_u += dt * u
            c_b += dt * i_b
            s += v * dt
            z += v * dt * rise
            v_air = v + wind
            roll = p.C_rr * m * GRAVITY * level
            across = v_y_m + p.l_F * r_m
            E[0] += dt * p.u_0 * i_b
            E[1] += dt * copper
            E[2] += dt * P_aux
            E[3] += dt * p.R_i * i_b * i_b
            E[4] += dt * lost
            if w > 0.0 or w0 > 0.0:
                E[5] += dt * p.visc * w_m * w_m
                E[6] += dt * p.dry * w_m
                E[7] += dt * (p.hysteresis + p.eddy * w_m) * w_m
                E[8] += dt * f[7] * w_m
                E[9] += dt * roll * v
                E[10] += dt * p.half_rho_A * v_air * abs(v_air) * v
                E[11] += dt * m * GRAVITY * rise * v
                E[12] += dt * brake * v
                E[13] -= dt * f[5] * (across * cos - v * sin)
                E[14] -= dt * f[6] * (v_y_m - p.l_R * r_m)
                E[15] -= dt * push * v
                E[16] += dt * T_more * w_m
            step += 1
            if row_yaw < rows and step == d.rows[row_yaw] - late:
                out[row_yaw, 1] = r
                row_yaw += 1
            if row < rows and step == d.rows[row]:
                span = (step - begun) * dt
                out[row, 0] = w / p.n_file
                out[row, 2] = (c_x - b_x) / span
                out[row, 3] = (c_y - b_y) / span
                out[row, 4] = (c_i - b_i) / span
                out[row, 5] = (c_u - b_u) / span
                out[row, 6] = (c_b - b_b) / span
                out[row, 7] = z
                out[row, 8] = s
                out[row, 9] = act
                act = 0.0
                row += 1
            if row < rows and step == d.rows[row] - window:
                b_x, b_y, b_i, b_u, b_b, begun = c_x, c_y, c_i, c_u, c_b, step
    v = w / p.n
    E[17] = 0.5 * m * (v * v + v_y * v_y) + 0.5 * I_z * r * r + 0.5 * p.J * w * w
    return s
