"""A battery whose file states no resistance: how much it has is told by its voltage."""

import re
from types import SimpleNamespace

import numpy as np
import pytest

from rcc_sim.analyse.logged import Logged
from rcc_sim.channel import moving_mean
from rcc_sim.definitions.cycle import Cycle, parse_cycle
from rcc_sim.definitions.vehicle import load_vehicle
from rcc_sim.diagnose.causes.candidates import candidates_for
from rcc_sim.diagnose.fitting.engine import Engine
from rcc_sim.diagnose.judge.misread import unjudged
from rcc_sim.diagnose.residuals.posed import problem_of
from rcc_sim.diagnose.residuals.terminals import CURRENT, metered, steady_rows, tells
from rcc_sim.diagnose.run import diagnose
from rcc_sim.diagnose.search.compete import compete
from rcc_sim.errors import InputError
from rcc_sim.simulate.run import LaneChanges, simulate
from rcc_sim.trace import Trace

RESISTANCE = 0.06  # Ω
SPEED_NOISE = 0.02  # m/s; what is driven is known less well than what flows


@pytest.mark.slow
def test_a_resistance_is_found_where_the_current_is_better_known_than_the_drive():
    """Voltage is V_oc - R I to the row; the model's current jitters with the speed."""
    rng = np.random.default_rng(6)
    known = {"battery.open_circuit_voltage_v": 57.0}
    car = load_vehicle("twizy").changed(settings=known)
    t = np.arange(0.0, 400.0, 0.1)
    v = np.clip(7 + 5 * np.sin(t / 7) + 3 * np.sin(t / 2.3), 0.0, None)
    driven = problem_of(Trace({"time_s": t, "speed_mps": v}), car).driven({})
    current = driven["battery_power_w"] / driven["battery_voltage_v"]
    volts = driven["battery_voltage_v"] - RESISTANCE * current
    log = Trace(
        {
            "time_s": t,
            "speed_mps": v + SPEED_NOISE * rng.normal(size=len(t)),
            "battery_voltage_v": volts + 0.02 * rng.normal(size=len(t)),
            "battery_current_a": current + 0.2 * rng.normal(size=len(t)),
        }
    )
    problem = problem_of(log, car)
    found = compete(
        Engine([problem]), candidates_for([problem], ["battery_resistance"])
    )
    (cause,) = found.causes
    assert cause.effect == "battery_resistance"
    value = found.fit.values["effects.battery_resistance.resistance_ohm"]
    assert value == pytest.approx(RESISTANCE, rel=0.03)


def commanded(car, fall, noise, ohm=RESISTANCE):
    """A scaled drive, and what its battery's meters say: V = V_oc(charge) - R I.

    The terminals give the power that the model asks for; V solves V (V_oc - V) = R P.
    """
    rng = np.random.default_rng(11)
    cycle = parse_cycle("us06[0:60]")
    drive = Cycle("drive", cycle.time_s, 0.15 * cycle.speed_mps)
    run = simulate(car, drive, lanes=LaneChanges(every=3.0)).trace
    power, rows = run["battery_power_w"], len(run)
    taken = np.cumsum(power) / np.cumsum(power).max()
    ocv = car.battery.open_circuit_voltage_v.value * (1.01 - fall * taken)
    volts = (ocv + np.sqrt(ocv**2 - 4 * ohm * power)) / 2
    columns = ("time_s", "speed_ref_mps", "steer_cmd_rad")
    log = {c: run[c] for c in columns}
    sds = {"speed_mps": 0.005, "yaw_rate_radps": 0.01, "accel_x_mps2": 0.1}
    log |= {c: run[c] + sd * rng.normal(size=rows) for c, sd in sds.items()}
    meters = {"battery_voltage_v": volts, "battery_current_a": power / volts}
    for (column, x), sd in zip(meters.items(), (0.005, noise), strict=True):
        log[column] = x + sd * rng.normal(size=rows)
    return Trace(log, name="drive")


