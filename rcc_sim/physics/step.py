"""One time step: forces and motion. Reads as the model is described."""

import math

from rcc_sim.jit import jit
from rcc_sim.physics.bicycle import (
    axle_slip,
    carry_round,
    corner,
    no_tighter,
    per_rolled,
    steady_axle_forces,
    turn_velocity,
)
from rcc_sim.physics.book import book_motion, book_motion_imposed, slip_loss
from rcc_sim.physics.effects.aerodynamic_drag import drag_force
from rcc_sim.physics.effects.cg_shift import shifted_axles
from rcc_sim.physics.effects.drivetrain_damping import damping_torque
from rcc_sim.physics.effects.drivetrain_friction import friction_torque
from rcc_sim.physics.effects.front_cornering_stiffness import front_stiffness
from rcc_sim.physics.effects.gear_loss import gear_transmission
from rcc_sim.physics.effects.headwind import air_speed
from rcc_sim.physics.effects.iron_loss import iron_torque
from rcc_sim.physics.effects.longitudinal_slip import slips
from rcc_sim.physics.effects.payload import loaded
from rcc_sim.physics.effects.rear_cornering_stiffness import rear_stiffness
from rcc_sim.physics.effects.regeneration_limit import braking_limit
from rcc_sim.physics.effects.road_grade import climbed, grade_force, wheel_load
from rcc_sim.physics.effects.road_load import road_load_force
from rcc_sim.physics.effects.rolling_resistance import rolling_force
from rcc_sim.physics.effects.rotor_inertia import reflected_mass
from rcc_sim.physics.effects.steering_drag import scrub_force
from rcc_sim.physics.effects.steering_lag import caught_up
from rcc_sim.physics.effects.wheel_radius import true_radius
from rcc_sim.physics.effects.yaw_inertia import true_yaw_inertia
from rcc_sim.physics.extra import EXTRA, act
from rcc_sim.physics.params import TURNED
from rcc_sim.physics.powertrain import least_torque, motor_brakes, torque_envelope
from rcc_sim.physics.slip import count_slip, slide, turn_wheels
from rcc_sim.units import G

PASSES = 3  # 1; how often slip and load of imposed driving wheels are set to each other
SLIP_BLEND = 0.02  # 1; tyre slip fades out below this times sqrt(C_F l / m)


@jit
def prepare(p, c):
    """Work out the constants of a run from its parameters."""
    m = p.body.m
    c.m = loaded(m, m, p.payload.mass_kg)
    I_z = true_yaw_inertia(p.body.I_z, p.yaw_inertia.scale)
    c.I_z = loaded(I_z, m, p.payload.mass_kg)
    c.l_F, c.l_R = shifted_axles(p.body.l_F, p.body.l_R, p.cg_shift.shift_m)
    c.l = c.l_F + c.l_R
    c.C_F = front_stiffness(p.tyre.C_F, p.front_cornering_stiffness.scale)
    c.C_R = rear_stiffness(p.tyre.C_R, p.rear_cornering_stiffness.scale)
    mu = p.tyre_saturation.friction_coefficient
    c.D_F = mu * c.m * G * c.l_R / (2.0 * c.l)
    c.D_R = mu * c.m * G * c.l_F / (2.0 * c.l)
    c.sigma = p.tyre_relaxation.length_m
    c.n_file = p.drive.N_d / p.tyre.r_w
    c.n = p.drive.N_d / true_radius(p.tyre.r_w, p.wheel_radius.scale)
    c.J = p.rotor_inertia.inertia_kgm2
    c.slips = slips(p.longitudinal_slip.stiffness_n)
    c.m_spin = c.m
    if c.slips == 0.0:
        c.m_spin = c.m + reflected_mass(c.J, c.n)
    c.spin = math.sqrt(c.m_spin / c.m)
    c.per_m = 1.0 / c.m
    c.per_spin = 1.0 / c.spin
    c.rotor_share = 1.0 - c.m / c.m_spin
    c.K_t = p.motor.K_t
    c.i_max = p.control.i_max
    c.tau_min = -braking_limit(
        p.regeneration_limit.max_current_a, p.regeneration_limit.max_torque_nm, c.K_t
    )
    c.i_min = -c.i_max
    if c.K_t > 0.0:
        c.i_min = max(c.i_min, c.tau_min / c.K_t)
    u_0 = p.battery.u_0
    c.per_P_max = 4.0 * p.battery_resistance.resistance_ohm / (u_0 * u_0)
    c.v_slip = SLIP_BLEND * math.sqrt(c.C_F * c.l / c.m)
    c.t_char = math.sqrt(c.m * c.l / c.C_F)
    pace(p, c, p.control.T_loop)


