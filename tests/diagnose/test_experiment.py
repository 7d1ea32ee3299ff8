"""What a proposed run would tell, and that it stays within what the log shows."""

from types import SimpleNamespace

import numpy as np
import pytest

from rcc_sim.diagnose.fitting import descent
from rcc_sim.diagnose.fitting.engine import Engine
from rcc_sim.diagnose.fitting.knobs import Knob, nuisance_knobs
from rcc_sim.diagnose.next_run.bench import Bench, Nats, Pair
from rcc_sim.diagnose.next_run.experiment import (
    Experiment,
    best_of,
    in_turn,
    narrowing,
)
from rcc_sim.diagnose.next_run.limits import limits_of
from rcc_sim.diagnose.next_run.menu import Leg, Run, menu
from rcc_sim.diagnose.residuals.beside_motor import MOTOR, drawn_by_motor
from rcc_sim.diagnose.residuals.posed import problem_of
from rcc_sim.diagnose.residuals.terminals import CURRENT, POWER
from rcc_sim.report.promise import promise
from rcc_sim.trace import Trace
from tests.diagnose.test_ties import logged

ROW = 0.02
GRADE = "effects.road_grade.slope"
ROLL = "effects.rolling_resistance.coefficient"
LOAD = "effects.payload.mass_kg"
ROTOR = "effects.rotor_inertia.inertia_kgm2"


def fitted(engine, key, value):
    knobs = [k for k in nuisance_knobs(engine.problems) if k.key != key]
    return descent.fit(
        engine, {key: value}, [*knobs, Knob(key, value, step=0.02 * abs(value))]
    )


@pytest.fixture(scope="module")
def heavy():
    """Payload against rotor inertia, on a log that only goes straight."""
    car, problem = logged({LOAD: 0.9})
    engine = Engine([problem])
    n = car.drivetrain.gear_ratio.value / car.tyres.radius_m.value
    stated = car.figures()[ROTOR].value
    fit = fitted(engine, LOAD, 0.9)
    return Bench(engine, fit), {
        "payload": fit,
        "rotor_inertia": fitted(engine, ROTOR, stated + 0.9 / n**2),
    }


def told(bench, tied, words):
    run = next(r for r in bench.runs if words in r.do)
    driven = bench.drive(tied)(run)
    assert driven is not None
    return bench.nats(driven, tied).least


def test_of_runs_that_narrow_alike_the_shortest_is_driven():
    class Alike:
        runs = (run("slalom", 80.0), run("stand still", 60.0), run("coast", 70.0))

        def narrows(self, run, fit, keys):
            return {"slalom": 0.571, "stand still": 0.569, "coast": 0.9}[run.do]

    wide = SimpleNamespace(cause=SimpleNamespace(effect="a", keys=("effects.a.x",)))
    found = [e.do for e in narrowing(Alike(), None, wide)]
    assert found == ["coast", "stand still", "slalom"]


def run(do, seconds):
    return Run(do, (Leg(np.array([0.0, seconds]), np.zeros(2), np.zeros(2)),))


def test_every_run_stays_within_the_speed_and_the_cornering_of_the_log():
    car, problem = logged({}, steered=True)
    limits = limits_of(problem)
    for run in menu(problem, limits, ROW):
        for leg in run.legs:
            across = leg.level**2 * np.tan(np.abs(leg.steer)) / car.wheelbase
            assert leg.level.max() <= problem.speed.max() + 1e-9
            assert np.abs(leg.steer).max() <= np.abs(problem.log["steer_cmd_rad"]).max()
            assert across.max() <= 1.6 * limits.lateral
        whole = run.seconds if len(run.legs) == 1 else run.legs[0].time[-1]
        assert run.commands.time[-1] == pytest.approx(whole, abs=1.0)


def test_a_car_whose_motor_brakes_is_not_asked_to_coast():
    car, problem = logged({})
    free = {"effects.regeneration_limit.max_current_a": 0.0}
    coasting = problem_with(car.changed(settings=free), problem)
    words = [r.do for r in menu(coasting, limits_of(coasting), ROW)]
    assert any("coast" in w for w in words)
    braking = problem_with(
        car.changed(settings={"effects.regeneration_limit.max_current_a": 20.0}),
        problem,
    )
    words = [r.do for r in menu(braking, limits_of(braking), ROW)]
    assert not any("coast" in w for w in words)


def problem_with(vehicle, problem):
    from rcc_sim.diagnose.residuals.posed import problem_of

    return problem_of(problem.log, vehicle)


def test_standing_still_tells_nothing_of_masses_and_a_stand_much(heavy):
    bench, tied = heavy
    still = told(bench, tied, "stand still")
    stand = told(bench, tied, "off the ground")
    straight = told(bench, tied, "hold six speeds")
    assert still < 0.01
    assert stand > 5.0
    assert stand > 3 * straight


def test_a_run_tells_a_hypothesis_and_itself_apart_by_nothing(heavy):
    bench, tied = heavy
    same = {"a": tied["payload"], "b": tied["payload"]}
    assert told(bench, same, "speed up") == pytest.approx(0.0, abs=1e-6)


