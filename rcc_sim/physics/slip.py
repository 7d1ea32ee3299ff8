"""Wheels with a speed of their own: what a step does where the driven tyres slip."""

import math

from rcc_sim.jit import jit
from rcc_sim.physics.effects.gear_loss import gear_transmission
from rcc_sim.physics.effects.longitudinal_slip import (
    LOCKED,
    imposed_slip,
    lock_loss,
    pushed,
    road_speed,
    slip_resistance,
    spun,
)
from rcc_sim.physics.effects.rotor_inertia import reflected_mass
from rcc_sim.physics.powertrain import least_torque, motor_brakes


@jit
def slide(p, c, s, f, E, v, T, R, dt):
    """Move wheels and vehicle apart under shaft torque T [N m], resistance R [N].

    Sets the acceleration, the wheels' speed at the end of the step and the load on the
    gears. Wheels that would stop or turn back, and a vehicle that comes to rest, are
    locked together first, and the step is then that of rolling wheels (f.slides = 0).
    """
    f.slides = 0.0
    M = reflected_mass(c.J, c.n)
    if s.v_x == 0.0 and f.a <= 0.0:
        E.longitudinal_slip += 0.5 * M * s.w * s.w  # the ground holds the vehicle
        s.w = 0.0
        return
    eta = p.gear_loss.efficiency
    K = slip_resistance(p.longitudinal_slip.stiffness_n, v, c.v_slip)
    push = c.n * T + M * R / c.m + M * (s.w - s.v_x) / dt
    k = gear_transmission(push, eta)
    F = pushed(k * push, K, M, k, c.m, dt)
    a = (F - R) / c.m
    v_1 = s.v_x + a * dt
    if v_1 <= 0.0 and s.v_x == 0.0:  # stands while its wheels take hold
        push = c.n * T + M * s.w / dt
        k = gear_transmission(push, eta)
        F = spun(k * push, K, M, k, dt)
        a = 0.0
        v_1 = 0.0
    w_1 = v_1 + F / K
    if w_1 <= 0.0 or (v_1 <= 0.0 and s.v_x > 0.0):
        lock(c, s, E, M)
        return
    f.slides = 1.0
    f.k = k
    f.a = a
    f.w_1 = w_1
    f.T_L = F / (k * c.n)


@jit
def lock(c, s, E, M):
    """Bring wheels and vehicle to one speed; their momentum stays, energy is lost."""
    slip = s.w - s.v_x
    E.longitudinal_slip += lock_loss(c.m, M, slip)
    s.v_x += M / (c.m + M) * slip
    s.w = s.v_x


@jit
def turn_wheels(p, c, s, f, F, v_1, dt):
    """Torque [N m] that the rotor takes where wheels push F [N] at an imposed speed.

    Sets the wheels' speed at the middle and the end of the step; the torque is that
    whose work is the change of the rotor's energy.
    """
    slip = imposed_slip(F, p.longitudinal_slip.stiffness_n)
    f.w = f.v * (1.0 + slip)
    f.w_1 = v_1 * (1.0 + slip)
    return 0.5 * c.J * c.n * (f.w_1 * f.w_1 - s.w * s.w) / (f.w * dt)


@jit
def behind_wheels(p, c, s, u, f, w_1, dt):
    """Road speed [m/s] at the end of a step, the wheels' being the logged one, w_1.

    What holds the vehicle and the shaft back is the last step's. The wheels push what
    the motor gives: F, or in braking the larger of what a share of it, and the motor's
    limit, leaves; the larger push belongs to the smaller road speed.
    """
    C = p.longitudinal_slip.stiffness_n
    R = f.k * c.n * f.T_L - u.brake - c.m * f.a
    v_1 = road_speed(w_1, s.v_x, c.m, dt, R, C)
    kn = gear_transmission(-1.0, p.gear_loss.efficiency) * c.n
    losses = f.visc + f.dry + f.iron
    share = -motor_brakes(p, -1.0, s.v_x)
    if share < 1.0:
        push = share * R - (1.0 - share) * kn * losses
        v_1 = min(v_1, road_speed(w_1, s.v_x, share * c.m, dt, push, C))
    least = kn * (least_torque(p, c, c.n * s.w) - losses)
    return min(v_1, w_1 / (1.0 + max(least / C, LOCKED)))


@jit
def count_slip(c, f, flow, v):
    """Keep the largest slip of the run, for the notes."""
    slip = abs(f.w - f.v) / math.sqrt(v * v + c.v_slip * c.v_slip)
    flow.slip = max(flow.slip, slip)