@jit
def pace(p, c, dt):
    """Let a tick of the loop last dt [s] from here on."""
    p.control.T_loop = dt
    c.force_share = caught_up(dt, p.motor_lag.time_constant_s)
    c.steer_share = caught_up(dt, p.steering_lag.time_constant_s)


@jit
def resist(p, c, u, f, v, w):
    """Everything that holds the vehicle back at v [m/s]: road, air, shaft.

    f.ground [N] is what road and air come to together.
    w [m/s] is the speed of the driven wheels' rims, v where they do not slip.
    Dry friction, rolling resistance and the constant part of a road load are the
    most that they can be: a vehicle at rest moves only if it is pushed by more.
    """
    v_air = air_speed(v, u.wind)
    drag = p.aerodynamic_drag
    road = p.road_load
    f.roll = rolling_force(wheel_load(c.m, u.slope), p.rolling_resistance.coefficient)
    f.aero = drag_force(v_air, drag.drag_area_m2, drag.air_density_kg_per_m3)
    f.grade = grade_force(c.m, u.slope)
    f.road = road_load_force(v, v_air, road.a_n, road.b_n_s_per_m, road.c_n_s2_per_m2)
    f.scrub = scrub_force(u.delta, p.steering_drag.force_n_per_rad)
    f.ground = f.roll + f.aero + f.grade + f.road + f.scrub
    resist_turning(p, f, c.n * w)


@jit
def resist_turning(p, f, omega):
    """Torques that hold the motor's shaft back at omega [rad/s]."""
    iron = p.iron_loss
    f.visc = damping_torque(omega, p.drivetrain_damping.damping_nms_per_rad)
    f.dry = friction_torque(p.drivetrain_friction.torque_nm)
    f.iron = iron_torque(omega, iron.hysteresis_torque_nm, iron.eddy_nms_per_rad)


@jit
def accelerate(p, c, u, f):
    """Acceleration [m/s²] from m a = k n T_L - R with T_L = tau - losses - J n a.

    Returns T = tau - losses [N m] and R [N].
    k is the transmission of the gears, n = N_d / r_w; the sign of T_L, which decides
    k, is that of m T + J n R whichever way k falls.
    """
    R = f.ground + u.brake + f.F_F * u.sin_delta
    T = u.tau - f.visc - f.dry - f.iron
    if EXTRA:
        R += f.pull
        T -= f.twist
    f.k = gear_transmission(c.m * T + c.J * c.n * R, p.gear_loss.efficiency)
    f.a = (f.k * c.n * T - R) / (c.m + f.k * reflected_mass(c.J, c.n))
    f.T_L = T - c.J * c.n * f.a
    return T, R


@jit
def turn(p, c, s, u, f, v, dt):
    """Turn as the steering has it, or as a gyro shows where no steering is known."""
    if p.lanes.steer == TURNED:
        carry_round(c, s, u, f, v, dt)
    else:
        corner(c, s, u, f, v, dt)


