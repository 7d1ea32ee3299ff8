"""Who commands the plant's motor: a speed loop, or a driver."""

from rcc_sim.blind.plant import CLOCK, GRAVITY
from rcc_sim.jit import jit


@jit
def speed_command(p, held, w, integral, T):
    """Current [A] that the speed loop asks for, and its new integral."""
    w_ref = held * p.n_file
    if w_ref < p.dead_zone or w_ref == 0.0:
        integral = 0.0
        if w_ref < p.dead_zone:
            return 0.0, 0.0
    seen = w
    if w < p.dead_zone:
        seen = 0.0
    error = w_ref - seen
    grown = integral + p.K_i * error * T
    if w_ref == 0.0:
        grown = 0.0
    i = p.K_p * error + grown
    high = min(p.i_max, p.i_limit)
    low = -min(p.i_max, p.regen / p.K_t)
    if i > high:
        return high, integral if error > 0.0 else grown
    if i < low:
        return low, integral if error < 0.0 else grown
    return i, grown


@jit
def motor_part(p, tau, v):
    """Torque [N m] of a demand that brakes leave to the motor."""
    if tau >= 0.0:
        return tau
    part = 1.0 - p.brake_share
    if v < p.fade:
        part *= max(1.5 * v / p.fade - 0.5, 0.0)
    return part * tau


@jit
def drive_command(p, m, ref, ref_next, w, integral):
    """Current [A] and brake force [N] of a driver who follows a speed, each clock."""
    v = w / p.n
    error = ref - v
    integral = min(max(integral + error * CLOCK, -p.T_driver), p.T_driver)
    if ref == 0.0:
        integral = 0.0
    wish = (ref_next - ref) / CLOCK
    wish += error / p.T_driver + integral / (6.0 * p.T_driver * p.T_driver)
    if ref == 0.0 and ref_next == 0.0:
        wish -= 1.0
    F = (m + p.J * p.n * p.n) * wish + 0.01 * m * GRAVITY + p.half_rho_A * v * v
    tau = F / p.n
    high = min(p.tau_max, p.i_limit * p.K_t)
    low = -min(p.regen, p.tau_max)
    low = max(low, motor_part(p, tau, v))
    brake = 0.0
    if tau < low:
        brake = (low - tau) * p.n
        tau = low
    if ref == 0.0 and ref_next == 0.0 and v == 0.0:  # held by the brakes
        tau, brake = 0.0, 0.1 * m * GRAVITY
    return min(tau, high) / p.K_t, brake, integral
