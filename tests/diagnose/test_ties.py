"""Ties are told by what the hypotheses predict, not by their names."""

from dataclasses import replace

import numpy as np
import pytest

from rcc_sim.definitions.vehicle import load_vehicle
from rcc_sim.diagnose.causes.candidates import Candidate, candidates_for
from rcc_sim.diagnose.causes.cause import Cause
from rcc_sim.diagnose.fitting import descent
from rcc_sim.diagnose.fitting.engine import Engine
from rcc_sim.diagnose.fitting.knobs import Knob, nuisance_knobs
from rcc_sim.diagnose.fitting.without import without
from rcc_sim.diagnose.judge import ties
from rcc_sim.diagnose.judge.ties import (
    Rival,
    apart,
    better,
    least_squares,
    near,
    rivals_of,
    settled,
    with_ties,
)
from rcc_sim.diagnose.noise.whitener import CURVATURE
from rcc_sim.diagnose.residuals.posed import problem_of
from rcc_sim.diagnose.search.screen import Screened
from rcc_sim.simulate.drive import drive_of
from rcc_sim.simulate.replay import replay
from rcc_sim.trace import Trace

SEEN = (
    *("speed_mps", "yaw_rate_radps", "accel_x_mps2", "accel_y_mps2"),
    *("motor_current_a", "battery_voltage_v", "battery_current_a"),
)
NOISE = (0.0026, 0.015, 0.25, 0.25, 0.26, 0.015, 0.06)
DRAG = ("rolling_resistance", "drivetrain_friction", "aerodynamic_drag")
KEY = "effects.rolling_resistance.coefficient"


def logged(true, *, steered=False, seed=1):
    """Return the shipped car and a log of it, with noise, where ``true`` acts."""
    car = load_vehicle("rcc")
    car = car.changed(settings={"body.mass_kg": {"value": 3.78, "sd": 0.02}})
    rng = np.random.default_rng(seed)
    t = np.arange(0.0, 40.0, 0.02)
    v = np.interp(
        t, [0, 2, 5, 10, 14, 20, 22, 30, 34, 40], [0, 0, 4, 4, 2, 2, 5, 5, 0, 0]
    )
    steer = 0.05 * np.sin(2.0 * t) * (v > 1) if steered else np.zeros(len(t))
    commands = {"time_s": t, "speed_ref_mps": v, "steer_cmd_rad": steer}
    out = replay(car.changed(settings=true), drive_of(Trace(commands), car, 0.02))
    seen = {
        c: out[c] + sd * rng.standard_normal(len(t))
        for c, sd in zip(SEEN, NOISE, strict=True)
    }
    return car, problem_of(Trace(commands | seen, name="log"), car)


@pytest.fixture(scope="module")
def rolling():
    """An engine whose log rolls too hard, and the fit that says so."""
    _, problem = logged({KEY: 0.02})
    engine = Engine([problem])
    able = candidates_for([problem])
    knobs = [*nuisance_knobs([problem]), Knob(KEY, 0.02, low=0.0, step=4e-4)]
    return engine, descent.fit(engine, {KEY: 0.02}, knobs), able


def test_two_constant_drags_on_a_level_road_are_tied_and_air_is_not(rolling):
    engine, fit, able = rolling
    some = [c for c in able if c.effect in DRAG[1:]]
    assert "aerodynamic_drag" in {c.effect for c in some}
    found = {r.effect: r for r in rivals_of(engine, fit, [KEY], some)}
    assert found["drivetrain_friction"].is_tied
    bare = without(engine, fit, [KEY])
    assert found["drivetrain_friction"].apart < 0.02 * (fit.score - bare.score)
    air = found.get("aerodynamic_drag")
    assert air is None or not air.is_tied


def test_what_did_as_well_before_is_fitted_whatever_a_screen_makes_of_it(rolling):
    engine, fit, able = rolling
    some = [c for c in able if c.effect == "auxiliary_load"]
    assert rivals_of(engine, fit, [KEY], some) == []
    (load,) = rivals_of(engine, fit, [KEY], some, ["auxiliary_load"])
    assert load.behind > 40
    assert not load.is_tied


def test_a_cause_in_the_wrong_place_gives_way_to_the_one_that_does_better(rolling):
    engine, fit, able = rolling
    key = "effects.aerodynamic_drag.drag_area_m2"
    knobs = [k for k in fit.knobs if k.key != KEY] + [
        Knob(key, 0.05, low=0.0, step=1e-3)
    ]
    values = {k: x for k, x in fit.values.items() if k != KEY}
    wrong = descent.fit(engine, values | {key: 0.05}, knobs)
    cause = Cause("aerodynamic_drag", (key,), 50.0, 0.0)
    some = [c for c in able if c.effect in DRAG]
    now = settled(engine, wrong, [cause], some)
    assert now.causes[0].effect in DRAG[:2]
    assert set(now.causes[0].tied) == set(DRAG[:2]) - {now.causes[0].effect}
    assert now.fit.score > wrong.score


