"""A cause stands beside something unknown if it is needed beside that, too."""

from dataclasses import replace

import numpy as np
import pytest

from rcc_sim.definitions.vehicle import load_vehicle
from rcc_sim.diagnose.causes.cause import ENOUGH, Cause, left_by_stronger
from rcc_sim.diagnose.fitting import descent
from rcc_sim.diagnose.fitting.engine import Engine
from rcc_sim.diagnose.fitting.knobs import Knob, nuisance_knobs
from rcc_sim.diagnose.judge import stands
from rcc_sim.diagnose.judge.chances import probability
from rcc_sim.diagnose.profiles.remainder import LATERAL_ENOUGH, Remainder, remainder
from rcc_sim.diagnose.residuals.posed import problem_of
from rcc_sim.diagnose.search.compete import Explanation
from rcc_sim.diagnose.search.winner import shares_of
from rcc_sim.trace import Trace
from tests.diagnose.test_ties import logged
from tests.winding import seen_of, winding

CAR = load_vehicle("r1t")
FRICTION = "effects.drivetrain_friction.torque_nm"
SIZES = {"battery_power_w": 200.0, "motor_torque_nm": 1.0}


@pytest.mark.parametrize(
    ("gain", "left", "beside", "stays"),
    [
        (100.0, 19.0, 0.0, True),  # small beside the cause
        (39.0, 25.0, 50.0, True),
        (39.0, 25.0, ENOUGH - 0.1, False),  # does as well for both
        (39.0, 39.5, 50.0, False),  # likelier than the cause
        (120.0, 41.0, 90.0, False),  # no cornering a little off
    ],
)
def test_what_is_real_withdraws_a_cause_that_is_not_needed_beside_it(
    monkeypatch, gain, left, beside, stays
):
    monkeypatch.setattr(stands, "nats_beside", lambda *_: beside)
    grip = Remainder(left, "grip", "time_s", [], shares=np.ones(1))
    assert left > LATERAL_ENOUGH  # it is real
    cause = Cause("rear_cornering_stiffness", ("x",), gain, shares=np.ones(1))
    whole = replace(grip, rivals=(grip,))
    assert stands.outlives(None, cause, whole, None) is stays


@pytest.mark.parametrize(
    ("strong", "where", "stays"),
    [
        (5000.0, [1.0, 0.0], True),  # a play that is not quite as modelled leaves 65
        (5000.0, [0.0, 1.0], False),  # but not elsewhere
        (400.0, [1.0, 0.0], False),
    ],
)
def test_what_a_stronger_cause_may_leave_does_not_speak_against_a_weaker(
    monkeypatch, strong, where, stays
):
    monkeypatch.setattr(stands, "nats_beside", lambda *_: 91.0)
    grip = Remainder(65.0, "grip", "time_s", [], shares=np.array([1.0, 0.0]))
    left = replace(grip, rivals=(grip,))
    play = Cause("steering_backlash", ("x",), strong / 5, shares=np.array(where))
    play = replace(play, sharpened=5.0)
    soft = Cause("front_cornering_stiffness", ("y",), 46.0, shares=grip.shares)
    both = [play, soft]
    assert left_by_stronger(play, both) == 0
    assert stands.outlives(None, play, left, None, left_by_stronger(play, both))
    spared = left_by_stronger(soft, both)
    assert stands.outlives(None, soft, left, None, spared) is stays
    assert (probability(soft, left, spared=spared) > 0.9) is stays


@pytest.mark.parametrize(
    ("gain", "eased", "beside", "stays"),
    [
        (25.0, 0.0, 20.0, True),
        (25.0, 0.0, 9.0, False),
        (31.0, 0.0, 9.0, True),
        (25.0, 6.0, 9.0, True),  # no drag lets stated figures go back
    ],
)
def test_of_what_chance_may_leave_as_much_may_be_left_without_the_cause(
    monkeypatch, gain, eased, beside, stays
):
    monkeypatch.setattr(stands, "nats_beside", lambda *_: beside)
    drag = Remainder(30.0, "drag", "time_s", [], shares=np.ones(1))
    cause = Cause("payload", ("x",), gain, eased, shares=np.ones(1))
    assert stands.outlives(None, cause, replace(drag, rivals=(drag,)), None) is stays


def beside(torque, patch):
    """Nats of a friction beside a drag that changes, on a road with a soft stretch."""
    rng = np.random.default_rng(8)
    given = winding()
    free = problem_of(Trace(given), CAR)
    hard, soft = (free.driven({FRICTION: x}) for x in (torque, torque + patch))
    there = abs(given["time_s"] - 150.0) < 15.0
    noisy = seen_of(hard, soft, there, SIZES, rng)
    engine = Engine([problem_of(Trace(given | noisy), CAR)])
    knobs = [*nuisance_knobs(engine.problems), Knob(FRICTION, 0.0, low=0.0, high=50.0)]
    fit = descent.fit(engine, {FRICTION: torque + 0.1 * patch}, knobs)
    shares = shares_of(engine, fit, (FRICTION,), fit.noise)
    cause = Cause("drivetrain_friction", (FRICTION,), 100.0, shares=shares)
    return stands.nats_beside(engine, cause, remainder(engine, fit), fit)


@pytest.mark.slow
def test_a_friction_is_needed_beside_a_drag_that_changes_if_it_acts():
    assert beside(torque=4.0, patch=0.0) > ENOUGH
    assert beside(torque=4.0, patch=1.0) > ENOUGH
    assert beside(torque=0.0, patch=4.0) < 0.2 * ENOUGH


def test_a_cause_whose_figure_is_held_keeps_it_where_another_is_withdrawn():
    """A period of sampling has no slope along which it could be fitted."""
    period, load = "effects.reference_sampling.period_s", "effects.payload.mass_kg"
    _, problem = logged({period: 0.2, load: 0.5})
    engine = Engine([problem])
    knobs = nuisance_knobs([problem])
    null = descent.fit(engine, {}, knobs)
    fit = descent.fit(engine, {period: 0.2, load: 0.5}, [*knobs, Knob(load, 0.0)])
    causes = [
        Cause("payload", (load,), 90.0),
        Cause("reference_sampling", (period,), 80),
    ]
    found = Explanation(engine, null, fit, tuple(causes), {})
    all_of = stands.Standing(engine, fit, causes, remainder(engine, fit))
    now = stands.only(engine, found, all_of, causes[1:])
    assert now.fit.values[period] == 0.2
    assert load not in now.fit.values
    assert now.fit.score > null.score + ENOUGH