@jit
def step(p, c, s, u, f, E, flow, dt):
    """Advance the vehicle by dt [s] under the inputs u; book where the energy went."""
    turn_velocity(c, s, 0.5 * dt)
    v = max(s.v_x + 0.5 * dt * s.a_x, 0.0)
    w = v
    if c.slips > 0.0:
        w = max(v + s.w - s.v_x, 0.0)
    resist(p, c, u, f, v, w)
    if EXTRA:
        act(p, c, s, u, f, v, w, s.a_x)
    turn(p, c, s, u, f, v, dt)
    T, R = accelerate(p, c, u, f)
    if c.slips > 0.0:
        slide(p, c, s, f, E, v, T, R, dt)
    v_1 = s.v_x + f.a * dt
    a_mean = f.a
    f.moving = dt  # how much of the step the wheels turn
    if (
        v_1 <= 0.0 and f.slides == 0.0
    ):  # comes to rest, or is held at rest, within the step
        f.moving = 0.0
        if f.a < 0.0:
            f.moving = min(-s.v_x / f.a, dt)
        v_1 = 0.0
        a_mean = -s.v_x / dt
    f.v = 0.5 * (s.v_x + v_1)
    f.w = f.v
    if f.slides > 0.0:
        f.w = 0.5 * (s.w + f.w_1)
        count_slip(c, f, flow, v)
    if c.booked > 0.0:
        book_motion(c, u, f, E, dt)
        advance_place(s, f, dt)
    turning = -c.rotor_share * s.v_y * f.r
    flow.a_x += (a_mean + turning + f.grade * c.per_m) * dt
    flow.a_y += (f.F_F * u.cos_delta + f.F_R) * c.per_m * dt
    s.a_x = a_mean
    s.v_x = v_1
    s.v_y = 2.0 * f.v_y - s.v_y
    s.psi += dt * f.r
    s.r = 2.0 * f.r - s.r
    s.s += f.v * f.moving
    s.z += climbed(f.v * f.moving, u.slope)
    s.w = v_1
    if f.slides > 0.0:
        s.w = f.w_1
    turn_velocity(c, s, 0.5 * dt)
    if c.slips == 0.0:
        s.w = s.v_x


@jit
def advance_place(s, f, dt):
    """Move the place by the velocity at the middle of the step."""
    psi = s.psi + 0.5 * dt * f.r
    if psi == 0.0 and f.v_y == 0.0:
        s.x += f.v * f.moving
    else:
        cos = math.cos(psi)
        sin = math.sin(psi)
        s.x += f.v * cos * f.moving - f.v_y * sin * dt
        s.y += f.v * sin * f.moving + f.v_y * cos * dt


@jit
def step_imposed(p, c, s, u, f, E, flow, v_1, r_1, dt):
    """Advance by dt [s] to the speed and yaw rate that were measured.

    The torque that this takes is worked out backwards; what the motor may not
    brake, the friction brakes do; what it could not give is counted, not cut. Its
    wheels are turned by as much as the bend asks of wheels that do not slip. No bend is
    tighter than the wheelbase: what a gyro reads beyond is its noise at a standstill.
    """
    r_1 = no_tighter(c, r_1, v_1)
    f.v = 0.5 * (s.v_x + v_1)
    f.a = (v_1 - s.v_x) / dt
    f.moving = dt
    if f.v <= 0.0:
        f.moving = 0.0
    f.w = f.v
    f.w_1 = v_1
    if EXTRA or p.steering_drag.force_n_per_rad > 0.0:
        per_v = per_rolled(f.v, c.v_slip)
        u.delta = axle_slip(0.5 * c.l * (s.r + r_1), per_v)
    resist(p, c, u, f, f.v, f.v)
    if EXTRA:
        act(p, c, s, u, f, f.v, f.v, f.a)
    steady_axle_forces(c, f, f.v, 0.5 * (s.r + r_1), (r_1 - s.r) / dt)
    P_slip = slip_loss(f.F_F, f.v, c.C_F, c.D_F) + slip_loss(f.F_R, f.v, c.C_R, c.D_R)
    if f.moving > 0.0:
        turning = (P_slip + c.I_z * (r_1 - s.r) / dt * f.r) / f.v
        supply(p, c, s, u, f, flow, turning, v_1, dt)
    else:
        rest(u, f)
    if c.booked > 0.0:
        book_motion_imposed(c, u, f, E)
        advance_place(s, f, dt)
    flow.a_x += (f.a + f.grade * c.per_m) * dt
    flow.a_y += f.v * f.r * dt
    s.v_x = v_1
    s.w = f.w_1
    s.s += f.v * dt
    s.z += climbed(f.v * dt, u.slope)
    s.psi += f.r * dt
    s.r = r_1


