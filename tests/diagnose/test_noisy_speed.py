"""A speed that is noisy: how gently it draws the model, and what that leaves."""

import numpy as np
import pytest

from rcc_sim.definitions.cycle import Cycle
from rcc_sim.definitions.vehicle import load_vehicle
from rcc_sim.diagnose.fitting import descent
from rcc_sim.diagnose.fitting.engine import Engine
from rcc_sim.diagnose.fitting.knobs import nuisance_knobs
from rcc_sim.diagnose.residuals.posed import problem_of
from rcc_sim.simulate.replay import RECALLS
from rcc_sim.simulate.run import simulate
from rcc_sim.trace import Trace
from tests.cars import car

CYCLE = Cycle("c", np.array([0, 2, 8, 14, 22, 30.0]), np.array([0, 0, 5, 3, 7, 2.0]))
NOISE = {"motor_current_a": 0.2, "battery_current_a": 0.05, "accel_x_mps2": 0.15}
LOSSES = {"drivetrain_damping": {"damping_nms_per_rad": 1.2e-5}}
SEEN = ("time_s", "speed_ref_mps", "battery_voltage_v", "battery_energy_j")


def problem(noise, vehicle=None):
    """Nothing hidden: a log of the car itself, its speed with so much noise. [m/s]"""
    vehicle = vehicle or car(LOSSES)
    run = simulate(vehicle, CYCLE, output_rate=100.0).trace
    rng = np.random.default_rng(1)
    columns = {name: run[name] for name in SEEN}
    for name, size in (NOISE | {"speed_mps": noise}).items():
        columns[name] = run[name] + rng.normal(0, size, len(run))
    return problem_of(Trace(columns, name="log"), vehicle)


def test_a_clean_speed_draws_the_model_as_ever():
    assert problem(0.002).recalls == RECALLS


def test_a_noisy_speed_draws_it_more_gently_the_noisier():
    some, much = (problem(noise).recalls[0] for noise in (0.02, 0.05))
    assert RECALLS[0] < some < much


def test_a_coasting_car_is_drawn_by_less_the_noisier_its_speed():
    """A share of 1 / noise²: the noise that it makes of currents stays what it may."""
    clean, some, much = (problem(noise).recalls[2] for noise in (0.002, 0.01, 0.02))
    assert clean == 1.0 > some > much > 0.0
    assert some / much == pytest.approx(4.0, rel=0.2)


def test_an_open_loop_car_is_drawn_as_ever():
    dart = load_vehicle("dart_jetracer")
    time = np.arange(0, 20, 0.02)
    columns = {"time_s": time, "throttle": np.where(time % 5 < 3, 0.3, 0.0)}
    columns["steer_cmd_rad"] = np.zeros(len(time))
    columns["speed_mps"] = np.random.default_rng(2).normal(1.0, 0.2, len(time))
    assert problem_of(Trace(columns, name="log"), dart).recalls == RECALLS


def test_a_motion_that_is_imposed_is_not_drawn_at_all():
    log = problem(0.05).log
    columns = {n: log[n] for n in log.columns if n != "speed_ref_mps"}
    assert problem_of(Trace(columns, name="log"), car(LOSSES)).recalls == RECALLS


@pytest.mark.parametrize("noise", [0.002, 0.03])
def test_no_figure_gains_by_smoothing_what_a_noisy_speed_brings_in(noise):
    engine = Engine([problem(noise, car({**LOSSES, "motor_lag": LAG}))])
    knobs = nuisance_knobs(engine.problems)
    fit = descent.fit(engine, {}, knobs)
    truth = engine.evaluate({k.key: k.value for k in knobs}, knobs, fit.noise)
    free = len(knobs) / 2  # nats that so many figures gain by chance
    assert fit.loglik - truth.loglik < 3 * free


LAG = {"time_constant_s": {"value": 0.0, "sd": 0.003}}
