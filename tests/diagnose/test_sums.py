"""An effect that sums up others, and figures of it that are found one by one."""

from math import inf

import numpy as np
import pytest

from rcc_sim.analyse.logged import open_log
from rcc_sim.definitions.vehicle import load_vehicle
from rcc_sim.diagnose.causes.candidates import candidates_for
from rcc_sim.diagnose.causes.cause import ENOUGH, Cause
from rcc_sim.diagnose.causes.sums import with_all_figures
from rcc_sim.diagnose.fitting import descent
from rcc_sim.diagnose.fitting.engine import Engine
from rcc_sim.diagnose.fitting.knobs import Knob
from rcc_sim.diagnose.residuals.posed import problem_of
from rcc_sim.diagnose.residuals.problem import Problem
from rcc_sim.diagnose.run import diagnose
from rcc_sim.diagnose.search.look import free_of
from rcc_sim.diagnose.search.taken import taken_in
from rcc_sim.simulate.drive import drive_of
from rcc_sim.simulate.replay import replay
from rcc_sim.trace import Trace

A, B, C = 1.266, 0.7393, -0.1123  # N, N s/m, N s²/m², of the file


@pytest.fixture(scope="module")
def car():
    return load_vehicle("dart_jetracer")


@pytest.fixture(scope="module")
def log(car):
    """The car as it is, by its throttle: pulses from standstill, coasting between."""
    rng = np.random.default_rng(4)
    t = np.arange(0, 60, 0.02)
    throttle = np.where(t % 6 < 2.5, 0.25 + 0.02 * np.floor(t / 6), 0.0)
    blank = np.zeros(len(t))
    trace = Trace(
        {"time_s": t, "throttle": throttle, "speed_mps": blank, "steer_cmd_rad": blank}
    )
    out = replay(car, drive_of(trace, car))
    speed = out["speed_mps"] + 0.01 * rng.normal(size=len(t))
    return Trace(trace.columns | {"speed_mps": np.round(speed, 3)}, name="pulses")


def test_the_sum_that_was_withheld_stands_for_its_parts(car, log):
    bare = car.changed(without=("road_load",))
    problem = Problem(bare, log, drive_of(log, bare))
    named = {c.effect for c in candidates_for([problem], withheld=["road_load"])}
    assert "road_load" in named
    parts = {"rolling_resistance", "drivetrain_friction", "drivetrain_damping"}
    assert not named & (parts | {"aerodynamic_drag", "iron_loss"})
    free = {c.effect for c in candidates_for([problem])}
    assert parts < free
    assert "road_load" not in free


def test_an_efficiency_is_sought_where_a_file_states_no_loss_that_it_sums():
    car = load_vehicle("f1tenth")
    assert "copper_loss" in car.effects
    t = np.arange(0.0, 20.0, 0.1)
    seen = {"time_s": t, "speed_mps": 5 + t / 4, "battery_power_w": 1e3 * t}

    def sought(vehicle):
        log = Trace(seen)
        problem = Problem(vehicle, log, drive_of(log, vehicle))
        return {c.effect for c in candidates_for([problem])}

    assert "motor_efficiency" not in sought(car)
    assert "motor_efficiency" in sought(car.changed(without=("copper_loss",)))


def found_in(car, log, rows, path):
    rows = np.column_stack([x[:rows] for x in log.columns.values()])
    np.savetxt(path, rows, delimiter=",", header=",".join(log.columns), comments="")
    bare = car.changed(without=("road_load",))
    found = diagnose([open_log(path, bare)], bare, withheld=["road_load"])
    (one,) = found.asserted
    assert one.cause.effect == "road_load"
    return one.figures


def force(figures, v):
    return sum(e.value * v ** "abc".index(name[0]) for name, e in figures.items())


@pytest.mark.slow
@pytest.mark.parametrize(
    ("seconds", "within"),
    [pytest.param(60, 0.1, marks=pytest.mark.thorough), (25, 0.25)],
)
def test_a_withheld_road_load_is_found_with_all_its_figures(
    car, log, tmp_path, seconds, within
):
    """However little of it the log tells apart, the force is right at every speed."""
    figures = found_in(car, log, seconds * 50, tmp_path / "pulses.csv")
    assert set(figures) == {"a_n", "b_n_s_per_m", "c_n_s2_per_m2"}
    for v in (0.5, 1.0, 1.5):
        true = A + B * v + C * v**2
        assert force(figures, v) == pytest.approx(true, rel=within)
    found = [figures[k] for k in sorted(figures)]
    held = [e.low <= true <= e.high for e, true in zip(found, (A, B, C), strict=True)]
    assert sum(held) >= 2  # of three intervals of 90 %


