"""A fit ends in the same place from the truth and from what the file states."""

from dataclasses import replace
from math import inf

import numpy as np
import pytest

from rcc_sim.definitions.cycle import Cycle, parse_cycle
from rcc_sim.definitions.vehicle import load_vehicle
from rcc_sim.diagnose.fitting import descent
from rcc_sim.diagnose.fitting.descent import SETTLED
from rcc_sim.diagnose.fitting.engine import Engine
from rcc_sim.diagnose.fitting.knobs import NEARBY, Knob, acts_of, nuisance_knobs
from rcc_sim.diagnose.fitting.tips import no_surer
from rcc_sim.diagnose.noise.whitener import Whitener
from rcc_sim.diagnose.residuals.posed import problem_of
from rcc_sim.diagnose.residuals.problem import Problem
from rcc_sim.simulate.run import LaneChanges, simulate
from rcc_sim.trace import Trace

NOISE = {
    "speed_mps": 0.007,
    "yaw_rate_radps": 0.01,
    "accel_x_mps2": 0.15,
    "accel_y_mps2": 0.15,
    "motor_current_a": 0.2,
    "battery_voltage_v": 0.01,
    "battery_current_a": 0.1,
}
EXACT = ("time_s", "speed_ref_mps", "steer_cmd_rad", "battery_energy_j")


def problem_with(settings: dict[str, float]) -> Problem:
    """A drive of a car that differs, seen by sensors with noise."""
    car = load_vehicle("rcc")
    udds = parse_cycle("udds[20:330]")
    cycle = Cycle("c", 0.2256 * udds.time_s, 0.416 * udds.speed_mps)
    lanes = LaneChanges(20.0, 0.32, 13.0)
    run = simulate(
        car.changed(settings=settings), cycle, lanes=lanes, output_rate=100.0
    ).trace
    rng = np.random.default_rng(3)
    log = {name: run[name] for name in EXACT}
    for name, sd in NOISE.items():
        log[name] = run[name] + rng.normal(0, sd, len(run))
    return problem_of(Trace(log, name="log"), car)


@pytest.mark.parametrize(
    ("key", "true", "start"),
    [
        ("effects.current_sensor_scale.scale", 0.92, 0.98),
        pytest.param(
            *("effects.payload.mass_kg", 0.3, 0.05), marks=pytest.mark.thorough
        ),
        pytest.param(
            *("effects.rear_cornering_stiffness.scale", 0.8, 0.95),
            marks=pytest.mark.thorough,
        ),
    ],
)
def test_a_fit_ends_as_high_from_afar_as_from_the_truth(key, true, start):
    engine = Engine([problem_with({key: true})])
    knobs = nuisance_knobs(engine.problems)
    step = 0.02 * (abs(true - 1) if key.endswith("scale") else true)
    sought = Knob(key, start, inf, -1.0, 3.0, step, acts_of(load_vehicle("rcc"), key))
    near = descent.fit(engine, {key: true}, [*knobs, sought])
    null = descent.fit(engine, {}, knobs)
    afar = descent.fit(engine, null.values | {key: start}, [*null.knobs, sought])
    ends = [descent.fit(engine, f.values, f.knobs, near.noise) for f in (near, afar)]
    near, afar = (engine.evaluate(f.values, f.knobs, near.noise) for f in ends)
    assert afar.score > near.score - 2 * SETTLED
    assert abs(afar.values[key] - true) < 3 * ends[0].sd(key)


def test_steps_are_as_fine_as_what_is_told():
    wide = Knob("body.mass_kg", 4.0, 0.1)
    assert wide.stride == 0.05
    assert wide.finer(0.001).stride == NEARBY * 0.001
    assert wide.finer(1.0).stride == wide.stride


class Jumpy(Engine):
    """Residuals of one row more jump wherever a figure passes a hundredth."""

    def __init__(self, jumps: float) -> None:
        self.jumps = jumps
        self.noise = [Whitener(np.ones(400), np.zeros(0), [], 1.0, np.ones(400, bool))]

    def residuals(self, values: dict[str, float], coarse: bool = False) -> list:
        x, rng = values["x"], np.random.default_rng(1)
        e = rng.normal(size=400) - x
        passed = int(np.floor(100 * x)) % 400
        e[passed] += self.jumps
        return [e]


@pytest.mark.parametrize("jumps", [0.0, 20.0])
def test_an_interval_is_no_narrower_than_the_likelihood_falls(jumps):
    """As told by a slope over a narrow step across a jump, and by one without any."""
    engine = Jumpy(jumps)
    x = float(np.mean(np.random.default_rng(1).normal(size=400)))
    fit = engine.evaluate({"x": x}, [Knob("x", x)], engine.noise)
    narrow = replace(fit, information=np.array([[1e8]]))
    wide = replace(fit, information=np.array([[1.0]]))
    told = no_surer(engine, narrow, {"x"})
    assert told.sd("x") == pytest.approx(1 / np.sqrt(0.8 * 400), rel=0.4)
    assert no_surer(engine, wide, {"x"}).sd("x") == pytest.approx(1.0)
    assert no_surer(engine, narrow, set()).sd("x") == pytest.approx(1e-4)
