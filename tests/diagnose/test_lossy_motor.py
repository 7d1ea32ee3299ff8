"""A motor that loses otherwise than its file says is no load, and hides none."""

import re
from dataclasses import replace
from math import inf

import numpy as np
import pytest

from rcc_sim.analyse.logged import Logged, open_log
from rcc_sim.blind.make import make
from rcc_sim.definitions.vehicle import load_vehicle
from rcc_sim.diagnose.causes.strengths import smooth, windows
from rcc_sim.diagnose.fitting import descent
from rcc_sim.diagnose.fitting.engine import Engine
from rcc_sim.diagnose.fitting.knobs import Knob, nuisance_knobs
from rcc_sim.diagnose.noise.whitener import weights
from rcc_sim.diagnose.profiles.beside_losses import (
    constant_nats,
    courses,
)
from rcc_sim.diagnose.profiles.probe import Probe
from rcc_sim.diagnose.profiles.remainder import remainder
from rcc_sim.diagnose.residuals.posed import problem_of
from rcc_sim.diagnose.run import diagnose
from rcc_sim.report.screen import screen
from rcc_sim.trace import Trace
from tests.by_hand import AUX, PER_SPEED, STATED, shaft_torque
from tests.cars import truck

ETA, SD = 0.92, 0.006
LOAD = "effects.auxiliary_load.power_w"
LOSSES = "effects.motor_efficiency.scale"
GEAR = "gear_loss"
CAR = truck(STATED | {"motor_efficiency": {"scale": {"value": ETA, "sd": SD}}})


def efficiency(torque):
    """What it really is: best at 200 N m, as no constant is."""
    return ETA + 0.015 - 0.03 * np.abs(np.abs(torque) - 200.0) / 200.0


def heater(t):
    """On for four minutes of fifteen, and again for three. [W]"""
    return np.where((t > 120) & (t < 360) | (t > 640) & (t < 820), 2500.0, 0.0)


def drive(seed, eta=efficiency, load=heater, *, torque_logged=False, grows_hot=0.0):
    """A quarter of an hour of town and country, by hand."""
    rng = np.random.default_rng(seed)
    t = np.arange(0.0, 900.0, 0.1)
    v = np.clip(11 + 8 * np.sin(t / 23) + 5 * np.sin(t / 7.3), 0.0, None)
    torque = shaft_torque(t, v)
    eta = np.clip(eta(torque) - grows_hot * (1 - np.exp(-t / 300.0)), 0.5, 0.99)
    shaft = torque * v * PER_SPEED
    power = np.where(shaft >= 0, shaft / eta, shaft * eta) + AUX + load(t)
    log = {
        "time_s": t,
        "speed_mps": np.maximum(v + 0.01 * rng.normal(size=len(t)), 0.0),
        "battery_power_w": power + 60.0 * rng.normal(size=len(t)),
    }
    if torque_logged:
        log["motor_torque_nm"] = torque + 2.0 * rng.normal(size=len(t))
    return Trace(log)


@pytest.mark.slow
@pytest.mark.parametrize("seed", [1, 2])
def test_it_is_told_as_what_it_is(seed):
    found = diagnose([Logged(drive(seed, load=np.zeros_like), (), None)], CAR)
    assert not found.asserted
    assert found.status == "unexplained"
    left = found.document()["unexplained"]
    assert (left["acts_as"], left["follows"]) == ("efficiency", "motor_torque_nm")
    at, value, sd = (np.array(left["course"][k]) for k in ("at", "value", "sd"))
    sure = sd < 0.01
    assert sure.sum() > 3
    off = value - (efficiency(at) - ETA)
    assert off[sure] - off[sure].mean() == pytest.approx(0.0 * off[sure], abs=0.012)
    told = " ".join(" ".join(screen(found)).split())
    assert re.search(r"acts as an efficiency \(.*\), follows motor_torque_nm", told)
    assert "effects.motor_efficiency.map" in told