def starts(plant, levels, on):
    """A plant by its throttle: pushed at some levels one after another, each let go."""
    t = np.arange(0, len(levels) * (on + 4), 0.1)
    level = np.array(levels)[(t / (on + 4)).astype(int)]
    throttle = np.where(t % (on + 4) < on, level, 0.0)
    blank = np.zeros(len(t))
    trace = Trace(
        {"time_s": t, "throttle": throttle, "speed_mps": blank, "steer_cmd_rad": blank}
    )
    speed = replay(plant, drive_of(trace, plant))["speed_mps"]
    noise = 0.01 * np.random.default_rng(1).normal(size=len(t)) * (speed > 0.02)
    speed = np.round(np.maximum(speed + noise, 0.0), 3)
    return Trace(trace.columns | {"speed_mps": speed}, name="starts")


def test_a_sum_is_begun_anew_where_a_car_that_moves_off_holds_it_up(car):
    """A car that is not quite its file: from viscous friction no step leads on."""
    plant = car.changed(
        settings={"controller.force_scale": 0.78},
        effects={
            "throttle_dead_zone": {"threshold": 0.14},
            "longitudinal_slip": {"stiffness_n": 100.0},
            "wheel_radius": {"scale": 0.92},
            "motor_lag": {"time_constant_s": 0.03},
        },
    )
    logs = [starts(plant, np.arange(0.1, 0.195, 0.005), 8)]
    logs += [starts(plant, [x], 6) for x in (0.25, 0.3, 0.35, 0.4, 0.5, 0.6, 0.8)]
    bare = car.changed(without=("road_load",))
    engine = Engine([problem_of(log, bare) for log in logs])
    able = candidates_for(engine.problems, withheld=["road_load"])
    (own,) = [c for c in able if c.effect == "road_load"]
    free = [Knob(s.key, s.neutral, inf, s.low, s.high) for s in own.searches]
    keys = [k.key for k in free]
    null = descent.of_tolerances(engine)
    viscous = null.values | dict(zip(keys, (0.0, 1.5, -0.2), strict=True))
    stuck = descent.fit(engine, viscous, [*null.knobs, *free])
    one = Cause("road_load", tuple(keys), 60.0)
    (same,), fit = with_all_figures(engine, stuck, [one], able)
    assert fit.score > stuck.score + ENOUGH
    assert set(same.keys) == set(keys)
    a, b, c = (fit.values[key] for key in keys)
    for v in (0.5, 1.5, 3.0):
        assert a + b * v + c * v**2 == pytest.approx(A + B * v + C * v**2, rel=0.05)
    causes = [one, Cause("payload", (), 40.0)]  # the sum is not the newest
    assert with_all_figures(engine, stuck, causes, able)[1] is stuck


def test_more_figures_of_an_effect_join_those_it_has():
    one = Cause("road_load", ("b",), 60.0)
    other = Cause("payload", ("m",), 40.0)
    more = taken_in([one, other], Cause("road_load", ("a",), 30.0))
    assert [(c.effect, c.keys, c.gain) for c in more] == [
        ("payload", ("m",), 40.0),
        ("road_load", ("b", "a"), 90.0),
    ]


def test_a_figure_that_was_found_is_not_looked_for_again(car, log):
    bare = car.changed(without=("road_load",))
    problem = Problem(bare, log, drive_of(log, bare))
    able = candidates_for([problem], withheld=["road_load"])
    taken = Cause("road_load", ("effects.road_load.b_n_s_per_m",), 60.0)
    (rest,) = [c for c in free_of(able, [taken]) if c.effect == "road_load"]
    assert {s.key.rpartition(".")[2] for s in rest.searches} == {
        "a_n",
        "c_n_s2_per_m2",
    }
    single = Cause("payload", ("effects.payload.mass_kg",), 60.0)
    assert "payload" not in {c.effect for c in free_of(able, [single])}