def told_by(car, log, effect="battery_resistance"):
    """Value of the resistance, and half its 90 % interval, if it is named."""
    problem = problem_of(log, car)
    found = compete(Engine([problem]), candidates_for([problem], [effect]))
    if not found.causes:
        return None
    key = "effects.battery_resistance.resistance_ohm"
    sds = dict(zip((k.key for k in found.fit.knobs), found.fit.sds(), strict=True))
    return found.fit.values[key], 1.645 * sds[key]


@pytest.mark.parametrize("fall", [pytest.param(0.0, marks=pytest.mark.thorough), 0.02])
def test_a_resistance_is_found_beside_a_voltage_that_is_not_known(fall):
    """Neither its level nor how far it falls with the charge: as a real pack's."""
    car = load_vehicle("rcc")
    assert car.battery.open_circuit_voltage_v.sd > 0
    value, half = told_by(car, commanded(car, fall, 0.01))
    assert value == pytest.approx(RESISTANCE, abs=2 * half)
    assert half < 0.15 * RESISTANCE


def test_a_noisy_meter_of_the_current_makes_no_resistance_smaller():
    """Its noise is as large as what is fast in the current: V is regressed on both."""
    car = load_vehicle("rcc")
    level = car.battery.open_circuit_voltage_v.value
    known = car.changed(settings={"battery.open_circuit_voltage_v": 1.01 * level})
    assert known.battery.open_circuit_voltage_v.sd == 0
    value, half = told_by(known, commanded(car, 0.0, 0.15))
    assert value == pytest.approx(RESISTANCE, abs=2 * half)
    assert half < 0.1 * RESISTANCE


def test_where_a_file_states_the_resistance_power_alone_is_judged():
    car = load_vehicle("rcc")
    log = commanded(car, 0.02, 0.01)
    power = log["battery_voltage_v"] * log["battery_current_a"]
    log = Trace(dict(log.columns) | {"battery_power_w": power})
    assert "battery_voltage_v" in problem_of(log, car).channels
    key = "effects.battery_resistance.resistance_ohm"
    told = problem_of(log, car.changed(settings={key: RESISTANCE})).channels
    assert "battery_voltage_v" not in told and "battery_power_w" in told


def test_a_voltage_alone_says_nothing_where_what_it_would_be_at_rest_is_not_known():
    """A pack that discharges looked like a heater."""
    twizy = load_vehicle("twizy")
    level = {"value": 57.0, "sd": 1.0}
    car = twizy.changed(settings={"battery.open_circuit_voltage_v": level})
    t = np.arange(0.0, 300.0, 0.1)
    v = np.clip(7 + 5 * np.sin(t / 7) + 3 * np.sin(t / 2.3), 0.0, None)
    volts = 57.0 - 0.004 * t + 0.02 * np.random.default_rng(1).normal(size=len(t))
    log = Trace({"time_s": t, "speed_mps": v, "battery_voltage_v": volts}, name="log")
    assert problem_of(log, car).channels == ()
    with pytest.raises(InputError, match="no channel by which"):
        diagnose([Logged(log, (), None)], car)


def test_a_voltage_that_is_not_judged_tells_another_resistance_than_is_stated():
    base, cause = load_vehicle("rcc"), SimpleNamespace(effect="payload", tied=())
    log = commanded(base, 0.0, 0.01)

    def stated(ohm, **settings):
        acts = {"battery_resistance": {"resistance_ohm": {"value": ohm, "sd": 0.005}}}
        return base.changed(effects=acts, settings=settings)

    def said(car, *causes, log=log):
        return unjudged(problem_of(log, car), causes)

    assert said(stated(RESISTANCE)) == ()
    assert said(stated(RESISTANCE / 1.4)) == ()  # as it recovers in a minute
    assert [f.kind for f in said(stated(0.0))] == ["resistance"]
    for causes in ((), (cause,)):
        (other,) = said(stated(0.025), *causes)
        assert other.kind == "resistance"
        told = float(re.search(r"falls by ([0-9.]+) V", other.what)[1])
        assert told == pytest.approx(RESISTANCE, rel=0.05)
    known = {"battery.open_circuit_voltage_v": 11.1}
    assert said(stated(0.025, **known)) == ()  # it is judged
    assert said(base) == ()


