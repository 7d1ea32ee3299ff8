"""Logs without a speed, without steering, or of a moment alone."""

import numpy as np
import pytest

from rcc_sim.analyse.gap import gap
from rcc_sim.analyse.logged import Logged, open_log
from rcc_sim.diagnose.causes.candidates import candidates_for
from rcc_sim.diagnose.fitting.engine import Engine
from rcc_sim.diagnose.fitting.knobs import tolerance_knobs
from rcc_sim.diagnose.residuals.problem import Problem
from rcc_sim.diagnose.run import diagnose
from rcc_sim.errors import InputError
from rcc_sim.simulate.drive import drive_of
from rcc_sim.simulate.replay import replay
from rcc_sim.trace import Trace
from tests.cars import car

LAG = 0.06  # s
NOISE = {"yaw_rate_radps": 0.02, "accel_y_mps2": 0.2, "motor_current_a": 0.3}


@pytest.fixture(scope="module")
def columns():
    t = np.arange(0, 40, 0.02)
    ref = np.clip(t, 0.0, 2.5)
    steer = np.where(t > 4, 0.15 * np.sign(np.sin(1.7 * t)), 0.0)
    asked = {"time_s": t, "speed_ref_mps": ref, "steer_cmd_rad": steer}
    blank = Trace(asked | {"speed_mps": np.full(len(t), np.nan)})
    true = car({"steering_lag": {"time_constant_s": LAG}})
    out = replay(true, drive_of(blank, true))
    rng = np.random.default_rng(4)
    seen = {c: out[c] + sd * rng.normal(size=len(t)) for c, sd in NOISE.items()}
    return asked | seen, out["speed_mps"]


def test_cornering_is_judged_where_the_model_rolls(columns):
    log, true = Trace(columns[0]), columns[1]
    problem = Problem(car(), log, drive_of(log, car()))
    np.testing.assert_allclose(problem.speed, true, atol=0.05)
    assert problem.distance[-1] == pytest.approx(
        np.trapezoid(true, log["time_s"]), rel=0.01
    )
    judged = dict(zip(problem.channels, problem.judged, strict=True))
    assert judged["yaw_rate_radps"][true > 2.0].all()


@pytest.mark.slow
def test_an_effect_of_cornering_is_named_without_a_speed(columns, tmp_path):
    path, log = tmp_path / "drive.csv", columns[0]
    rows = np.column_stack(list(log.values()))
    np.savetxt(path, rows, delimiter=",", header=",".join(log), comments="")
    found = diagnose([open_log(path, car())], car())
    (one,) = found.asserted
    assert one.cause.effect == "steering_lag"
    assert one.figures["time_constant_s"].value == pytest.approx(LAG, abs=0.01)


def test_a_log_too_short_for_its_noise_is_refused(columns, tmp_path):
    path, log = tmp_path / "drive.csv", columns[0]
    rows = np.column_stack(list(log.values()))[:220]  # 4.4 s
    np.savetxt(path, rows, delimiter=",", header=",".join(log), comments="")
    with pytest.raises(InputError, match=r"drive.csv: lasts 4.38 s: too short"):
        diagnose([open_log(path, car())], car())


def test_yaw_inertia_is_no_cause_where_the_yaw_rate_is_imposed(columns):
    log = {k: x for k, x in columns[0].items() if k != "speed_ref_mps"}
    log["speed_mps"] = columns[1]
    steered = Trace(log)
    plain = Trace({k: x for k, x in log.items() if k != "steer_cmd_rad"})
    vague = car(body__yaw_inertia_kgm2={"value": 0.0382, "sd": 0.004})
    for trace, told in ((steered, True), (plain, False)):
        problem = Problem(vague, trace, drive_of(trace, vague))
        assert problem.drive.imposed
        able = {c.effect for c in candidates_for([problem])}
        knobs = {k.key for k in tolerance_knobs([problem])}
        assert ("yaw_inertia" in able) is told
        assert ("body.yaw_inertia_kgm2" in knobs) is told


def test_a_tolerance_stays_where_its_effect_may_be(columns):
    vague = car({"steering_offset": {"angle_rad": {"value": 0.0, "sd": 0.2}}})
    log = Trace(columns[0])
    found = tolerance_knobs([Problem(vague, log, drive_of(log, vague))])
    (knob,) = (k for k in found if k.key == "effects.steering_offset.angle_rad")
    assert (knob.low, knob.high) == vague.known["steering_offset"].params[0].bounds