@pytest.mark.parametrize(
    ("where", "behind", "stays"),
    [([1.0, 0.0], 5.0, True), ([0.0, 1.0], 5.0, False), ([0.0, 1.0], -9.0, True)],
)
def test_what_gains_as_much_elsewhere_is_no_tie(
    monkeypatch, rolling, where, behind, stays
):
    """A steering late by half a row was tied with a payload."""
    engine, fit, able = rolling
    other = next(c for c in able if c.effect == "auxiliary_load")
    key = other.searches[0].key
    there = replace(fit, values=fit.values | {key: 1.0})
    rival = Rival(Screened(other, 5.0, {key: 1.0}), there, behind, 9.0, 1.0)
    monkeypatch.setattr(ties, "rivals_of", lambda *_: [rival])
    shares = {KEY: [1.0, 0.0], key: where}
    monkeypatch.setattr(
        ties, "shares_of", lambda engine, fit, keys, noise: np.array(shares[keys[0]])
    )
    cause = Cause(KEY.split(".")[1], (KEY,), 50.0)
    found = ties.in_place(engine, fit, cause, [cause], able)
    assert [r.effect for r in found] == ["auxiliary_load"] * stays


def test_a_fit_is_not_told_apart_from_itself(rolling):
    engine, fit, _ = rolling
    assert apart(engine, fit, fit) == pytest.approx(0.0, abs=1e-6)


def test_a_difference_that_nothing_can_take_up_is_worth_half_its_square(rolling):
    engine, fit, _ = rolling
    other = replace(
        fit,
        residuals=[e + np.where(np.arange(len(e)) % 2, 1, -1) * 0.05 * w.sigma * w.scale
                   for e, w in zip(fit.residuals, fit.noise, strict=True)],
    )  # fmt: skip
    pairs = zip(other.residuals, fit.residuals, strict=True)
    d = engine.white([a - b for a, b in pairs], fit.noise)
    whole = 0.5 * CURVATURE * float(d @ d)
    assert 0.9 * whole < apart(engine, fit, other) <= whole + 1e-9


def test_least_squares_is_numpys_with_the_priors_as_rows():
    rng = np.random.default_rng(2)
    A, d = rng.standard_normal((50, 3)), rng.standard_normal(50)
    sd, off = np.array([0.5, np.inf, 2.0]), np.array([0.3, 0.0, -0.2])
    rows = np.vstack([A, np.diag(1 / sd)])
    y = np.concatenate([d, off])
    x, *_ = np.linalg.lstsq(rows, -y, rcond=None)
    assert least_squares(A, d, sd, off) == pytest.approx(
        0.5 * float(((y + rows @ x) ** 2).sum()), rel=1e-6
    )


@pytest.mark.parametrize(
    ("behind", "scatter", "apart", "tied"),
    [(2.0, 0.5, 9.0, True), (20.0, 1.0, 2.0, True), (10.0, 8.0, 9.0, True),
     (10.0, 2.0, 9.0, False)],
)  # fmt: skip
def test_a_tie_is_near_here_or_would_be_near_in_any_such_log(
    behind, scatter, apart, tied
):
    one = Rival(None, None, behind, scatter, apart)  # type: ignore[arg-type]
    assert one.is_tied == tied


@pytest.mark.parametrize(("apart", "tied"), [(15.0, True), (60.0, False)])
def test_what_is_farther_from_a_cause_than_nothing_is_does_not_tie(apart, tied):
    one = Rival(None, None, 20.0, 18.0, apart, absent=30.0)  # type: ignore[arg-type]
    assert one.is_tied == tied


def test_what_came_near_another_cause_is_tried_in_the_place_of_each():
    """Of three of which any two do as well, the third came near the second alone."""
    gained = {"friction_brake": 238.0, "gear_loss": 209.0, "current_sensor_scale": 9.0}
    first = Cause("friction_brake", ("a",), 238.0, screened=gained)
    second = Cause(
        "gear_loss", ("b",), 29.0, screened={"gear_loss": 29.0, "payload": 27.0}
    )
    profile = Cause("auxiliary_load", ("c",), 90.0)
    able = [Candidate(e, ()) for e in (*gained, "payload", "motor_lag")]

    def near_to(cause, *beside):
        return {c.effect for c in near(cause, [cause, *beside], able)}

    assert near_to(first) == {"gear_loss", "payload", "motor_lag"}  # not seen then
    seen = replace(first, screened=gained | {"payload": 3.0, "motor_lag": 0.0})
    assert near_to(seen) == {"gear_loss"}
    assert near_to(seen, second, profile) == {"payload"}
    assert near_to(second, seen, profile) == {
        "current_sensor_scale",
        "payload",
        "motor_lag",
    }


def test_a_cause_that_varies_keeps_what_it_was_said_to_be():
    cause = Cause("road_grade", ("effects.road_grade.slope",), 90.0, 3.0, ("headwind",))
    assert with_ties([cause], {}) == [cause]


@pytest.mark.parametrize(("effect", "behind", "named"), [
    ("rolling_resistance", -1.0, False), ("rolling_resistance", -4.0, True),
    ("iron_loss", -1.0, True), ("iron_loss", 3.0, True), ("iron_loss", 6.0, False),
])  # fmt: skip
def test_a_tied_rival_takes_the_place_of_what_is_less_likely_alone(
    effect, behind, named
):
    """Within the nats by which two alike may differ, the first that was found stays."""
    other = Screened(Candidate("drivetrain_friction", ()), 0.0)
    rival = Rival(other, None, behind, 9.0, 1.0)  # type: ignore[arg-type]
    assert rival.is_tied
    assert (better(Cause(effect, ("x",), 90.0), [rival]) is rival) is named
