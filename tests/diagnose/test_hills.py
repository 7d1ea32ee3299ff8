"""Short hills are told from a rough road, in windows no shorter than they need be."""

import numpy as np
import pytest

from rcc_sim.definitions.vehicle import load_vehicle
from rcc_sim.diagnose.fitting import descent
from rcc_sim.diagnose.fitting.engine import Engine
from rcc_sim.diagnose.fitting.knobs import nuisance_knobs
from rcc_sim.diagnose.profiles.varying import FINER, SHORTEST, finer, profile_cause
from rcc_sim.diagnose.residuals.posed import problem_of
from rcc_sim.trace import Trace

SIZES = {"battery_power_w": 300.0, "accel_x_mps2": 0.05, "motor_torque_nm": 2.0}


def drive(seconds, slope_of):
    """A drive at 10 Hz, noisy, on a road whose slope only the drive knew."""
    rng = np.random.default_rng(12)
    t = np.arange(0.0, seconds, 0.1)
    v = 15 + 6 * np.sin(t / 17) + 3 * np.sin(t / 5.3)
    car = load_vehicle("tesla_model_3")
    flat = problem_of(Trace({"time_s": t, "speed_mps": v}), car)
    seen = flat.on_road(flat.distance, slope_of(flat.distance, rng)).run(car)
    noisy = {c: seen[c] + size * rng.normal(size=len(t)) for c, size in SIZES.items()}
    return problem_of(Trace({"time_s": t, "speed_mps": v} | noisy), car)


def cause_of(problem):
    engine = Engine([problem])
    fit = descent.fit(engine, {}, nuisance_knobs([problem]))
    return profile_cause(engine, fit, {"road_grade"})[0]


@pytest.mark.slow
def test_hills_that_hang_together_in_many_windows_alone_are_found():
    def hills(s, rng):
        phase = rng.uniform(0, 6, 3)[:, None]
        waves = np.sin(s / np.array([[93.0], [129.0], [171.0]]) + phase)
        return 0.012 * waves.sum(axis=0)

    problem = drive(600.0, hills)
    cause = cause_of(problem)
    assert cause is not None
    s = problem.distance
    true = hills(s, np.random.default_rng(12))
    assert np.corrcoef(cause.profiles[0].at(s), true)[0, 1] > 0.8


@pytest.mark.slow
def test_a_rough_road_is_no_hill_however_fine_the_windows():
    def rough(s, rng):
        knots = np.arange(0.0, s[-1] + 4, 4.0)
        return np.interp(s, knots, 0.03 * rng.normal(size=len(knots)))

    assert cause_of(drive(600.0, rough)) is None


def test_no_window_is_shorter_than_a_moment_and_no_table_larger_than_memory():
    short = drive(75.0, lambda s, rng: 0 * s)
    assert finer(short) == []
    long = drive(400.0, lambda s, rng: 0 * s)
    assert finer(long) == [n for n in FINER if n * SHORTEST < 400.0] == [120, 240]