def test_a_run_that_went_astray_is_the_least_likely(columns):
    log = Trace(columns[0])
    engine = Engine([Problem(car(), log, drive_of(log, car()))])
    sound = engine.residuals({})
    noise = engine.learn_noise(sound)
    astray = [np.full_like(e, np.nan) for e in sound]
    assert engine.loglik(astray, noise) < engine.loglik(sound, noise)


def test_what_turned_unsteered_turns_as_its_gyro_shows(columns):
    """Driven straight on, something would seem to drag in bends: two thirds of it."""
    log = Trace(columns[0] | {"speed_mps": columns[1]}, name="drive")
    blind = Trace({c: x for c, x in log.columns.items() if c != "steer_cmd_rad"})
    straight = Trace({**blind.columns, "yaw_rate_radps": np.zeros(len(blind))})
    work, true = [], car({"steering_lag": {"time_constant_s": LAG}})
    for one, vehicle in ((log, true), (blind, car()), (straight, car())):
        drive = drive_of(one, vehicle)
        assert not drive.imposed
        run = replay(vehicle, drive)
        power = run["motor_torque_nm"] * run["motor_speed_radps"]
        work.append(np.trapezoid(power, log["time_s"]))
    assert work[1] == pytest.approx(work[0], rel=0.04)
    assert work[2] < 0.4 * work[0]
    assert diagnose([Logged(blind, (), None)], car()).asserted == ()


def test_a_circle_that_a_gyro_shows_takes_what_its_tyres_lose():
    """F² v / (2 C) of either axle, F its share of m v r; no steering is told."""
    t = np.arange(0, 20, 0.02)
    v, r, vehicle = 3.0, 0.5, car()
    asked = {"time_s": t, "speed_ref_mps": np.full(len(t), v)}
    rows = {**asked, "speed_mps": np.full(len(t), v)}
    power = []
    for turns in (r, 0.0):
        log = Trace({**rows, "yaw_rate_radps": np.full(len(t), turns)})
        run = replay(vehicle, drive_of(log, vehicle))
        shaft = (run["motor_torque_nm"] * run["motor_speed_radps"])[-100:]
        power.append(shaft.mean())
        assert run["yaw_rate_radps"][-1] == pytest.approx(turns, rel=1e-6)
    l_F, l_R, C_F, C_R = (
        vehicle.figures()[key].value
        for key in (
            *("body.cg_to_front_axle_m", "body.cg_to_rear_axle_m"),
            "tyres.front_cornering_stiffness_n_per_rad",
            "tyres.rear_cornering_stiffness_n_per_rad",
        )
    )
    F = vehicle.body.mass_kg.value * v * r / (l_F + l_R)
    lost = ((F * l_R) ** 2 / C_F + (F * l_F) ** 2 / C_R) * v / 2
    assert power[0] - power[1] == pytest.approx(lost, rel=0.02)


def test_a_gyro_that_comes_late_drives_it_to_the_last_row(columns):
    late = car({"sensor_delay": {"yaw_rate_delay_s": 0.3}})
    log = Trace(columns[0] | {"speed_mps": columns[1]}, name="drive")
    blind = Trace({c: x for c, x in log.columns.items() if c != "steer_cmd_rad"})
    run = replay(late, drive_of(blind, late))
    assert np.isfinite(run["motor_torque_nm"]).all()


def test_by_what_a_log_is_driven_is_told(columns):
    whole = columns[0] | {"speed_mps": columns[1]}
    unsteered = {c: x for c, x in whole.items() if c != "steer_cmd_rad"}
    unasked = {c: x for c, x in unsteered.items() if c != "speed_ref_mps"}
    notes = [
        gap(Logged(Trace(x, name="drive"), (), None), car()).notes
        for x in (whole, unsteered, unasked)
    ]
    driven = ("no steering is told", "no commands that the controller obeys")
    told = [[n for n in of if n.startswith(driven)] for of in notes]
    turns = "no steering is told: the model turns as yaw_rate_radps shows"
    imposed = "no commands that the controller obeys: the motion is imposed"
    assert told == [[], [turns], [imposed, turns]]
