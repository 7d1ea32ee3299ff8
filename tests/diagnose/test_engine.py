"""What the fit does with figures that do not act smoothly."""

import numpy as np
import pytest
from scipy.optimize import minimize

from rcc_sim.definitions.vehicle import load_vehicle
from rcc_sim.diagnose.fitting import descent
from rcc_sim.diagnose.fitting.descent import bounded_step
from rcc_sim.diagnose.fitting.engine import Engine
from rcc_sim.diagnose.fitting.knobs import Knob, acts_of
from rcc_sim.diagnose.noise.whitener import (
    CURVATURE,
    FREEDOM,
    curvature,
    log_density,
    weights,
)
from rcc_sim.diagnose.proof import folds
from rcc_sim.diagnose.proof.folds import is_step, refitted
from rcc_sim.errors import InputError


@pytest.mark.parametrize("x", [0.52, 8.98], ids=["inside", "beside its bound"])
def test_a_figure_that_acts_in_steps_has_a_slope_all_the_same(x):
    engine = object.__new__(Engine)  # without a log
    engine.residuals = lambda values, coarse=False: [
        -np.round(values["x"], 1) * np.arange(1.0, 9.0)
    ]
    knob = Knob("x", 0.5, low=0.0, high=9.0, step=1e-2)
    ((signal,),) = engine.signals({"x": x}, [knob])
    np.testing.assert_allclose(signal, -np.arange(1.0, 9.0))


def test_a_step_stays_between_narrow_bounds():
    tried = []

    def residuals(values, coarse=False):
        tried.append(values["x"])
        return [np.zeros(3)]

    engine = object.__new__(Engine)
    engine.residuals = residuals
    ((signal,),) = engine.signals({"x": 1.0}, [Knob("x", 1.0, low=1.0, high=1.05)])
    assert not signal.any()
    assert 1.0 <= min(tried) < max(tried) <= 1.05


def test_a_slope_is_found_beside_figures_that_no_vehicle_has():
    def residuals(values, coarse=False):
        if values["x"] > 1.0:
            raise InputError("no such vehicle")
        return [-3.0 * values["x"] * np.ones(4)]

    engine = object.__new__(Engine)
    engine.residuals = residuals
    ((signal,),) = engine.signals({"x": 1.0}, [Knob("x", 0.5, sd=0.1)])
    np.testing.assert_allclose(signal, -3.0)


def bumpy(kinks):
    """An engine of a slope, whose signal also holds leaps that lead nowhere."""
    rng = np.random.default_rng(5)
    t = np.linspace(0, 1, 400)
    seen = 2.0 * t + 0.1 * rng.normal(size=len(t))
    engine = object.__new__(Engine)
    engine.problems, engine.tracks = (), [(0, "seen")]
    engine.valid = [np.ones(len(t), dtype=bool)]
    engine.grows_with, engine.edges, engine.least = [[]], [[]], [0.0]
    engine.memory = [None]
    engine.stands, engine.added = [None], {}
    engine.residuals = lambda v, coarse=False: [seen - v["x"] * t]
    leaps = kinks * np.where(np.arange(len(t)) % 2, 1.0, -1.0)
    engine.signals = lambda values, knobs: [[-t + leaps]]
    return engine


@pytest.mark.parametrize("kinks", [0.0, 1.0])
def test_a_way_that_looks_stiffer_than_it_is_is_gone_at_a_stretch(kinks):
    engine = bumpy(kinks)
    start = engine.evaluate({"x": 0.0}, [Knob("x", 0.0)])
    start = engine.evaluate({"x": 0.0}, [Knob("x", 0.0)], start.noise)
    assert descent.improve(engine, start, rounds=3).values["x"] == pytest.approx(
        2.0, abs=0.05
    )


def test_signals_that_are_near_are_not_found_anew_and_others_are():
    engine = bumpy(0.0)
    found = []

    def counted(values, knobs):
        found.append(values["x"])
        return [[-np.linspace(0, 1, 400)]]

    engine.signals = counted
    fit = descent.fit(engine, {"x": 0.0}, [Knob("x", 0.0)])
    assert fit.near
    assert found[-1] == pytest.approx(fit.values["x"], abs=fit.sds()[0])
    found.clear()
    same = descent.improve(
        engine, fit, along=engine.whitened(fit.signals, fit.noise), rounds=9
    )
    assert not found
    assert same.score >= fit.score
    far = engine.at(fit, {"x": 0.0})
    assert not far.near  # what it comes with was found where it no longer is
    back = descent.refit(engine, far)
    assert found
    assert back.values["x"] == pytest.approx(fit.values["x"], abs=0.1 * fit.sds()[0])


