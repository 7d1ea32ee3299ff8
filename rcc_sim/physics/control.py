"""Who decides the torque: the speed loop of a scaled car, the driver of a car."""

from rcc_sim.jit import jit
from rcc_sim.physics.effects.current_limit import limited_current
from rcc_sim.physics.effects.rotor_inertia import reflected_mass
from rcc_sim.physics.effects.speed_dead_zone import commands_nothing, seen_speed
from rcc_sim.physics.effects.speed_loop import true_gain
from rcc_sim.physics.effects.steering_backlash import with_play
from rcc_sim.physics.effects.steering_gain import geared_angle
from rcc_sim.physics.effects.steering_lag import lagged, mean_lagged
from rcc_sim.physics.effects.steering_offset import offset_angle
from rcc_sim.physics.effects.throttle_dead_zone import felt_throttle
from rcc_sim.physics.effects.throttle_gain import given_force
from rcc_sim.physics.powertrain import (
    least_torque,
    motor_brakes,
    torque_envelope,
    voltage_limited_current,
)
from rcc_sim.physics.tables import bilinear
from rcc_sim.physics.ticks import share_beyond

SLOW = 0.15
"""Speed that a driver has lost for its T_d where no more is wound up, and that a foot
on the brake takes off in it: of the vehicle's own, l/t = sqrt(C_F l/m). [1]"""


@jit
def most_current(p, c, omega):
    """Most motoring q-current [A] at omega [rad/s], and whether it is by the voltage.

    Else it is the file's limit, or the effect's.
    """
    given = limited_current(c.i_max, p.current_limit.max_current_a)
    R = p.copper_loss.phase_resistance_ohm
    reach = voltage_limited_current(p.battery.u_0, omega, R, p.motor.psi)
    return min(given, reach), reach < given


@jit
def speed_loop(p, c, s, u, flow):
    """Torque [N m] of the ESC's PI loop on motor speed, limited and wound up never.

    The integral waits while the output is at a limit and the error drives it
    further, and for a part of the tick in which it reaches or leaves one; it is zeroed
    when the reference is 0 or inside the dead zone.
    """
    omega_ref = u.v_ref * c.n_file
    if omega_ref > p.motor.omega_max:
        omega_ref = p.motor.omega_max
        flow.limited += p.control.T_loop
    threshold = p.speed_dead_zone.threshold_radps
    if commands_nothing(omega_ref, threshold):
        s.integral = 0.0
        return 0.0
    change = c.n * abs(s.a_x) * p.control.T_loop
    error = omega_ref - seen_speed(c.n * s.w, threshold, change)
    K_p = true_gain(p.control.K_p, p.speed_loop.proportional_scale)
    K_i = true_gain(p.control.K_i, p.speed_loop.integral_scale)
    more = K_i * error * p.control.T_loop
    integral = s.integral + more
    if omega_ref == 0.0:
        integral, more = 0.0, 0.0
    i_q = K_p * error + integral
    high, by_voltage = most_current(p, c, c.n * s.w)
    if by_voltage and i_q > high:
        flow.limited += p.control.T_loop
    low = c.i_min
    beyond = i_q - high if error > 0.0 else low - i_q
    s.integral = integral - more * share_beyond(beyond, K_p * change)
    return c.K_t * min(max(i_q, low), high)


@jit
def driver(p, c, s, u, flow, F_resist):
    """Wheel force [N] that a driver asks for to follow the reference.

    Asks for no more speed than the motor may turn. Knows the vehicle's mass and
    resistance F_resist [N]; what is left of the speed error is closed with time
    constant T_d, and its integral with 4 T_d.
    """
    T_d, slow = p.control.T_driver, SLOW * c.l / c.t_char
    v_ref = u.v_ref
    a_ref = u.a_ref
    if v_ref * c.n > p.motor.omega_max:
        v_ref = p.motor.omega_max / c.n
        a_ref = 0.0
        flow.limited += p.control.T_loop
    error = v_ref - s.v_x
    if u.v_ref == 0.0:
        s.integral = 0.0
    else:
        s.integral += error * p.control.T_loop
        most = slow * T_d
        s.integral = min(max(s.integral, -most), most)  # bounded: no wind-up
    demand = a_ref + error / T_d + s.integral / (4.0 * T_d * T_d)
    if u.v_ref == 0.0 and u.a_ref == 0.0:
        demand -= slow / T_d  # a foot on the brake at standstill
    return (c.m + reflected_mass(c.J, c.n)) * demand + F_resist


@jit
def split_force(p, c, flow, F, omega, tau_loss):
    """Motor torque [N m] and friction-brake force [N] for a wheel force F [N].

    The motor gives what its envelope and the battery's voltage allow; what it may not
    brake, friction brakes do.
    """
    wanted = F / c.n + tau_loss
    high = torque_envelope(p.motor.tau_max, p.motor.P_max, omega)
    if c.K_t > 0.0:
        i_max, by_voltage = most_current(p, c, omega)
        reach = i_max * c.K_t
        if by_voltage and wanted > reach and reach < high:
            flow.limited += p.control.T_loop
        high = min(high, reach)
    low = max(least_torque(p, c, omega), motor_brakes(p, wanted, omega / c.n))
    if wanted > high:
        return high, 0.0
    if wanted < low:
        return low, (low - wanted) * c.n
    return wanted, 0.0


@jit
def throttle_force(p, throttle, v, force):
    """Wheel force [N] of a throttle at v [m/s], bilinear in the file's table.

    The table is clamped at its edges: (throttle, speed, force by both).
    """
    x = felt_throttle(throttle, p.throttle_dead_zone.threshold)
    mapped = bilinear(x, v, force[0], force[1], force[2])
    return given_force(mapped, p.throttle_gain.gain)


@jit
def road_wheel_angle(p, c, s, command):
    """Angle [rad] of the road wheels: lag(backlash(gain · command + offset)).

    It is the tick's mean. The linkage ends at the vehicle's largest steering angle.
    """
    target = offset_angle(
        geared_angle(command, p.steering_gain.gain), p.steering_offset.angle_rad
    )
    target = min(max(target, -p.control.delta_max), p.control.delta_max)
    s.play = with_play(s.play, target, p.steering_backlash.width_rad)
    lag = p.steering_lag.time_constant_s
    was = s.angle
    s.angle = lagged(was, s.play, c.steer_share)
    return mean_lagged(was, s.play, c.steer_share, lag, p.control.T_loop)
