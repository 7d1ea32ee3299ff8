"""How a vehicle moves that is under way already when its log begins."""

from rcc_sim.jit import jit
from rcc_sim.physics.bicycle import no_tighter
from rcc_sim.physics.params import TURNED
from rcc_sim.physics.run import steer_wheels
from rcc_sim.physics.step import pace, turn

SETTLED = 20.0  # 1; times sqrt(m l / C_F) after which a turn is what it will be
STEP = 0.1  # 1; time step, in those times
LEFT = 1e-2  # 1; share by which it may still change, in the last tenth of all that


@jit
def settle(p, c, s, u, f, command, yaw_rate):
    """Turn from the start, as one does that has held speed and command for long.

    At the speed of the state, under a steering command [rad], or at a yaw rate [rad/s]
    where that alone is known. What came before the first row nobody knows, but it was
    no straight line. One that does not settle, as it spins, begins straight.
    """
    v, tick = s.v_x, p.control.T_loop
    if p.lanes.steer == TURNED:
        u.yaw_rate = yaw_rate
        s.r = no_tighter(c, yaw_rate, v)
    if v <= 0.0:
        return
    dt = STEP * c.t_char
    pace(p, c, dt)
    steps = int(SETTLED / STEP)
    r_late = 0.0
    for k in range(steps):
        if k == steps - steps // 10:
            r_late = s.r
        steer_wheels(p, c, s, u, command)
        s.v_y -= 0.5 * dt * v * s.r  # as the body's axes turn, half before the forces
        turn(p, c, s, u, f, v, dt)
        s.v_y = 2.0 * f.v_y - s.v_y
        s.r = 2.0 * f.r - s.r
        s.v_y -= 0.5 * dt * v * s.r
    pace(p, c, tick)
    if abs(s.r - r_late) > LEFT * abs(s.r):
        s.v_y = 0.0
        s.r = 0.0
        s.alpha_F = 0.0
        s.alpha_R = 0.0