def test_a_voltage_beside_a_current_that_hardly_changes_tells_nothing():
    car = load_vehicle("rcc").changed(
        effects={"battery_resistance": {"resistance_ohm": RESISTANCE}}
    )
    rng, t = np.random.default_rng(3), np.arange(0.0, 60.0, 0.02)
    even = Trace(
        {
            "time_s": t,
            "speed_mps": 2.0 + 0.01 * rng.normal(size=len(t)),
            "battery_voltage_v": 11.0 + 0.01 * rng.normal(size=len(t)),
            "battery_current_a": 3.0 + 0.2 * rng.normal(size=len(t)),
        }
    )
    cause = SimpleNamespace(effect="payload", tied=())
    (told,) = unjudged(problem_of(even, car), ())
    assert told.kind == "not_judged"
    assert unjudged(problem_of(even, car), (cause,)) == ()


@pytest.mark.parametrize(
    ("step", "off"), [pytest.param(0.05, 0.04, marks=pytest.mark.thorough), (0.1, 0.12)]
)
def test_a_voltage_in_coarse_steps_tells_the_resistance_as_well(step, off):
    """It stands at a step for many rows, which then err alike."""
    car, ohm = load_vehicle("rcc"), 0.3
    log = commanded(car, 0.0, 0.01, ohm)
    rng = np.random.default_rng(7)
    volts = log["battery_voltage_v"] + rng.normal(0, 0.015, len(log))
    log.columns["battery_voltage_v"] = step * np.round(volts / step)
    assert np.mean(np.diff(log["battery_voltage_v"]) == 0) > 0.6
    value, _ = told_by(car, log)
    assert value == pytest.approx(ohm, rel=off)


def test_of_a_stand_its_ends_and_middle_tell():
    volts = np.array([*[12.0] * 20, *[12.1] * 9, *[12.2] * 2, *[12.1] * 30] * 9)
    told = tells(volts)
    assert told[:20].sum() == 7 and told[[0, 2, 10, 17, 19]].all() and not told[3]
    assert told[20:29].sum() == 7 and told[29:31].all()
    smooth = np.linspace(12.0, 11.0, 500)
    assert tells(smooth).all()


def test_a_meter_s_noise_is_known_without_a_stand():
    """What a model's current does not do from row to row, and the readings do."""
    rng = np.random.default_rng(8)
    t = np.arange(0.0, 60.0, 0.01)
    true = 2.0 + np.sin(1.3 * t)
    log = Trace({
        "time_s": t,
        "speed_mps": 2.0 + 0.1 * np.sin(t),
        "battery_current_a": true + rng.normal(0, 0.08, len(t)),
    })  # fmt: skip
    assert metered(log, true) > 0.9
    jitters = true + rng.normal(0, 0.3, len(t))  # as a model on a noisy speed
    assert metered(log, jitters) < 0.15


def test_a_model_that_errs_most_where_most_flows_errs_more_than_the_meter():
    """What truly flowed beside the model, regressed on what the meter reads so."""
    rng = np.random.default_rng(6)
    t = np.arange(0.0, 600.0, 0.1)
    stands = t < 100.0
    errs = np.where(np.sin(t / 7.0) > 0.7, 8.0, 0.3) * ~stands
    beside = errs * rng.normal(size=len(t))
    model = 30.0 * ~stands
    read = model + beside + rng.normal(0.0, 0.5, len(t))
    speed = 12.0 * ~stands
    log = Trace({"time_s": t, "speed_mps": speed, CURRENT: read})
    seen = read - model
    fast, true = (x - moving_mean(x, steady_rows(log)) for x in (seen, beside))
    share = float(fast @ true / (fast @ fast))
    assert 1 - metered(log, model) == pytest.approx(share, abs=0.005)
