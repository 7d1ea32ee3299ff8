"""Short hills are told from a rough road, in windows no shorter than they need be.

And give back what a cause that is found later makes of their force.
"""

from dataclasses import replace
from math import inf

import numpy as np
import pytest

from rcc_sim.definitions.vehicle import load_vehicle
from rcc_sim.diagnose.causes.candidates import candidates_for
from rcc_sim.diagnose.causes.cause import ENOUGH, Cause
from rcc_sim.diagnose.causes.profile import with_acting
from rcc_sim.diagnose.fitting import descent
from rcc_sim.diagnose.fitting.engine import Engine
from rcc_sim.diagnose.fitting.knobs import Knob, nuisance_knobs
from rcc_sim.diagnose.fitting.without import refitted_without
from rcc_sim.diagnose.profiles.varying import (
    FINER,
    SHORTEST,
    anew,
    finer,
    profile_cause,
    with_another,
    with_profile,
)
from rcc_sim.diagnose.residuals.posed import problem_of
from rcc_sim.diagnose.search.give_way import beside_courses, hills_beside_all
from rcc_sim.diagnose.search.leave_out import without_idle
from rcc_sim.diagnose.search.look import Look
from rcc_sim.diagnose.search.refine import Refined
from rcc_sim.diagnose.search.screen import Screened
from rcc_sim.trace import Trace

SIZES = {"battery_power_w": 300.0, "accel_x_mps2": 0.05, "motor_torque_nm": 2.0}


def hills(s, rng):
    """A slope over distance that no few windows resolve."""
    phase = rng.uniform(0, 6, 3)[:, None]
    waves = np.sin(s / np.array([[93.0], [129.0], [171.0]]) + phase)
    return 0.012 * waves.sum(axis=0)


def drive(seconds, slope_of, **effects):
    """A drive at 10 Hz, noisy, on a road whose slope only the drive knew.

    And by a car with effects of which only the drive knew.
    """
    rng = np.random.default_rng(12)
    t = np.arange(0.0, seconds, 0.1)
    v = 15 + 6 * np.sin(t / 17) + 3 * np.sin(t / 5.3)
    car = load_vehicle("tesla_model_3")
    flat = problem_of(Trace({"time_s": t, "speed_mps": v}), car)
    road = flat.on_road(flat.distance, slope_of(flat.distance, rng))
    seen = replace(road, vehicle=car.changed(effects=effects)).driven({})
    noisy = {c: seen[c] + size * rng.normal(size=len(t)) for c, size in SIZES.items()}
    return problem_of(Trace({"time_s": t, "speed_mps": v} | noisy), car)


def cause_of(problem):
    engine = Engine([problem])
    fit = descent.fit(engine, {}, nuisance_knobs([problem]))
    return profile_cause(engine, fit, {"road_grade"})[0]


@pytest.mark.slow
def test_hills_that_hang_together_in_many_windows_alone_are_found():
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


LOSS, LESS = "effects.gear_loss.efficiency", 0.93


@pytest.fixture(scope="module")
def over_hills():
    """Logs, a fit and the hill in it, of a car whose gears lose more than is known."""
    engine = Engine([drive(600.0, hills, gear_loss={"efficiency": LESS})])
    fit = descent.fit(engine, {}, nuisance_knobs(engine.problems))
    hill, _ = profile_cause(engine, fit, {"road_grade"})
    return with_profile(engine, fit, hill)


def beside(engine, fit, key, start, low, high, step):
    """The fit with one figure more."""
    knob = Knob(key, engine.stated(key), inf, low, high, step)
    return descent.fit(engine, fit.values | {key: start}, [*fit.knobs, knob])


def test_a_hill_gives_back_what_it_held_of_a_loss_that_is_found_later(over_hills):
    engine, fit, hill = over_hills
    fit = beside(engine, fit, LOSS, 0.95, 0.0, 1.0, 1e-3)
    assert fit.values[LOSS] - LESS > 5 * fit.sd(LOSS)  # climbs are charged with it
    _, found, _ = anew(engine, fit, hill)
    assert found.score > fit.score + 18
    assert found.values[LOSS] == pytest.approx(LESS, abs=2 * found.sd(LOSS))
    assert found.sd(LOSS) < 0.002


def nats_of_another(engine, fit, cause):
    return with_another(engine, fit, cause).score - fit.score


def test_what_acts_gains_more_where_the_hill_gives_way_and_what_does_not_nothing(
    over_hills,
):
    engine, fit, hill = over_hills
    alone = nats_of_another(engine, fit, hill)
    fixed = beside(engine, fit, LOSS, 0.95, 0.0, 1.0, 1e-3)
    assert nats_of_another(engine, fixed, hill) - alone > ENOUGH
    heavier = beside(engine, fit, "effects.payload.mass_kg", 50.0, 0.0, 500.0, 5.0)
    assert abs(nats_of_another(engine, heavier, hill) - alone) < ENOUGH / 4


def test_what_a_hill_displaced_is_tried_beside_it_and_what_does_not_act_is_none(
    over_hills,
):
    engine, fit, hill = over_hills
    able = candidates_for(engine.problems, ["gear_loss", "payload"])
    look = Look(fit, [], [], None, None)

    tried = {"gear_loss": {LOSS: 0.95}, "payload": {"effects.payload.mass_kg": 50.0}}

    def best_of(*effects):
        found = [
            Screened(c, 50.0, tried[c.effect]) for c in able if c.effect in effects
        ]
        gone = [Refined(one, fit, 50.0, 50.0) for one in found]
        best = beside_courses(engine, look, [hill], gone).best
        return best and best.screened.candidate.effect

    assert best_of("gear_loss", "payload") == "gear_loss"
    assert best_of("payload") is None
    assert best_of() is None


DRAG = "effects.road_load.a_n"


def tilted(over_hills, tilt):
    """The same hill, found too steep by as much throughout, as beside another drag."""
    engine, fit, hill = over_hills
    level = with_acting(engine, {i: p.reversed for i, p in hill.profiles.items()})
    hill = replace(hill, profiles={i: p.raised(tilt) for i, p in hill.profiles.items()})
    return with_acting(level, hill.profiles), fit, hill


def test_a_hill_is_found_beside_all_that_was_found(over_hills):
    right = over_hills[2].profiles[0].mean
    engine, fit, hill = tilted(over_hills, 0.003)
    assert hill.profiles[0].mean - right == pytest.approx(0.003)
    pulled = descent.refit(engine, fit)
    _, found, (cause,) = hills_beside_all(engine, pulled, [hill])
    assert cause.profiles[0].mean == pytest.approx(right, abs=0.0006)
    assert found.prior > pulled.prior


@pytest.mark.parametrize(
    ("tilt", "key", "start", "idle"),
    [(0.008, DRAG, 100.0, True), (0.0, LOSS, 0.95, False)],
)
def test_a_drag_is_idle_where_a_hill_found_without_it_does_as_well(
    over_hills, tilt, key, start, idle
):
    engine, fit, hill = tilted(over_hills, tilt)
    free = Knob(key, start, inf, 0.0, 1e3, 1e-3)
    knobs = [*(k for k in fit.knobs if k.key != key), free]
    fit = descent.fit(engine, fit.values | {key: start}, knobs)
    less = refitted_without(engine, fit, [key])
    assert fit.score - less.score > ENOUGH  # while the hill is held
    one = Cause(key.split(".")[1], (key,), 50.0)
    _, left, _ = without_idle(engine, [hill, one], fit)
    assert [c.effect for c in left] == ["road_grade"] + [one.effect] * (not idle)
