"""Where the energy of a time step went: the work of every force and torque.

Every power is booked as the very force that moved the vehicle times the speed at
the middle of the step, (v0 + v1)/2, so that the work done is exactly the change of
kinetic energy, and the ledger closes to rounding without a line for the remainder.
"""

import math

from rcc_sim.jit import jit
from rcc_sim.physics.effects.rotor_inertia import reflected_mass
from rcc_sim.physics.effects.tyre_saturation import slip_angle
from rcc_sim.physics.extra import EXTRA, book_extra


@jit
def book_motion(c, u, f, E, dt):
    """Book the work of every force and torque on the moving vehicle."""
    ds = f.v * f.moving
    u_F = (f.v_y + c.l_F * f.r) * u.cos_delta * dt - u.sin_delta * ds
    E.tyre_slip_front -= f.F_F * u_F
    E.tyre_slip_rear -= f.F_R * (f.v_y - c.l_R * f.r) * dt
    book_shared(c, u, f, E, ds, f.w * f.moving)


@jit
def book_motion_imposed(c, u, f, E):
    """Book the same where speed and yaw rate are imposed."""
    E.tyre_slip_front += slip_loss(f.F_F, f.v, c.C_F, c.D_F) * f.moving
    E.tyre_slip_rear += slip_loss(f.F_R, f.v, c.C_R, c.D_R) * f.moving
    book_shared(c, u, f, E, f.v * f.moving, f.w * f.moving)


@jit
def slip_loss(F, v, C, D):
    """Power [W] that an axle's two tyres lose carrying F [N] at v [m/s]."""
    return F * v * math.tan(slip_angle(0.5 * F, C, D))


@jit
def book_shared(c, u, f, E, ds, dw):
    """Book road, air and brakes over the distance ds [m], shaft and gears over dw.

    dw [m] is the way of the wheels' rims: ds unless they slip.
    """
    E.rolling_resistance += f.roll * ds
    E.aerodynamic_drag += f.aero * ds
    E.road_grade += f.grade * ds
    E.road_load += f.road * ds
    E.steering_drag += f.scrub * ds
    E.brakes += u.brake * ds
    E.drivetrain_damping += f.visc * c.n * dw
    E.drivetrain_friction += f.dry * c.n * dw
    E.iron_loss += f.iron * c.n * dw
    E.gear_loss += (1.0 - f.k) * f.T_L * c.n * dw
    if c.slips > 0.0:
        E.longitudinal_slip += f.k * c.n * f.T_L * (dw - ds)
    if EXTRA:
        book_extra(c, f, E, ds, dw)


@jit
def book_state(c, s, E):
    """Book the kinetic energy, from the state alone and not from any force.

    This is what makes the ledger a check: the works above must add up to it.
    """
    v2 = s.v_x * s.v_x
    E.rotor_inertia = 0.5 * reflected_mass(c.J, c.n) * (s.w * s.w) - c.E_rotor_0
    E.kinetic = 0.5 * (c.m * (v2 + s.v_y * s.v_y) + c.I_z * s.r * s.r) - c.E_0
