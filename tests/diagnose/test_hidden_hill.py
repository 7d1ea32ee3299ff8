"""A road that climbs evenly for a minute is no noise that remembers."""

from dataclasses import replace

import numpy as np
import pytest

from rcc_sim.definitions.vehicle import load_vehicle
from rcc_sim.diagnose.causes.cause import ENOUGH, PROFILE_ENOUGH
from rcc_sim.diagnose.fitting.descent import of_tolerances
from rcc_sim.diagnose.fitting.engine import Engine
from rcc_sim.diagnose.judge.chances import EVEN, probability
from rcc_sim.diagnose.profiles import hidden_hill as module
from rcc_sim.diagnose.profiles.hidden_hill import HIDES, hidden_hill
from rcc_sim.diagnose.profiles.remainder import remainder
from rcc_sim.diagnose.profiles.varying import as_profile, profile_cause
from rcc_sim.diagnose.residuals.posed import problem_of
from rcc_sim.diagnose.search.taken import acting
from rcc_sim.trace import Trace

CAR = load_vehicle("tesla_model_3")
ROW, FINE = 0.5, 0.1
FLAT, ONE, BOTH = (), (0.03,), (0.03, -0.025)
STARTS, LONG = (2500.0, 6000.0), 1200.0


def road(distance, slopes):
    """Slope over distance: so much from each of the starts on, for a while."""
    slope = np.zeros_like(distance)
    for begin, x in zip(STARTS, slopes, strict=False):
        slope[(distance > begin) & (distance < begin + LONG)] = x
    return slope


def polled(slopes, seed=3, load=0.0):
    """A drive with stops, polled twice a second, on a road that only the drive knew.

    And with a load [W] that it alone knew.
    """
    t = np.arange(0.0, 700.0, FINE)
    v = np.clip(14 + 8 * np.sin(t / 19) + 5 * np.sin(t / 7.3), 0.0, None)
    log = problem_of(Trace({"time_s": t, "speed_mps": v}), CAR)
    seen = log.on_road(log.distance, road(log.distance, slopes)).driven({})
    every, rng = round(ROW / FINE), np.random.default_rng(seed)
    power = seen["battery_power_w"][::every] + load
    power = power + rng.normal(0.0, 300.0, len(power))
    columns = {"time_s": t[::every], "speed_mps": v[::every], "battery_power_w": power}
    return Engine([problem_of(Trace(columns), CAR)])


@pytest.fixture(scope="module")
def both():
    engine = polled(BOTH)
    return engine, of_tolerances(engine)


def test_it_is_found_where_it_does_not_hang_together(both):
    engine, fit = both
    assert as_profile(engine, fit, "road_grade") is None
    (white,), (left,) = fit.noise, fit.residuals
    assert white.foresees(left) > HIDES
    cause, _ = profile_cause(engine, fit, {"road_grade"})
    assert cause.effect == "road_grade" and cause.weighed
    assert cause.sharp > PROFILE_ENOUGH
    assert cause.rival == 0  # going down no drag is in its place: it would push
    x = engine.problems[0].distance
    off = cause.profiles[0].at(x) - road(x, BOTH)
    assert np.sqrt(np.mean(off**2)) < 0.1 * np.sqrt(np.mean(road(x, BOTH) ** 2))


def test_once_it_acts_it_is_sure(both):
    engine, fit = both
    cause = hidden_hill(engine, fit)
    engine, fit, (cause,) = acting(engine, fit, [], cause)
    assert probability(cause, remainder(engine, fit)) > 0.99
    x = engine.problems[0].distance
    assert cause.profiles[0].mean == pytest.approx(road(x, BOTH).mean(), abs=2e-3)


def test_a_climb_alone_may_be_a_drag():
    engine = polled(ONE)
    fit = of_tolerances(engine)
    cause = hidden_hill(engine, fit)
    assert cause.rival == pytest.approx(cause.sharp, abs=ENOUGH)
    engine, fit, (cause,) = acting(engine, fit, [], cause)
    assert probability(cause, remainder(engine, fit)) < EVEN + 0.1


@pytest.mark.parametrize("seed", range(3))
def test_a_flat_road_hides_none(seed):
    engine = polled(FLAT, seed)
    fit = of_tolerances(engine)
    assert hidden_hill(engine, fit) is None
    assert profile_cause(engine, fit, {"road_grade"})[0] is None


def test_what_a_constant_cause_leaves_white_hid_no_hill(both, monkeypatch):
    engine, fit = both
    assert hidden_hill(engine, fit, fit).effect == "road_grade"
    flat = polled(FLAT, load=3000.0)
    fit = of_tolerances(flat)
    (white,), (left,) = fit.noise, fit.residuals
    assert white.foresees(left) > HIDES
    heater = {"effects.auxiliary_load.power_w": 3000.0}
    white = flat.residuals(fit.values | heater)
    explained = replace(fit, residuals=white, noise=flat.learn_noise(white))
    monkeypatch.delattr(module, "courses_of")  # nor is any road tried
    assert hidden_hill(flat, fit, explained) is None
