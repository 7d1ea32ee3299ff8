"""Two effects that hide each other are found together."""

import json
from dataclasses import replace

import numpy as np
import pytest

from rcc_sim.analyse.logged import open_log
from rcc_sim.blind.make import make
from rcc_sim.definitions.cycle import parse_cycle
from rcc_sim.definitions.vehicle import load_vehicle
from rcc_sim.diagnose.causes.candidates import Candidate
from rcc_sim.diagnose.causes.sought import Search
from rcc_sim.diagnose.fitting.engine import Engine
from rcc_sim.diagnose.fitting.fit import Fit
from rcc_sim.diagnose.fitting.knobs import Knob
from rcc_sim.diagnose.residuals.posed import problem_of
from rcc_sim.diagnose.run import diagnose
from rcc_sim.diagnose.search.couples import most_promising
from rcc_sim.diagnose.search.screen import Screened, Slope
from rcc_sim.diagnose.search.winner import shares_of
from rcc_sim.errors import InputError
from rcc_sim.simulate.run import simulate
from rcc_sim.trace import Trace


def candidate(name, row, left):
    search = Search(f"effects.{name}.x", 0.0, -10.0, 10.0, 1.0, most=1e9)
    slope = Slope(row, -float(left @ row), 1.0)
    return Screened(Candidate(name, (search,)), 0.0, slopes={search.key: slope})


def test_the_two_that_promise_most_are_those_of_least_squares():
    rng = np.random.default_rng(2)
    rows = rng.standard_normal((6, 500))
    rows[4] = -rows[1] + 0.3 * rng.standard_normal(500)  # each hides the other
    left = -(3.0 * rows[1] + 2.5 * rows[4]) + 0.1 * rng.standard_normal(500)
    found = [candidate(f"effect_{i}", row, left) for i, row in enumerate(rows)]
    nats, best = most_promising(Fit({}, (), 0.0, 0.0, [], []), found)
    assert {one.candidate.effect for one in best} == {"effect_1", "effect_4"}
    two = rows[[1, 4]].T
    solved, (rest,), *_ = np.linalg.lstsq(two, -left, rcond=None)
    values = [x for one in best for x in one.values.values()]
    assert values == pytest.approx(solved, rel=1e-9)
    assert nats == pytest.approx(0.5 * (left @ left - rest), rel=1e-6)


def test_no_two_are_promised_out_of_their_bounds():
    rng = np.random.default_rng(3)
    rows = rng.standard_normal((2, 200))
    left = 12.0 * rows[0] + rows[1]
    found = [candidate(f"effect_{i}", row, left) for i, row in enumerate(rows)]
    assert most_promising(Fit({}, (), 0.0, 0.0, [], []), found) == (0.0, ())


@pytest.mark.slow
def test_a_speed_that_reads_too_little_and_a_drag_that_hides_it_are_told(tmp_path):
    """A drive of the blind plant in which neither gains anything alone."""
    labels = tmp_path / "labels.json"
    make(tmp_path / "cases", cases=2, seed=37380211, labels=labels)
    true = json.loads(labels.read_text())["cases"]["c0001"]["magnitudes"]
    assert set(true) == {"speed_sensor_scale", "drivetrain_damping"}
    case = tmp_path / "cases" / "c0001"
    car = load_vehicle(case / "vehicle.toml")
    found = diagnose([open_log(case / "log.csv.gz", car)], car)
    figures = {a.cause.effect: a.figures for a in found.asserted}
    assert set(figures) == set(true)
    for effect, values in true.items():
        for name, value in values.items():
            assert figures[effect][name].value == pytest.approx(value, rel=0.05)


def test_a_drag_through_which_a_wind_acts_has_its_tracks():
    """No vehicle has the wind without the drag; where the drag acts is told still."""
    drag, wind = "effects.aerodynamic_drag.drag_area_m2", "effects.headwind.speed_mps"
    car = load_vehicle("rcc")
    run = simulate(car, parse_cycle("udds[20:60]"), output_rate=50.0).trace
    names = ("time_s", "speed_ref_mps", "speed_mps", "motor_current_a")
    engine = Engine([problem_of(Trace({c: run[c] for c in names}), car)])
    values = {drag: 0.05, wind: 2.0}
    knobs = [Knob(key, x, step=0.1 * x) for key, x in values.items()]
    fit = engine.evaluate(values, knobs)
    fit = replace(fit, signals=engine.signals(values, knobs))
    with pytest.raises(InputError):
        engine.residuals({wind: 2.0})
    for key in values:
        assert shares_of(engine, fit, [key], fit.noise).sum() == pytest.approx(1.0)
