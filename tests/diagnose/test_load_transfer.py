"""Load that moves between the axles is no cause: by its closed form, and by a plant."""

from dataclasses import replace

import numpy as np
import pytest

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


@pytest.mark.slow
def test_a_car_that_speeds_up_in_bends_leaves_nothing_unknown():
    rng = np.random.default_rng(2)
    given = winding(swing=6.0, period=2.0)
    t = given["time_s"]
    known = problem_of(Trace(given), CAR)
    seen, felt = known.driven({}), 3.0 * np.cos(t / 2.0)
    moved = felt * CAR.body.cg_height_m.value / G
    axles = {
        "front": -moved / CAR.body.cg_to_rear_axle_m.value,
        "rear": moved / CAR.body.cg_to_front_axle_m.value,
    }
    logged = {c: seen[c] + size * rng.normal(size=len(t)) for c, size in SIZES.items()}
    for axle, share in axles.items():
        key = f"effects.{axle}_cornering_stiffness.scale"
        stiffer = known.driven({key: 1.02})
        for c in SIZES:
            logged[c] = logged[c] + (stiffer[c] - seen[c]) / 0.02 * share
    problem = problem_with(given, logged)
    engine = Engine([problem])
    knobs = nuisance_knobs([problem])
    flat = [k for k in knobs if "load_transfer" not in k.key]
    assert len(flat) == len(knobs) - 1
    assert remainder(engine, descent.fit(engine, {}, flat)).is_real
    assert not remainder(engine, descent.fit(engine, {}, knobs)).is_real
