"""How far stated figures moved: each, and all together as the sds of one."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import norm

from rcc_sim.definitions.cycle import parse_cycle
from rcc_sim.definitions.vehicle import load_vehicle
from rcc_sim.diagnose.fitting.fit import Fit
from rcc_sim.diagnose.fitting.knobs import Knob, tolerance_knobs
from rcc_sim.diagnose.fitting.pulls import moved, moved_together
from rcc_sim.diagnose.residuals.posed import problem_of
from rcc_sim.simulate.run import simulate
from rcc_sim.trace import Trace


def fitted(pulls, narrowed):
    """A fit that moved unit figures so far, and narrowed their sds so."""
    knobs = tuple(Knob(f"body.x{i}", 0.0, 1.0) for i in range(len(pulls)))
    values = {k.key: float(x) for k, x in zip(knobs, pulls, strict=True)}
    information = np.diag(1 / np.asarray(narrowed, dtype=float) ** 2)
    return Fit(values, knobs, 0, 0, [], [], information), [k.key for k in knobs]


def test_a_radius_that_moved_is_told_by_its_own_name():
    scale = Knob("effects.wheel_radius.scale", 1.0, 0.01)
    fit = Fit({scale.key: 0.976}, (scale,), 0, 0, [], [])
    assert moved(fit, ["tyres.radius_m"]) == {"tyres.radius_m": pytest.approx(-2.4)}
    named = Fit({scale.key: 0.976}, (replace(scale, sd=np.inf),), 0, 0, [], [])
    assert moved(named, ["tyres.radius_m"]) == {}


@pytest.mark.parametrize("pull", [0.3, -2.0, 6.0, -11.0])
def test_one_figure_alone_is_as_far_off_as_it_is(pull):
    assert moved_together(*fitted([pull], [0.1])) == pytest.approx(abs(pull))


def test_where_nothing_is_stated_nothing_moved():
    assert moved_together(fitted([3.0], [0.1])[0], []) == 0.0


def test_many_figures_a_little_off_are_as_unlikely_as_one_far_off():
    # chi-squared of 4 at 36: P = exp(-18) (1 + 18)
    together = moved_together(*fitted([3.0, 3.0, -3.0, -3.0], [0.01] * 4))
    assert 2 * norm.sf(together) == pytest.approx(np.exp(-18.0) * 19, rel=2e-3)
    # no farther for what the logs tell nothing of
    more = moved_together(*fitted([3.0, 3.0, -3.0, -3.0, 0.0], [0.01] * 4 + [1.0]))
    assert more == pytest.approx(together, rel=1e-3)
    assert (
        moved_together(*fitted([60.0] * 4, [0.01] * 4)) == 120.0
    )  # rarer than any float


def test_a_sound_vehicle_s_figures_are_no_farther_off_than_chance_has_it():
    """Figures drawn by their sds and measured, each by a sensor of its own."""
    rng = np.random.default_rng(1)
    noise = np.array([0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0])
    kept = 1 / (1 + 1 / noise**2)  # variance after
    far = []
    for _ in range(4000):
        true = rng.normal(size=len(noise))
        seen = true + rng.normal(scale=noise)
        far.append(moved_together(*fitted(seen * (1 - kept), np.sqrt(kept))))
    for sds in (1.0, 2.0, 3.0):
        assert np.mean(np.array(far) > sds) < 1.3 * 2 * norm.sf(sds)


@pytest.mark.parametrize("car", ["twizy", "tesla_model_3", "r1t_epa"])
def test_no_efficiency_is_more_than_one(car):
    """Where it multiplies no map; a drive of a late speed asked for 1.06."""
    vehicle = load_vehicle(car)
    run = simulate(vehicle, parse_cycle("udds[0:60]"), imposed=True, output_rate=5.0)
    log = {c: run.trace[c] for c in ("time_s", "speed_mps", "battery_power_w")}
    problem = problem_of(Trace(log, name="log"), vehicle)
    key = "effects.motor_efficiency.scale"
    knob = next(k for k in tolerance_knobs([problem]) if k.key == key)
    assert knob.high == 1.0