@pytest.mark.slow
@pytest.mark.parametrize("torque_logged", [False, True])
def test_one_that_grows_hot_is_told_by_its_torque_too(torque_logged):
    """What changes so slowly is no noise that remembers, though it passes for one."""
    known = {"torque_logged": torque_logged, "grows_hot": 0.1}
    log = drive(9, lambda torque: ETA + 0 * torque, np.zeros_like, **known)
    found = diagnose([Logged(log, (), None)], CAR)
    assert not found.asserted
    assert found.status == "unexplained"
    left = found.document()["unexplained"]
    assert (left["acts_as"], left["follows"]) == ("efficiency", "time_s")
    at, value = (np.array(left["course"][k]) for k in ("at", "value"))
    assert value[0] - value[-1] == pytest.approx(0.1 * (1 - np.exp(-3.0)), rel=0.25)
    assert np.corrcoef(value, np.exp(-at / 300.0))[0, 1] > 0.95


@pytest.mark.slow
def test_a_heater_beside_it_is_found_and_so_is_what_it_drew():
    log = drive(3)
    found = diagnose([Logged(log, (), None)], CAR)
    (one,) = found.asserted
    assert one.cause.effect == "auxiliary_load"
    assert one.probability > 0.95
    assert (found.left.acts_as, found.left.follows) == ("efficiency", "motor_torque_nm")
    t = log["time_s"]
    drawn = one.cause.profiles[0].at(t)
    assert np.corrcoef(drawn, heater(t))[0, 1] > 0.9
    assert drawn.mean() == pytest.approx(heater(t).mean(), abs=120.0)


@pytest.mark.slow
def test_a_load_that_is_always_on_stands_beside_it():
    found = diagnose([Logged(drive(6, load=lambda t: 900.0 + 0 * t), (), None)], CAR)
    (one,) = found.asserted
    assert one.cause.effect == "auxiliary_load"
    assert one.figures["power_w"].value == pytest.approx(AUX + 900.0, abs=90.0)
    assert found.left.acts_as == "efficiency"


@pytest.mark.slow
def test_a_heater_beside_a_motor_of_its_file_leaves_nothing():
    def steady(torque):
        return np.full_like(torque, ETA)

    found = diagnose([Logged(drive(4, steady), (), None)], CAR)
    assert [a.cause.effect for a in found.asserted] == ["auxiliary_load"]
    assert found.status == "explained"
    assert "course" not in found.document()["unexplained"]


def test_a_course_that_gives_way_is_one_dense_problem_with_the_other():
    """Strengths of a load, those of the efficiency, and all figures, at once."""
    problem = problem_of(drive(5), CAR)
    engine = Engine([problem])
    fit = descent.of_tolerances(engine)
    torque, t = problem.coordinate("motor_torque_nm"), problem.log["time_s"]
    rival = Probe(engine, fit, LOSSES).profile(0, "motor_torque_nm", torque, 8)
    alone = Probe(engine, fit, LOAD)
    beside = fit.beside(courses(engine, fit, [rival]))
    found = alone.by(beside).profile(0, "time_s", t, 12)
    H, B = windows(t, found.knots).toarray(), windows(torque, rival.knots).toarray()
    rows, right = [], []
    signals = zip(alone.signal, Probe(engine, fit, LOSSES).signal, strict=True)
    for i, (load, loss) in enumerate(signals):
        J = np.stack([j[i] for j in fit.signals]).T
        parts = [load[:, None] * H, loss[:, None] * B, J, fit.residuals[i][:, None]]
        both = fit.noise[i](np.hstack(parts))
        W = np.sqrt(weights(both[:, -1]))[:, None]
        rows.append((W * both)[:, :-1])
        right.append((W * both)[:, -1])
    A, r = np.vstack(rows), np.concatenate(right)
    N, b = A.T @ A, -A.T @ r
    k, m = 12, 8
    N[k : k + m, k : k + m] += smooth(m) / rival.rms**2
    sd = fit.prior_sd
    N[k + m :, k + m :] += np.diag(1 / sd**2)
    b[k + m :] -= fit.off / sd**2
    rest = N[:k, k:] @ np.linalg.inv(N[k:, k:])
    M, told = found.normal
    assert pytest.approx(N[:k, :k] - rest @ N[k:, :k], rel=1e-6) == M
    assert told == pytest.approx(
        b[:k] - rest @ b[k:], rel=1e-5, abs=1e-6 * abs(b[:k]).max()
    )
    before = alone.profile(0, "time_s", t, 12)
    assert np.trace(M) < np.trace(before.normal[0])