def test_the_best_runs_come_first_and_none_left_out_would_tell_more(heavy):
    bench, tied = heavy
    best = best_of(bench, tied, tuple(tied))
    worth = [round(e.expected_nats.worth, 1) for e in best]
    assert worth == sorted(worth, reverse=True)
    left = [r for r in bench.runs if r.words not in {e.do for e in best}]
    for run in left[:4]:
        driven = bench.drive(tied)(run)
        assert driven is None or bench.nats(driven, tied).worth <= worth[-1] + 0.1
    document = best[0].document()
    assert document["separates"] == ["payload", "rotor_inertia"]
    assert document["expected_nats"]["least"] == best[0].expected_nats.least
    assert document["time_s"] > 0


def test_a_slope_and_a_drag_are_told_apart_by_coming_back():
    _, problem = logged({ROLL: 0.02})
    engine = Engine([problem])
    fit = fitted(engine, ROLL, 0.02)
    tied = {"rolling_resistance": fit, "road_grade": fitted(engine, GRADE, 0.02)}
    bench = Bench(engine, fit)
    back = told(bench, tied, "out and back")
    straight = told(bench, tied, "hold six speeds")
    assert back > 20.0
    assert back > 5 * straight


def test_no_run_is_proposed_for_what_none_would_part(heavy):
    bench, tied = heavy
    same = {"a": tied["payload"], "b": tied["payload"]}
    assert best_of(bench, same, tuple(same)) == []


def proposed(do, time_s, **nats):
    """A run and what it would tell of each pair of effects, a_b=nats."""
    pairs = tuple(Pair(*pair.split("_"), x) for pair, x in nats.items())
    told = Nats(min(nats.values()), pairs)
    return Experiment(do, ("a", "b", "c"), told, time_s, None)


def test_what_one_run_parts_the_next_need_not():
    stand = proposed("stand", 20.0, a_b=0.0, a_c=90.0, b_c=90.0)
    load = proposed("load", 30.0, a_b=0.0, a_c=50.0, b_c=50.0)
    back = proposed("back", 40.0, a_b=9.0, a_c=0.1, b_c=0.1)
    assert [e.do for e in in_turn([stand, load, back])] == ["stand", "back", "load"]
    assert in_turn([load, back])[0] is load


def test_a_run_is_told_with_what_it_does_not_part():
    def told(**nats):
        one = proposed("stand", 20.0, **nats).expected_nats
        pairs = [vars(p) for p in one.pairs]
        expected = {"least": one.least, "pairs": pairs}
        document = {"separates": ["a", "b", "c"], "expected_nats": expected}
        return promise(document, str.upper)

    some = told(a_b=0.02, a_c=90.0, b_c=2000.0)
    assert some == "parts A, B, C by 90 to over 1000 nats, but leaves A and B together"
    assert told(a_b=9.0, a_c=9.0, b_c=9.0) == "parts A, B, C by 9 nats, any two"
    little = told(a_b=0.5, a_c=0.1, b_c=0.1)
    assert little == "parts A, B, C by 0.5 nats: 6 such runs would do"
    narrows = {"separates": ["a"], "expected_nats": {"least": np.log(2), "pairs": []}}
    assert promise(narrows) == "narrows the interval of a to 50 % of its width"


@pytest.mark.parametrize("gone", [(), ("yaw_rate_radps",), ("accel_x_mps2",)])
def test_what_a_runs_motor_asks_of_the_battery_is_taken_from_the_battery(gone):
    """Whichever channels the log lacks that a run would have."""
    car, problem = logged({LOAD: 0.9}, steered=True)
    kept = {c: x for c, x in problem.log.columns.items() if c not in gone}
    engine = Engine([problem_of(Trace(kept, name="log"), car)])
    fit = fitted(engine, LOAD, 0.9)
    bench = Bench(engine, fit)
    leg = bench.leg(bench.runs[0], bench.runs[0].legs[0], fit)
    rows = len(leg.problem.log)
    tracks = [np.full(rows, float(c == MOTOR)) for c in bench.channels]
    told = dict(zip(bench.channels, leg.beside(tracks), strict=True))
    (battery,) = {CURRENT, POWER} & told.keys()
    assert {c for c, x in told.items() if x.any()} == {MOTOR, battery}
    nominal = leg.problem.nominal
    asked = drawn_by_motor(car, nominal, battery)
    np.testing.assert_allclose(told[battery], -asked, rtol=0.1, atol=1e-6)


def test_no_run_asks_for_what_a_shaking_sensor_showed():
    """A wheel counted in steps, an accelerometer that rattles: no driver does that."""
    car, problem = logged({}, steered=True)
    calm = limits_of(problem)
    rng = np.random.default_rng(4)
    shaken = dict(problem.log.columns)
    rows = len(problem.log)
    shaken["speed_mps"] = np.round(shaken["speed_mps"] / 0.15) * 0.15
    shaken["accel_y_mps2"] = shaken["accel_y_mps2"] + 8.0 * rng.standard_normal(rows)
    rough = limits_of(problem_of(Trace(shaken, name="log"), car))
    assert rough.accel < 2.0 * calm.accel
    assert rough.lateral < calm.lateral + 4.0
    rough = limits_of(
        problem_of(Trace(shaken | {"accel_y_mps2": 3 * shaken["accel_y_mps2"]}), car)
    )
    grip = car.tyres.friction_coefficient
    assert rough.lateral <= 9.81 * (grip.value if grip else 1.0)