def test_a_figure_that_sleeps_is_asked_once_a_fit_and_then_it_may_wake():
    engine, asked = bumpy(0.0), []
    acts = {"x": -np.linspace(0, 1, 400), "y": np.zeros(400)}

    def counted(values, knobs):
        asked.extend(k.key for k in knobs)
        return [[acts[k.key]] for k in knobs]

    engine.signals = counted
    knobs = [Knob("x", 0.0), Knob("y", 0.0, sd=1.0)]
    fit = descent.fit(engine, {"x": 0.0}, knobs)
    assert asked.count("x") > 1
    assert asked.count("y") == 1
    assert fit.asleep == [1]
    assert fit.sds()[1] == pytest.approx(1.0)
    acts["y"] = -np.ones(400)
    woken = descent.refit(engine, fit)
    assert woken.asleep == []
    assert woken.sds()[1] < 0.1


def test_half_a_log_asks_for_no_figures_that_no_vehicle_has():
    engine = bumpy(0.0)
    fit = descent.fit(engine, {"x": 1.0}, [Knob("x", 1.0)])
    half = [np.arange(400) % 2 == 0]
    asked = refitted(engine, fit, half).values["x"]
    middle, plain = fit.values["x"], engine.evaluate
    most = 0.5 * abs(asked - middle)

    def evaluate(values, knobs, noise=None):
        if abs(values["x"] - middle) > most:
            raise InputError("no such vehicle")
        return plain(values, knobs, noise)

    engine.evaluate = evaluate
    less = refitted(engine, fit, half).values["x"]
    assert 0 < abs(less - middle) <= most


THRESHOLD = "effects.speed_dead_zone.threshold_radps"


@pytest.mark.parametrize(
    ("key", "sd", "still"),
    [
        (THRESHOLD, 2.0, True),
        (THRESHOLD, np.inf, False),
        ("effects.copper_loss.phase_resistance_ohm", 1e-3, False),
        ("tyres.radius_m", 1e-3, False),
    ],
)
def test_half_a_log_moves_no_threshold_that_the_file_states(key, sd, still):
    acts = acts_of(load_vehicle("rcc"), key)
    assert is_step(Knob(key, 1.0, sd, acts=acts)) == still


def test_half_a_log_moves_all_others_beside_it(monkeypatch):
    engine = bumpy(0.0)
    knobs = [Knob("x", 1.0, sd=1.0), Knob("y", 0.0, sd=1.0)]
    engine.signals = lambda values, knobs: [[-np.linspace(0, 1, 400)], [np.ones(400)]]
    half = [np.arange(400) % 2 == 0]
    fit = descent.fit(engine, {"x": 1.0, "y": 0.0}, knobs)
    both = refitted(engine, fit, half)
    monkeypatch.setattr(folds, "is_step", lambda knob: knob.key == "y")
    one = refitted(engine, fit, half)
    assert one.values["y"] == fit.values["y"] != both.values["y"]
    assert one.values["x"] != fit.values["x"] and one.knobs == fit.knobs


@pytest.mark.parametrize("seed", range(12))
def test_a_figure_at_its_bound_holds_none_of_the_others_back(seed):
    rng = np.random.default_rng(seed)
    A = rng.normal(size=(9, 5)) * 10.0 ** rng.integers(-3, 4, 5)
    H, g = A.T @ A, A.T @ rng.normal(size=9)
    least, most = np.array([1, 0, 0, 0, 0], bool), np.array([0, 1, 0, 0, 0], bool)
    step = bounded_step(H, g, least, most)
    assert step[0] >= 0 >= step[1]
    unit = 1 / np.sqrt(np.diag(H))
    best = minimize(  # another route: in units of its own curvature, by L-BFGS-B
        lambda x: 0.5 * x @ (H * np.outer(unit, unit)) @ x + (g * unit) @ x,
        np.zeros(5),
        bounds=[(0, None), (None, 0), *[(None, None)] * 3],
        options={"ftol": 1e-15, "gtol": 1e-12, "maxiter": 5000},
    )
    reached = 0.5 * step @ H @ step + g @ step
    assert reached == pytest.approx(best.fun, rel=1e-4)


def test_a_likelihood_bends_by_how_its_residuals_scatter():
    """Of the t-distribution its mean is known in closed form."""
    rng = np.random.default_rng(5)
    scatter = rng.standard_t(FREEDOM, size=400_000)
    assert curvature(weights(scatter)) == pytest.approx(CURVATURE, rel=0.01)
    assert curvature(weights(np.zeros(9))) == pytest.approx(1.0, abs=1e-15)
    one = 1e-3 * rng.normal(size=1000)
    h = 1e-2
    bent = sum(log_density(one + d).sum() * k for d, k in ((h, 1), (0, -2), (-h, 1)))
    W = weights(one)
    assert curvature(W) * W.sum() == pytest.approx(-bent / h**2, rel=1e-3)
