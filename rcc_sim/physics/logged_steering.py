"""How a logged steering runs between two rows: as a hand moves it, or held.

A hand moves along a cubic through the rows, with the slope at each that a parabola
through it and those beside it has: a straight line would cut 5 % off a turn of eight
rows, and look like tyres that relax.
"""

from rcc_sim.jit import jit
from rcc_sim.physics.tables import BEFORE, LINE

STRAIGHT = 1e-3  # rad; bend of two cells beside one, in which a line errs by a 16th


@jit
def enter_cell(u, time, steer, i, held):
    """Find how the steering runs from row i on: a cubic in the share of the way.

    It runs straight in the first and the last cell; before the first it stands.
    """
    u.cell = i
    u.from_t = time[i]
    u.per_s = 0.0
    u.least = 0.0 if i == 0 else -1.0
    u.steer_0 = steer[i]
    u.steer_1 = 0.0
    u.steer_2 = 0.0
    u.steer_3 = 0.0
    if held == BEFORE and i + 1 < len(time):
        u.steer_0 = steer[i + 1]
    if held != LINE or len(time) < 2:
        return
    u.per_s = 1.0 / (time[i + 1] - time[i])
    rise = steer[i + 1] - steer[i]
    u.steer_1 = rise
    if i == 0 or i + 2 >= len(time):
        return
    if abs(steer[i + 2] - steer[i + 1] - steer[i] + steer[i - 1]) < STRAIGHT:
        return
    before = (time[i] - time[i - 1]) * u.per_s  # in spans of the cell
    after = (time[i + 2] - time[i + 1]) * u.per_s
    begins = (rise * before + (steer[i] - steer[i - 1]) / before) / (1.0 + before)
    ends = (rise * after + (steer[i + 2] - steer[i + 1]) / after) / (1.0 + after)
    u.steer_1 = begins
    u.steer_3 = begins + ends - 2.0 * rise
    u.steer_2 = rise - begins - u.steer_3


@jit
def steering_at(u, t):
    """Steering [rad] at t [s], in the cell that was entered."""
    x = max((t - u.from_t) * u.per_s, u.least)
    return u.steer_0 + x * (u.steer_1 + x * (u.steer_2 + x * u.steer_3))
