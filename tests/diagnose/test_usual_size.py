"""Of causes that a log cannot tell apart, the one of usual size is named."""

import numpy as np
import pytest
from scipy.stats import t as student

from rcc_sim.definitions.vehicle import load_vehicle
from rcc_sim.diagnose.causes.candidates import candidates_for
from rcc_sim.diagnose.causes.cause import Cause
from rcc_sim.diagnose.causes.sought import Search
from rcc_sim.diagnose.fitting import descent
from rcc_sim.diagnose.fitting.engine import Engine
from rcc_sim.diagnose.fitting.knobs import Knob, nuisance_knobs
from rcc_sim.diagnose.judge.ties import settled
from rcc_sim.diagnose.residuals.posed import problem_of
from rcc_sim.simulate.drive import drive_of
from rcc_sim.simulate.replay import replay
from rcc_sim.trace import Trace

PULSE, ZONE, NOISE = 0.375, 0.12, 0.02
DEAD_ZONE = "effects.throttle_dead_zone.threshold"
GEARS = "effects.gear_loss.efficiency"
DAMPING = "effects.drivetrain_damping.damping_nms_per_rad"
EDDY = "effects.iron_loss.eddy_nms_per_rad"
HYSTERESIS = "effects.iron_loss.hysteresis_torque_nm"


def pulses(car):
    """Return a log of pulses of one throttle, and what the car made of it."""
    t = np.arange(0.0, 24.0, 0.05)
    throttle = PULSE * (t % 8.0 > 1.0) * (t % 8.0 < 4.0)
    commands = {"time_s": t, "throttle": throttle, "steer_cmd_rad": np.zeros(len(t))}
    out = replay(car, drive_of(Trace(commands), car, 0.05))
    rng = np.random.default_rng(3)
    speed = out["speed_mps"] + NOISE * rng.standard_normal(len(t))
    return Trace(commands | {"speed_mps": speed}, name="pulses")


@pytest.fixture(scope="module")
def driven():
    """An engine whose log has a dead zone, and fits with it and with its twin."""
    car = load_vehicle("dart_jetracer")
    bare = car.changed(without=("throttle_dead_zone",))
    true = bare.changed(settings={DEAD_ZONE: {"value": ZONE}})
    problem = problem_of(pulses(true), bare)
    return Engine([problem]), candidates_for([problem])


def fitted(engine, key, value, step):
    knobs = [*nuisance_knobs(engine.problems), Knob(key, value, low=0.0, step=step)]
    return descent.fit(engine, {key: value}, knobs)


def test_a_dead_zone_under_one_throttle_is_a_loss_of_the_gears(driven):
    """F is proportional to throttle less the zone: to throttle times a share.

    But for the row in which the throttle rises.
    """
    engine, _ = driven
    zone = engine.residuals({DEAD_ZONE: ZONE})
    gears = engine.residuals({GEARS: 1 - ZONE / PULSE})
    for a, b in zip(zone, gears, strict=True):
        assert np.sqrt(np.mean((a - b) ** 2)) < 0.2 * NOISE


def test_the_one_of_usual_size_is_named_and_the_other_tied(driven):
    engine, able = driven
    fit = fitted(engine, GEARS, 1 - ZONE / PULSE, 0.01)
    found = settled(engine, fit, [Cause("gear_loss", (GEARS,), 200.0)], able)
    (cause,) = found.causes
    assert cause.effect == "throttle_dead_zone"
    assert "gear_loss" in cause.tied


def test_nine_of_ten_are_no_larger_than_is_usual():
    one = Search("effects.gear_loss.efficiency", 1.0, 0.3, 1.0, 0.9, most=0.15)
    assert one.price(1.0) == 0.0
    usual = student.ppf(0.95, 4)
    for times in (0.5, 1.0, 2.5):
        nats = student.logpdf(0, 4) - student.logpdf(times * usual, 4)
        assert one.price(1 - times * 0.15) == pytest.approx(nats, rel=1e-3)
    limit = Search("effects.current_limit.max_current_a", np.inf, 0.0, np.inf, 10.0)
    assert limit.price(30.0) == 0.0


def test_every_search_begins_away_from_where_its_effect_vanishes(driven):
    _, able = driven
    searches = [s for candidate in able for s in candidate.searches if not s.grid]
    assert {s.key.split(".")[1] for s in searches} >= {"throttle_gain", "gear_loss"}
    assert all(s.first != s.neutral for s in searches)
    assert all(s.low <= s.first <= s.high for s in searches)


def test_a_wind_is_no_stronger_for_a_faster_car():
    car = load_vehicle("twizy")
    winds = []
    for top in (3.0, 20.0):
        t = np.arange(0.0, 60.0, 0.1)
        speed = top * np.sin(np.pi * t / 60) ** 2
        log = Trace({"time_s": t, "speed_mps": speed, "battery_power_w": 50 * speed**2})
        (wind,) = (
            search
            for candidate in candidates_for([problem_of(log, car)])
            for search in candidate.searches
            if candidate.effect == "headwind"
        )
        winds.append(wind.most)
    assert winds == [5.0, 5.0]


def test_a_stated_figure_is_seldom_farther_off_than_its_file_says():
    one = Search(DAMPING, 2e-5, 0.0, 1e-4, 1e-6, most=4e-5, sd=1e-6)
    assert one.price(2e-5) == 0.0
    for sds in (1.0, 3.0, 15.0):
        nats = student.logpdf(0, 4) - student.logpdf(sds, 4)
        assert one.price(2e-5 - sds * 1e-6) == pytest.approx(nats, rel=1e-6)


@pytest.mark.parametrize("stated", [True, False])
def test_a_loss_that_no_file_states_goes_before_a_stated_one_that_is_far_off(stated):
    """Iron's eddy loss and damping are one torque, k ω."""
    key, eddy = DAMPING if stated else EDDY, 1e-5
    car = load_vehicle("rcc").changed(without=("drivetrain_damping",))
    if stated:
        car = car.changed(settings={DAMPING: {"value": eddy, "sd": 0.05 * eddy}})
    t = np.arange(0.0, 40.0, 0.05)
    v = np.interp(t, [0, 2, 8, 10, 14, 16, 24, 30], [0, 3, 3, 5, 5, 2, 6, 0])
    commands = {"time_s": t, "speed_ref_mps": v, "steer_cmd_rad": np.zeros(len(t))}
    true = car.changed(settings={EDDY: eddy, HYSTERESIS: 0.0})
    out = replay(true, drive_of(Trace(commands), car, 0.05))
    rng = np.random.default_rng(5)
    noise = {"speed_mps": 0.003, "motor_current_a": 0.2, "battery_current_a": 0.05}
    seen = {c: out[c] + sd * rng.standard_normal(len(t)) for c, sd in noise.items()}
    problem = problem_of(Trace(commands | seen, name="log"), car)
    engine, able = Engine([problem]), candidates_for([problem])
    value = 2 * eddy if stated else eddy
    knobs = [k for k in nuisance_knobs([problem]) if k.key != key]
    knobs.append(Knob(key, value, low=0.0, step=0.02 * eddy))
    fit = descent.fit(engine, {key: value}, knobs)
    found = settled(engine, fit, [Cause(key.split(".")[1], (key,), 200.0)], able)
    (cause,) = found.causes
    first, tied = ("iron_loss", "drivetrain_damping")[:: 1 if stated else -1]
    assert cause.effect == first
    assert tied in cause.tied