def test_the_nats_of_a_constant_are_those_by_which_a_fit_without_it_is_worse():
    problem = problem_of(drive(7, load=lambda t: 400.0 + 0 * t), CAR)
    engine = Engine([problem])
    knobs = nuisance_knobs([problem])
    free = [replace(k, sd=inf) if k.key == LOAD else k for k in knobs]
    fit = descent.fit(engine, {}, free)
    less = descent.fit(engine, {}, knobs)
    worse = fit.score - engine.judged(less, fit.noise).score
    nats = constant_nats(engine, fit, fit, [LOAD])
    assert nats > 5.0
    assert nats == pytest.approx(worse, rel=0.1)
    torque = problem.coordinate("motor_torque_nm")
    rival = Probe(engine, fit, LOSSES).profile(0, "motor_torque_nm", torque, 8)
    wide = fit.beside(courses(engine, fit, [rival]))
    assert 0.5 * nats < constant_nats(engine, fit, wide, [LOAD]) < 1.2 * nats


def test_an_efficiency_that_no_file_states_is_probed_from_one_downwards():
    """It cannot be more than one: a step up would be none."""
    car = truck(STATED)
    engine = Engine([problem_of(drive(8), car)])
    fit = descent.of_tolerances(engine)
    probe = Probe(engine, fit, LOSSES)
    (track,) = probe.tracks
    predicted = engine.problems[0].log["battery_power_w"] - fit.residuals[track]
    shaft = predicted - fit.values[LOAD] - fit.values["bias.0.battery_power_w"]
    # P / eta - P or P eta - P: by a step down from one, both change by |P| a unit
    told = probe.signal[track][20:-20]
    evened = np.convolve(np.abs(shaft), np.ones(10) / 10, "same")[20:-20]
    assert np.sqrt(np.mean((told - evened) ** 2)) < 0.03 * evened.max()
    assert told.mean() == pytest.approx(evened.mean(), rel=0.01)


def test_a_motion_that_a_noisy_speed_tells_leaves_no_efficiency(tmp_path):
    """Its noise drives a power high where none is lost, and smoothing evens swings."""
    make(tmp_path / "null", cases=2, seed=700101, kinds=["null"])
    case = tmp_path / "null/c0001"
    car = load_vehicle(case / "vehicle.toml")
    engine = Engine([problem_of(open_log(case / "log.csv.gz", car).log, car)])
    assert engine.problems[0].drive.imposed
    left = remainder(engine, descent.of_tolerances(engine))
    assert all(r.evidence < 15.0 for r in left.rivals if r.acts_as == "efficiency")


@pytest.mark.parametrize("seed", [1, 5])
def test_a_gear_that_is_fitted_leaves_its_noise_to_no_efficiency(seed, tmp_path):
    """It makes more of a noisy speed's torque, and would go where another lets it."""
    out = tmp_path / "gear"
    make(out, cases=1, seed=seed, kinds=["single"], families=["ev"], effects=[GEAR])
    car = load_vehicle(out / "c0000/vehicle.toml")
    problem = problem_of(open_log(out / "c0000/log.csv.gz", car).log, car)
    key = f"effects.{GEAR}.efficiency"
    knobs = [*nuisance_knobs([problem]), Knob(key, 0.9, inf, 0.5, 1.0, 0.002)]
    engine = Engine([problem])
    left = remainder(engine, descent.fit(engine, {key: 0.9}, knobs))
    assert all(r.evidence < 15.0 for r in left.rivals if r.acts_as == "efficiency")
