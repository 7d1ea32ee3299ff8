"""Of a log that begins in the middle of a swerve, the start is no gap."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from rcc_sim.analyse.logged import Logged
from rcc_sim.diagnose.residuals.posed import problem_of
from rcc_sim.diagnose.run import diagnose
from rcc_sim.trace import Trace
from tests.cars import truck

CAR = truck({})
SPEED, WAY = 20.0, 2.5  # m/s, rad/s
BEGIN = 2.0 * np.pi * 2.0 / WAY  # s; the wheels go straight, the vehicle still turns
NOISE = {"yaw_rate_radps": 0.003, "accel_y_mps2": 0.05}


def steer(t):
    """From side to side, as quickly as a driver may. [rad]"""
    return 0.04 * np.sin(WAY * t)


def swerving(seed):
    """The linear bicycle at a steady speed, by an adaptive integrator."""
    body, tyres = CAR.body, CAR.tyres
    m, I_z = body.mass_kg.value, body.yaw_inertia_kgm2.value
    l_F, l_R = body.cg_to_front_axle_m.value, body.cg_to_rear_axle_m.value
    C_F = 2 * tyres.front_cornering_stiffness_n_per_rad.value
    C_R = 2 * tyres.rear_cornering_stiffness_n_per_rad.value

    def forces(t, v_y, r):
        front = -C_F * ((v_y + l_F * r) / SPEED - steer(t))
        return front, -C_R * (v_y - l_R * r) / SPEED

    def change(t, state):
        F_F, F_R = forces(t, *state)
        return (F_F + F_R) / m - SPEED * state[1], (l_F * F_F - l_R * F_R) / I_z

    t = np.arange(0.0, BEGIN + 40.0, 0.02)
    how = {"t_eval": t, "rtol": 1e-9, "atol": 1e-12, "max_step": 0.02}
    v_y, r = solve_ivp(change, (t[0], t[-1]), (0.0, 0.0), **how).y
    F_F, F_R = forces(t, v_y, r)
    rng = np.random.default_rng(seed)
    log = {
        "time_s": t,
        "speed_mps": SPEED + 0.02 * rng.normal(size=len(t)),
        "steer_cmd_rad": steer(t),
        "yaw_rate_radps": r,
        "accel_y_mps2": (F_F + F_R) / m,
    }
    for name, sd in NOISE.items():
        log[name] = log[name] + sd * rng.normal(size=len(t))
    rows = t >= BEGIN
    return Trace({c: x[rows] for c, x in log.items()})


@pytest.mark.slow
@pytest.mark.parametrize("seed", [1, 2])
def test_no_cause_is_named_and_nothing_unknown(seed):
    found = diagnose([Logged(swerving(seed), (), None)], CAR)
    assert found.status == "no_gap"
    assert not found.asserted


def test_cornering_is_judged_once_the_start_is_forgotten():
    log = swerving(3)
    problem = problem_of(log, CAR)
    t = log["time_s"] - log["time_s"][0]
    tyres, m = CAR.tyres, CAR.body.mass_kg.value
    forgotten = m * SPEED / tyres.front_cornering_stiffness_n_per_rad.value
    assert 0.5 < forgotten < 4.0
    for channel, rows in zip(problem.channels, problem.judged, strict=True):
        assert channel in NOISE
        assert np.count_nonzero(rows != (t >= forgotten)) < 3


def test_one_that_stands_when_its_log_begins_has_nothing_to_forget():
    log = swerving(4)
    speed = np.where(np.arange(len(log)) == 0, 0.0, log["speed_mps"])
    problem = problem_of(Trace(dict(log.columns) | {"speed_mps": speed}), CAR)
    assert problem.judged[0][10]