@jit
def step_along(p, c, s, u, f, flow, v_1, dt):
    """Advance by dt [s] to a speed that was measured, turning freely.

    As the steering has it, or as the gyro shows where no steering is known.
    Nothing is booked: no ledger is asked of a run along a log.
    """
    s.v_y -= 0.5 * dt * s.v_x * s.r  # as the body's axes turn, half before the forces
    f.v = 0.5 * (s.v_x + v_1)
    f.a = (v_1 - s.v_x) / dt
    f.moving = dt
    if f.v <= 0.0:
        f.moving = 0.0
    f.w = f.v
    f.w_1 = v_1
    resist(p, c, u, f, f.v, f.v)
    if EXTRA:
        act(p, c, s, u, f, f.v, f.v, f.a)
    turn(p, c, s, u, f, f.v, dt)
    turning = -c.m * f.v_y * f.r
    if f.moving > 0.0:
        supply(p, c, s, u, f, flow, turning + f.F_F * u.sin_delta, v_1, dt)
    else:
        rest(u, f)
    flow.a_x += (f.a + (turning + f.grade) * c.per_m) * dt
    flow.a_y += (f.F_F * u.cos_delta + f.F_R) * c.per_m * dt
    s.v_y = 2.0 * f.v_y - s.v_y
    s.psi += f.r * dt
    s.r = 2.0 * f.r - s.r
    s.s += f.v * f.moving
    s.v_x = v_1
    s.v_y -= 0.5 * dt * s.v_x * s.r
    s.w = f.w_1


@jit
def rest(u, f):
    """Ask nothing of a vehicle that stands."""
    u.tau = 0.0
    u.brake = 0.0
    f.T_L = 0.0
    f.k = 1.0


@jit
def supply(p, c, s, u, f, flow, turning, v_1, dt):
    """Torque and brake force that give the imposed acceleration, losses included.

    ``turning`` [N] is the force along the vehicle that its turning takes.
    """
    F = c.m * f.a + f.ground + turning
    losses = f.visc + f.dry + f.iron + c.J * c.n * f.a
    if EXTRA:
        F += f.pull
        losses += f.twist
    high = deliver(p, c, u, f, F, losses)
    if c.slips > 0.0:
        push = f.k * c.n * f.T_L
        stiff = v_1 * f.k * c.n * c.n * c.J / (p.longitudinal_slip.stiffness_n * dt)
        for _ in range(PASSES):
            spin = turn_wheels(p, c, s, f, push, v_1, dt)
            resist_turning(p, f, c.n * f.w)
            losses = f.visc + f.dry + f.iron + spin
            if EXTRA:
                losses += f.twist
            high = deliver(p, c, u, f, F, losses)
            more = f.k * c.n * f.T_L - push
            if u.brake > 0.0:  # what the rotor takes is then less for the wheels
                more /= 1.0 + stiff
            push += more
    if u.tau > high:
        flow.short += dt
        flow.tau_over = max(flow.tau_over, u.tau / high)
    if c.slips > 0.0:
        count_slip(c, f, flow, f.v)


@jit
def deliver(p, c, u, f, F, losses):
    """Shaft torque and brake force for a wheel force F [N]; most torque returned."""
    eta = p.gear_loss.efficiency
    f.k = gear_transmission(F, eta)
    u.tau = F / (f.k * c.n) + losses
    high = torque_envelope(p.motor.tau_max, p.motor.P_max, c.n * f.w)
    low = max(least_torque(p, c, c.n * f.w), motor_brakes(p, u.tau, f.v))
    u.brake = 0.0
    if u.tau < low:
        u.tau = low
        f.k = gear_transmission(low - losses, eta)
        u.brake = f.k * c.n * (low - losses) - F
    f.T_L = u.tau - losses
    return high
