"""A driver makes up late for what a bend takes from the speed."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from rcc_sim.analyse.logged import open_log
from rcc_sim.blind.make import make
from rcc_sim.definitions.cycle import parse_cycle
from rcc_sim.definitions.vehicle import load_vehicle
from rcc_sim.diagnose.causes.candidates import candidates_for
from rcc_sim.diagnose.fitting import descent
from rcc_sim.diagnose.fitting.engine import Engine
from rcc_sim.diagnose.fitting.knobs import nuisance_knobs
from rcc_sim.diagnose.judge.mean_slope import mean_slopes
from rcc_sim.diagnose.judge.misread import without_bends
from rcc_sim.diagnose.residuals.posed import problem_of
from rcc_sim.diagnose.residuals.shapes import bends_of
from rcc_sim.simulate.run import simulate
from rcc_sim.trace import Trace
from rcc_sim.units import G
from tests.cars import truck

STEERING = "steer_cmd_rad"


def problems_of(folder, family, cases, hide=()):
    make(folder, cases=cases, kinds=("null",), families=(family,), seed=21)
    found = []
    for case in sorted(p for p in folder.iterdir() if p.is_dir()):
        vehicle = load_vehicle(case / "vehicle.toml")
        log = open_log(case / "log.csv.gz", vehicle, hide=hide).log
        found.append(problem_of(log, vehicle))
    return found


@pytest.mark.slow
@pytest.mark.parametrize("hide", [(), (STEERING,)])
def test_drives_without_a_cause_ask_for_a_share_of_the_drag_of_bends(tmp_path, hide):
    """The plant's driver holds the speed by a loop; the model knows none of it."""
    gained = 0.0
    for problem in problems_of(tmp_path / "ev", "ev", 3, hide):
        assert problem.drive.steered == (not hide)
        engine = Engine([problem])
        knobs = nuisance_knobs([problem])
        with_bends = descent.fit(engine, {}, knobs)
        share = with_bends.values["bias.0.bend"]
        assert -0.2 < share < 1.2
        without = descent.fit(engine, {}, [k for k in knobs if "bend" not in k.key])
        gained += with_bends.score - without.score
    assert gained > 10


def test_by_a_gyro_it_is_the_drag_that_it_is_by_the_steering(tmp_path):
    (steered,) = problems_of(tmp_path / "one", "ev", 1)
    (turned,) = problems_of(tmp_path / "other", "ev", 1, [STEERING])
    assert turned.drive.turns_as_measured
    channel = "battery_current_a"
    one, other = (
        bends_of(p)["bend"][p.channels.index(channel)] for p in (steered, turned)
    )
    assert one.std() > 0.1
    assert np.corrcoef(one, other)[0, 1] > 0.85  # the gyro is noisy
    assert other.std() == pytest.approx(one.std(), rel=0.25)


def test_what_acts_in_cornering_alone_is_asked_for_where_the_steering_is_told(tmp_path):
    cornering = {
        "cg_shift",
        "front_cornering_stiffness",
        "rear_cornering_stiffness",
        "tyre_saturation",
    }
    (steered,) = problems_of(tmp_path / "one", "ev", 1)
    (turned,) = problems_of(tmp_path / "other", "ev", 1, [STEERING])
    asked = [
        cornering & {c.effect for c in candidates_for([p])} for p in (steered, turned)
    ]
    assert asked == [cornering, set()]


def test_a_drive_that_tells_no_turns_has_no_such_share(tmp_path):
    hide = [STEERING, "yaw_rate_radps"]
    (problem,) = problems_of(tmp_path / "ev", "ev", 1, hide)
    assert not bends_of(problem)


def test_a_drive_by_its_own_commands_has_no_such_share(tmp_path):
    (problem,) = problems_of(tmp_path / "rc", "rc", 1)
    assert not bends_of(problem)


def test_what_is_missing_at_first_comes_later_with_the_memory_that_is_stated(tmp_path):
    (problem,) = problems_of(tmp_path / "ev", "ev", 1)
    (bends,) = bends_of(problem).values()
    k = problem.channels.index("battery_current_a")
    steered = problem.drive.commands.steer
    straight = problem.drive.commanded(steer=np.zeros_like(steered))
    on = replace(problem, drive=straight).predict({})["battery_current_a"]
    now = np.nan_to_num(problem.nominal["battery_current_a"] - on)
    late = bends[k] + now
    # a first-order lag: d(late)/dt = (now - late) / 1 s, in rows of 0.1 s
    steps = late[1:] - late[:-1] * np.exp(-0.1)
    assert steps == pytest.approx(now[1:] * (1 - np.exp(-0.1)), abs=2e-3 * now.max())
    # in all it is the same charge, but for what the last second's bend still owes
    assert bends[k].sum() == pytest.approx(0.0, abs=0.01 * now.sum())
    assert not any(
        np.any(x)
        for x, c in zip(bends, problem.channels, strict=True)
        if c in ("yaw_rate_radps", "accel_x_mps2", "accel_y_mps2")
    )


