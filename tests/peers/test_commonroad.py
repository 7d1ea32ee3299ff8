"""Lateral motion against CommonRoad's single-track model (M. Althoff et al., TUM).

Both are given the same steering and the speed that our car drove, so that only the
lateral equations are compared. Theirs are linear in the slip angles, ours are not:
steering keeps the axles' slip angles below 2°.
"""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicSpline

from rcc_sim.definitions.cycle import Cycle
from rcc_sim.simulate.run import simulate
from tests.cars import CAR, car

pytest.importorskip("vehiclemodels", reason="needs commonroad-vehicle-models")
from vehiclemodels.vehicle_dynamics_st import vehicle_dynamics_st
from vehiclemodels.vehicle_parameters import setup_vehicle_parameters

BODY = CAR["body"]
M, I_Z = BODY["mass_kg"], BODY["yaw_inertia_kgm2"]
L_F, L_R = BODY["cg_to_front_axle_m"], BODY["cg_to_rear_axle_m"]
L = L_F + L_R
G_THEIRS = 9.81  # m/s², a literal in vehicle_dynamics_st
MU = 1.0
DURATION = 6.0
ACROSS = math.radians(2.0)  # most that an axle may slip


def commonroad_parameters(C_F, C_R):
    """Our car as their parameters; C_F, C_R [N/rad] of one tyre.

    Their axles share one coefficient, C_S = -p_ky1 / p_dy1, times the axle's load:
    m μ C_S (g l_R - h a) / l in front and m μ C_S (g l_F + h a) / l behind. At a = 0
    that is a neutral car and no other. We take a = 1 m/s² and the height h (of either
    sign) whose constant shift of load makes the two stiffnesses ours, 2 C_F and 2 C_R.
    """
    p = setup_vehicle_parameters(vehicle_id=1)
    C_S = 2 * (C_F + C_R) / (M * G_THEIRS * MU)
    p.m, p.I_z, p.a, p.b = M, I_Z, L_F, L_R
    p.tire.p_dy1, p.tire.p_ky1 = MU, -C_S * MU
    p.h_s = G_THEIRS * L_R - 2 * C_F * L / (M * MU * C_S)
    return p


def commonroad_motion(p, t, speed, steer):
    """Their x, y, yaw, yaw rate and sideslip at the times t."""
    v = CubicSpline(t, speed)

    def rhs(time, state):
        x, y, psi, r, beta = state
        full = [x, y, float(steer(time)), float(v(time)), psi, r, beta]
        rate = vehicle_dynamics_st(full, [0.0, 1.0], p)
        return [rate[0], rate[1], *rate[4:]]  # steering and speed are given

    span = (t[0], t[-1])
    done = solve_ivp(rhs, span, np.zeros(5), t_eval=t, rtol=1e-7, atol=1e-10)
    assert done.success
    return done.y


def random_drive(seed):
    """Stiffnesses, speed over time and smooth steering over time."""
    draw = np.random.default_rng(seed)
    C_F, C_R = draw.uniform(80.0, 130.0, 2)
    if seed % 4 == 0:  # the neutral car that they have without any shift of load
        C_R = C_F * L_F / L_R
    v_0 = draw.uniform(2.5, 5.0)
    swing = 0.0 if seed % 2 == 0 else draw.uniform(0.1, 0.4)
    omega = 2 * math.pi * draw.uniform(0.1, 2.0, 3)
    phase = draw.uniform(0, 2 * math.pi, 3)
    share = draw.uniform(0.2, 1.0, 3)
    limit = min(0.045, 1.6 * L / v_0**2)  # rad; some 1.6 m/s² in a steady bend
    share *= limit / share.sum()
    slow = 2 * math.pi * draw.uniform(0.05, 0.15)

    def speed(t):
        return v_0 + swing * np.sin(slow * t)

    def steer(t):
        return sum(a * np.sin(w * t + q) for a, w, q in zip(share, omega, phase,
                   strict=True))  # fmt: skip

    return C_F, C_R, speed, steer


def rms(values):
    return float(np.sqrt(np.mean(np.square(values))))


def compare(seed):
    """RMS difference over RMS value by quantity, and the greatest slip angle [rad]."""
    C_F, C_R, speed, steer = random_drive(seed)
    fine = np.linspace(0.0, DURATION, 6001)
    made = car(
        tyres__front_cornering_stiffness_n_per_rad=C_F,
        tyres__rear_cornering_stiffness_n_per_rad=C_R,
        controller__loop_rate_hz=10000.0,
    )
    cycle = Cycle("c", fine, speed(fine))
    ours = simulate(made, cycle, steer=(fine, steer(fine)), output_rate=200.0).trace
    t, v, r, psi = (
        ours[c] for c in ("time_s", "speed_mps", "yaw_rate_radps", "yaw_rad")
    )
    # lateral velocity is no column of a trace: the path's velocity along the body's y
    dx, dy = (CubicSpline(t, ours[c])(t, 1) for c in ("x_m", "y_m"))
    v_y = dy * np.cos(psi) - dx * np.sin(psi)
    p = commonroad_parameters(C_F, C_R)
    _, y_theirs, psi_theirs, r_theirs, beta = commonroad_motion(p, t, v, steer)
    pairs = {
        "yaw rate": (r, r_theirs),
        "lateral velocity": (v_y, v * beta),
        "yaw angle": (psi, psi_theirs),
        "y": (ours["y_m"], y_theirs),
    }
    front = np.abs((v_y + L_F * r) / v - steer(t)).max()
    rear = np.abs((v_y - L_R * r) / v).max()
    apart = {k: rms(a - b) / rms(b) for k, (a, b) in pairs.items()}
    return apart, max(front, rear)


@pytest.mark.parametrize(
    "seed",
    [pytest.param(k, marks=[pytest.mark.thorough] * (k >= 10)) for k in range(20)],
)
def test_lateral_motion_is_that_of_commonroads_single_track_model(seed):
    apart, slip = compare(seed)
    assert math.radians(0.2) < slip < ACROSS
    assert max(apart.values()) < 0.01, apart
