"""Load that moves between the axles is no cause: by its closed form, and by a plant."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from rcc_sim.definitions.vehicle import load_vehicle
from rcc_sim.diagnose.fitting import descent
from rcc_sim.diagnose.fitting.engine import Engine
from rcc_sim.diagnose.fitting.knobs import nuisance_knobs
from rcc_sim.diagnose.profiles.remainder import remainder
from rcc_sim.diagnose.residuals.posed import problem_of
from rcc_sim.diagnose.residuals.shapes import USUAL_HEIGHT, height_of, load_transfer_of
from rcc_sim.trace import Trace
from rcc_sim.units import G
from tests.winding import winding

CAR = load_vehicle("tesla_model_3")
SIZES = {"yaw_rate_radps": 0.002, "accel_y_mps2": 0.05}


def problem_with(given, extra):
    return problem_of(Trace(given | extra), CAR)


def test_it_is_what_the_steady_yaw_rate_does_with_the_stiffnesses():
    """r = v δ / (l + K v²), K = m (l_R / C_F - l_F / C_R) / (2 l), C per tyre."""
    accel, steer, height = 0.5, 0.01, 1e-3
    t = np.arange(0.0, 30.0, 0.05)
    v = 8.0 + accel * t
    given = {"time_s": t, "speed_mps": v, "steer_cmd_rad": np.full(len(t), steer)}
    problem = problem_with(given, {"yaw_rate_radps": v * steer / CAR.wheelbase})
    (told,) = load_transfer_of(problem)

    body, tyres = CAR.body, CAR.tyres
    front, rear = body.cg_to_front_axle_m.value, body.cg_to_rear_axle_m.value

    def yaw_rate(share):
        h = share * CAR.wheelbase
        C_F = tyres.front_cornering_stiffness_n_per_rad.value
        C_R = tyres.rear_cornering_stiffness_n_per_rad.value
        C_F *= 1 - accel * h / (G * rear)
        C_R *= 1 + accel * h / (G * front)
        K = body.mass_kg.value * (rear / C_F - front / C_R) / (2 * CAR.wheelbase)
        return v * steer / (CAR.wheelbase + K * v * v)

    due = (yaw_rate(height) - yaw_rate(0.0)) / height
    settled = slice(100, None)
    assert told[settled] == pytest.approx(due[settled], rel=0.08)


def test_its_size_is_by_the_height_that_the_file_states():
    assert height_of(CAR) == pytest.approx(0.46 / CAR.wheelbase)
    body = CAR.body.model_copy(update={"cg_height_m": None})
    assert height_of(replace(CAR, body=body)) == USUAL_HEIGHT


def cornering(given, height, lag=0.04):
    """Yaw rate and lateral acceleration of a single track whose load moves.

    SciPy's integrator on the equations of CommonRoad's single track, tyres linear; the
    springs take a while.
    """
    body, tyres = CAR.body, CAR.tyres
    m, I_z = body.mass_kg.value, body.yaw_inertia_kgm2.value
    l_F, l_R = body.cg_to_front_axle_m.value, body.cg_to_rear_axle_m.value
    C_F = 2 * tyres.front_cornering_stiffness_n_per_rad.value
    C_R = 2 * tyres.rear_cornering_stiffness_n_per_rad.value
    t, speed, steer = (given[c] for c in ("time_s", "speed_mps", "steer_cmd_rad"))
    accel = np.gradient(speed, t)

    def forces(x, v, delta):
        v_y, r, moved = x
        slip_F = np.arctan2(v_y + l_F * r, v) - delta
        slip_R = np.arctan2(v_y - l_R * r, v)
        F_F = -C_F * (1 - moved * height / (G * l_R)) * slip_F * np.cos(delta)
        return F_F, -C_R * (1 + moved * height / (G * l_F)) * slip_R

    def rates(now, x):
        v, delta, a = (np.interp(now, t, y) for y in (speed, steer, accel))
        F_F, F_R = forces(x, v, delta)
        across, turn = (F_F + F_R) / m - v * x[1], (l_F * F_F - l_R * F_R) / I_z
        return across, turn, (a - x[2]) / lag

    x = solve_ivp(rates, t[[0, -1]], [0, 0, 0], t_eval=t, max_step=0.02, rtol=1e-6).y
    return {"yaw_rate_radps": x[1], "accel_y_mps2": sum(forces(x, speed, steer)) / m}


@pytest.mark.slow
def test_a_car_that_speeds_up_in_bends_leaves_nothing_unknown():
    rng = np.random.default_rng(2)
    given = winding(swing=6.0, period=2.0)
    seen = cornering(given, CAR.body.cg_height_m.value)
    logged = {c: x + SIZES[c] * rng.normal(size=len(x)) for c, x in seen.items()}
    problem = problem_with(given, logged)
    engine = Engine([problem])
    knobs = nuisance_knobs([problem])
    flat = [k for k in knobs if "load_transfer" not in k.key]
    assert len(flat) == len(knobs) - 1
    assert remainder(engine, descent.fit(engine, {}, flat)).is_real
    assert not remainder(engine, descent.fit(engine, {}, knobs)).is_real