def test_a_log_that_does_not_tell_where_it_turned_says_so_of_drags_alone():
    car = load_vehicle("r1t")
    run = simulate(car, parse_cycle("udds[20:200]"), imposed=True, output_rate=10).trace
    kept = ("time_s", "speed_mps", "battery_voltage_v", "battery_current_a")
    straight = Trace({c: run[c] for c in kept}, name="straight")
    turns = Trace({**straight.columns, "yaw_rate_radps": run["yaw_rate_radps"]})
    drag = SimpleNamespace(effect="copper_loss", tied=("aerodynamic_drag",))
    load = SimpleNamespace(effect="auxiliary_load", tied=())

    def said(log, cause):
        return [f.kind for f in without_bends(problem_of(log, car), [cause])]

    assert said(straight, drag) == ["no_bends"]
    assert not said(straight, load)
    assert not said(turns, drag)
    seen = Trace({**straight.columns, "yaw_rad": run["yaw_rad"]}, name="seen")
    assert said(seen, drag) == ["no_bends"]  # the model drives straight on all the same


@pytest.mark.parametrize(
    ("low", "high", "told"), [(0.001, 0.004, True), (-0.001, 0.004, False)]
)
def test_hills_that_climb_on_the_mean_rest_on_the_rolling_resistance(low, high, told):
    car = load_vehicle("r1t")
    run = simulate(car, parse_cycle("udds[20:100]"), imposed=True, output_rate=5).trace
    kept = ("time_s", "speed_mps", "battery_power_w")
    log = Trace({c: run[c] for c in kept}, name="log")
    heights = Trace({**log.columns, "elevation_m": 0.0 * run["time_s"]}, name="heights")
    slope = SimpleNamespace(value=0.002, low=low, high=high)
    hill = SimpleNamespace(along_way=True, profiles={0: None})
    hills = [SimpleNamespace(cause=hill, figures={"slope": slope})]

    def said(log, place=0):
        return [f.kind for f in mean_slopes(problem_of(log, car), hills, place)]

    assert said(log) == ["mean_slope"] * told
    assert not said(heights)  # how high it climbs is known
    assert not said(log, place=1)  # of that log no hills were found


@pytest.mark.parametrize(
    ("key", "stated", "found"),
    [
        ("effects.rolling_resistance.coefficient", 0.01, 0.02),
        ("effects.drivetrain_friction.torque_nm", 0.0, None),
    ],
)
def test_what_resists_at_any_speed_may_be_a_road_that_climbs(key, stated, found):
    """One percent either way; not where it would end in the clouds, or is felt."""
    car = truck({"rolling_resistance": {"coefficient": 0.01}})
    shaft = car.drivetrain.gear_ratio.value / car.tyres.radius_m.value
    if found is None:
        found = 0.01 * car.body.mass_kg.value * G / shaft
    t = np.arange(0.0, 600.0, 0.5)
    given = {"time_s": t, "speed_mps": 10.0 + np.sin(t), "battery_power_w": 9e3 + t}
    effect, name = key.split(".")[1:]
    cause = SimpleNamespace(effect=effect, along_way=False, keys=(key,), profiles={})

    def said(log, value=found, low=found, high=found):
        one = SimpleNamespace(value=value, low=low, high=high)
        asserted = [SimpleNamespace(cause=cause, figures={name: one})]
        return [f.what for f in mean_slopes(problem_of(log, car), asserted)]

    log = Trace(given, name="log")
    (told,) = said(log)
    assert "climbs by 1 %" in told and effect in told
    (told,) = said(log, 2 * stated - found, -1.0, 2 * stated - found)
    assert "falls by 1 %" in told
    assert not said(log, low=stated - 1.0)  # it may be as stated
    assert not said(Trace(given | {"elevation_m": 0.0 * t}, name="log"))
    assert not said(Trace(given | {"accel_x_mps2": np.cos(t)}, name="log"))
    long = {"time_s": 40.0 * t, "speed_mps": given["speed_mps"]}
    assert not said(Trace(given | long, name="log"))
