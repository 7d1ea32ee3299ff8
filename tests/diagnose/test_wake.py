"""A limit that is never reached as stated may be lower within its sd: no cause."""

import numpy as np
import pytest

from rcc_sim.definitions.cycle import parse_cycle
from rcc_sim.definitions.vehicle import load_vehicle
from rcc_sim.diagnose.fitting import descent
from rcc_sim.diagnose.fitting.engine import Engine
from rcc_sim.diagnose.fitting.knobs import nuisance_knobs
from rcc_sim.diagnose.fitting.wake import asleep, woken
from rcc_sim.diagnose.residuals.posed import problem_of
from rcc_sim.simulate.run import simulate
from rcc_sim.trace import Trace

KEY = "effects.regeneration_limit.max_torque_nm"
CAR = load_vehicle("tesla_model_3")
NOISE = {"speed_mps": 0.02, "accel_x_mps2": 0.03, "battery_power_w": 100.0}


def fitted(limit):
    car = CAR.changed(settings={KEY: limit})
    run = simulate(car, parse_cycle("udds[20:320]"), imposed=True, output_rate=10.0)
    rng = np.random.default_rng(5)
    noisy = {
        c: run.trace[c] + rng.normal(0, sd, len(run.trace)) for c, sd in NOISE.items()
    }
    log = Trace({"time_s": run.trace["time_s"], **noisy}, name="log")
    engine = Engine([problem_of(log, CAR)])
    return engine, descent.fit(engine, {}, nuisance_knobs(engine.problems))


@pytest.fixture(scope="module")
def low():
    figure = CAR.figures()[KEY]
    return figure.value - 1.5 * figure.sd


def test_it_is_found_within_its_sd(low):
    engine, null = fitted(low)
    assert KEY in [k.key for k in asleep(null)]
    found = woken(engine, null)
    assert found.values[KEY] == pytest.approx(low, rel=0.03)
    assert found.score > null.score + 18.0


def test_it_sleeps_on_where_it_is_as_stated():
    engine, null = fitted(CAR.figures()[KEY].value)
    assert woken(engine, null).score <= null.score + 1.0
