"""Commands that are logged as they are sent, and hold until the next, are no delay."""

from dataclasses import replace
from functools import partial
from math import inf

import numpy as np
import pytest
from scipy.ndimage import uniform_filter1d

from rcc_sim.analyse.logged import Logged
from rcc_sim.definitions.cycle import Cycle, parse_cycle
from rcc_sim.definitions.vehicle import load_vehicle
from rcc_sim.diagnose import run
from rcc_sim.diagnose.causes.candidates import candidates_for
from rcc_sim.diagnose.causes.cause import Cause
from rcc_sim.diagnose.fitting import descent
from rcc_sim.diagnose.fitting.engine import Engine
from rcc_sim.diagnose.fitting.knobs import Knob
from rcc_sim.diagnose.judge.misread import until_their_rows
from rcc_sim.diagnose.residuals.posed import problem_of
from rcc_sim.diagnose.run import diagnose
from rcc_sim.diagnose.search.as_sent import Likelier, freed, spares
from rcc_sim.diagnose.search.compete import Explanation, compete
from rcc_sim.diagnose.search.ways import every_way, holds_more, with_drives
from rcc_sim.physics.tables import BEFORE, LINE, SINCE
from rcc_sim.similitude.cycles import scale_cycle
from rcc_sim.simulate.drive import drive_of, holds
from rcc_sim.simulate.replay import replay
from rcc_sim.simulate.run import LaneChanges, simulate
from rcc_sim.trace import Trace

CAR, TICK = load_vehicle("rcc"), 0.001
COMMANDS = ("speed_ref_mps", "steer_cmd_rad")
NOISE = {
    "speed_mps": 0.005,
    "yaw_rate_radps": 0.01,
    "accel_y_mps2": 0.08,
    "motor_current_a": 0.15,
}


FLOWS = ("accel_y_mps2", "motor_current_a")


@pytest.fixture(scope="module")
def asked():
    """What a scaled drive with lane changes asks for, tick by tick."""
    cycle = scale_cycle(parse_cycle("udds[20:95]"), to=CAR, of=load_vehicle("r1t"))
    lanes = LaneChanges(6.0)
    run = simulate(CAR, cycle.cycle, lanes=lanes, output_rate=1 / TICK).trace
    return {c: run[c] for c in ("time_s", *COMMANDS)}


def sent(asked, row, delay=0.0, *, hold=True, means=None, lag=0.0, motor=0.0):
    """A log of commands that were sent at each of its rows, and held; or every tick.

    Its flows are samples if they held, and means since the row before if not, unless
    it is told.
    """
    means = not hold if means is None else means
    every = round(row / TICK)
    once = every if hold else 1
    held = {c: np.repeat(asked[c][::once], once) for c in COMMANDS}
    n = min(len(x) for x in (asked["time_s"], *held.values()))
    time = asked["time_s"][:n]
    acts = {"steering_delay": {"delay_s": delay}} if delay else {}
    acts |= {"steering_lag": {"time_constant_s": lag}} if lag else {}
    acts |= {"motor_lag": {"time_constant_s": motor}} if motor else {}
    true = CAR.changed(effects=acts)
    columns = {"time_s": time, **{c: held[c][:n] for c in COMMANDS}}
    seen = replay(true, drive_of(Trace(columns), true))
    rng = np.random.default_rng(3)
    columns = {name: x[::every] for name, x in columns.items()}
    for name, sd in NOISE.items():
        mean = uniform_filter1d(seen[name], every, origin=every // 2 - 1)
        x = (mean if name in FLOWS and means else seen[name])[::every]
        columns[name] = x + rng.normal(0, sd, len(x))
    columns["speed_mps"] = np.abs(columns["speed_mps"])
    return Logged(Trace(columns, name="sent"), (), None)


def stepped(asked, row, delay=0.0):
    """A log of a loop that steps the car, and then writes what it did and what it sees.

    Its commands were in force until their row.
    """
    columns = dict(sent(asked, row, delay).log.columns)
    columns |= {c: np.append(columns[c][0], columns[c][:-1]) for c in COMMANDS}
    return Logged(Trace(columns, name="stepped"), (), None)


def test_of_each_cause_it_is_asked_how_commands_run(asked):
    """One asks of the reference alone, the other of the steering, whatever is first."""
    problem = problem_of(sent(asked, 0.02, 0.08, motor=0.15).log, CAR)
    able = candidates_for([problem], ["motor_lag", "steering_delay"])
    seen = []

    class Asks:
        def __call__(self, engine, fit, before):
            seen.append(freed(fit, before))

        def sooner(self, engine, null, most):
            assert most > 100.0  # of the better of the two

    compete(Engine([problem]), able, asked=Asks())
    assert sorted(seen, key=str) == [{"motor_lag"}, {"steering_delay"}]


@pytest.mark.parametrize("row", [0.02, pytest.param(0.05, marks=pytest.mark.thorough)])
def test_they_are_no_delay(asked, row):
    log = sent(asked, row)
    assert not any(holds(log.log[c]) for c in COMMANDS)  # each row has another value
    assert diagnose([log], CAR).asserted == ()


def test_nor_those_in_force_until_their_row_tyres_or_an_inertia(asked):
    rivals = ("yaw_inertia", "rear_cornering_stiffness", "cg_shift", "speed_loop")
    found = diagnose([stepped(asked, 0.02)], CAR, candidates=(*STEERING, *rivals))
    assert found.asserted == ()
    assert found.found.engine.problems[0].drive.held == (BEFORE, BEFORE)
    told = [f.channel for f in found.gap.findings if f.kind == "until"]
    assert told == list(COMMANDS)


def test_what_is_left_of_cornering_makes_that_of_a_steering_doubtful(asked):
    problem = problem_of(stepped(asked, 0.05).log, CAR)
    later = replace(problem, drive=replace(problem.drive, held=(BEFORE, BEFORE)))

    def told(bends):
        return [f.what.split()[0] for f in until_their_rows(later, bends=bends)]

    assert told(False) == ["was", "was"]
    assert told(True) == ["was", "may"]
    assert not until_their_rows(problem, bends=True)


STEERING = ("steering_delay", "steering_lag", "tyre_relaxation", "sensor_delay")


DRIVEN = CAR.changed(
    settings={"controller.mode": "torque", "controller.max_torque_nm": 0.5}
)


@pytest.mark.parametrize(("row", "car"), [(0.02, CAR), (0.05, DRIVEN)])
def test_nor_where_the_measured_motion_drives_a_car_that_is_steered_by_them(
    asked, row, car
):
    """At 20 Hz an accelerometer is asked besides whether what it shows is a mean."""
    columns = dict(sent(asked, row).log.columns)
    del columns["speed_ref_mps"]
    log = Logged(Trace(columns, name="imposed"), (), None)
    found = diagnose([log], car, candidates=STEERING)
    assert found.asserted == ()
    assert found.found.engine.problems[0].drive.held[1] == SINCE


@pytest.mark.parametrize(("means", "window"), [(True, inf), (False, 0.001)])
def test_hard_cornering_tells_means_from_samples(means, window):
    """5 ms of 11 m/s² that come and go move a centre of gravity by two sds."""
    t = np.arange(0.0, 60.0, TICK)
    weave = np.sin(1.9 * t) + np.sin(4.1 * t + 1.0)
    speed = np.clip(t, 0.0, 4.0) + np.sin(0.5 * t) * (t > 4.0)
    asked = {"time_s": t, "speed_ref_mps": speed, "steer_cmd_rad": 0.08 * weave}
    columns = dict(sent(asked, 0.02, means=means).log.columns)
    del columns["speed_ref_mps"]
    log = Logged(Trace(columns, name="weaves"), (), None)
    found = diagnose([log], CAR, candidates=("cg_shift", "steering_gain"))
    assert found.asserted == ()
    assert not means or not found.moved
    assert found.found.engine.problems[0].drive.window == window


def test_nor_where_a_stated_lag_that_is_too_long_hides_that_they_hold(asked):
    stated = {"steering_lag": {"time_constant_s": {"value": 0.06, "sd": 0.01}}}
    log = sent(asked, 0.02, lag=0.048)
    found = diagnose([log], CAR.changed(effects=stated), candidates=STEERING)
    assert found.asserted == ()


def test_a_throttle_that_holds_is_told_so_and_hides_no_gain():
    """Sent twenty times a second, to a car that gives more force than its map says."""
    car = load_vehicle("dart_jetracer")
    time = np.arange(0.0, 40.0, TICK)
    wish = 0.25 + 0.1 * np.sin(0.9 * time) + 0.06 * np.sin(9.1 * time)
    throttle = np.repeat(wish[::50], 50)
    true = car.changed(effects={"throttle_gain": {"gain": 1.5}})
    asked = Trace({"time_s": time, "throttle": throttle})
    rng = np.random.default_rng(2)
    seen = replay(true, drive_of(asked, true))
    columns = {"time_s": time[::50], "throttle": throttle[::50]}
    for name, sd in {"speed_mps": 0.004, "accel_x_mps2": 0.05}.items():
        columns[name] = seen[name][::50] + rng.normal(0.0, sd, len(columns["time_s"]))
    columns["speed_mps"] = np.abs(columns["speed_mps"])
    log = Logged(Trace(columns, name="throttle"), (), None)
    rivals = ("actuation_delay", "motor_lag", "throttle_gain", "payload")
    found = diagnose([log], car, candidates=rivals)
    (one,) = found.asserted
    assert one.cause.effect == "throttle_gain"
    assert one.figures["gain"].value == pytest.approx(1.5, rel=0.03)
    assert found.found.engine.problems[0].drive.held[0] == SINCE


def test_a_delay_beyond_a_row_is_one(asked):
    rivals = ("steering_delay", "steering_lag", "steering_gain", "sensor_delay")
    log = sent(asked, 0.02, delay=0.08)
    (one,) = diagnose([log], CAR, candidates=rivals).asserted
    assert one.cause.effect == "steering_delay"
    assert one.figures["delay_s"].value == pytest.approx(0.08, abs=0.004)


def test_a_delay_of_commands_in_force_until_their_row_is_one(asked):
    rivals = ("steering_delay", "steering_lag", "longitudinal_slip", "speed_loop")
    found = diagnose([stepped(asked, 0.02, 0.06)], CAR, candidates=rivals)
    (one,) = found.asserted
    assert one.cause.effect == "steering_delay"
    assert one.figures["delay_s"].value == pytest.approx(0.06, abs=0.003)
    assert found.found.engine.problems[0].drive.held == (BEFORE, BEFORE)


def test_logs_that_tolerances_alone_make_likelier_so_are_searched_so_at_once(asked):
    engine = Engine([problem_of(sent(asked, 0.02).log, CAR)])
    drive = replace(engine.problems[0].drive, held=(SINCE, SINCE))
    held, null = with_drives(engine, [drive]), descent.of_tolerances(engine)

    def sooner(most, by):
        return Likelier([held], [held], (held, by)).sooner(engine, null, most)

    assert sooner(0.0, 1e4)(engine).problems[0].drive.held == (SINCE, SINCE)
    assert sooner(4e3, 1e4) is None  # the best of causes does more here
    assert sooner(0.0, 0.0) is None  # nor does the vehicle as stated like it


def test_with_commands_that_hold_it_is_asked_what_is_averaged(asked):
    """Accelerations that are means come half a row late, as the steering would."""
    engine = Engine([problem_of(sent(asked, 0.02, means=True).log, CAR)])
    ways = map(partial(with_drives, engine), every_way(engine.problems))
    drives = [w.problems[0].drive for w in ways if holds_more(w, engine, {1})]
    assert {d.held for d in drives} == {(LINE, SINCE)}
    assert {(d.window, d.felt) for d in drives} == {
        (0.01, inf),
        (inf, inf),
        (inf, 0.01),
    }


def test_a_way_is_explained_anew_where_a_cause_is_idle_there_and_not_for_one_in_need(
    asked,
):
    engine = Engine([problem_of(sent(asked, 0.02, delay=0.08).log, CAR)])
    null = descent.of_tolerances(engine)
    keys = ("effects.steering_delay.delay_s", "effects.steering_gain.gain")
    free = [Knob(keys[0], 0.0, inf, 0.0, 0.3), Knob(keys[1], 1.0, inf, 0.5, 2.0)]
    fit = descent.fit(engine, null.values | {keys[0]: 0.08}, [*null.knobs, *free])
    late, more = (Cause(key.split(".")[1], (key,), 60.0) for key in keys)

    def spared(*causes):
        return spares(engine, fit, Explanation(engine, null, fit, causes, {}))

    assert not spared(late)
    assert spared(more)
    assert spared(late, more)


STRAIGHT = (False, False)


@pytest.mark.parametrize(
    ("hold", "delay", "way"), [(True, 0.0, (True, True)), (False, 0.07, STRAIGHT)]
)
def test_with_its_first_cause_a_log_is_asked_whether_commands_hold(
    asked, monkeypatch, hold, delay, way
):
    """A delay seems to hold them, and commands that hold seem late."""
    ways = []

    def watched(logs, *args):
        found = compete(logs, *args)
        ways.append([e.problems[0].drive.held for e in (logs, found.engine)])
        return found

    monkeypatch.setattr(run, "compete", watched)
    rivals = ("steering_delay", "steering_lag", "steering_gain", "sensor_delay")
    log = sent(asked, 0.02, delay=delay, hold=hold)
    causes = diagnose([log], CAR, candidates=rivals).asserted
    told = [(a.cause.effect, a.figures["delay_s"].value) for a in causes]
    assert told == [("steering_delay", pytest.approx(delay, abs=0.004))] * (delay > 0)
    assert ways[0] == [STRAIGHT, way]


CLOCK = 10
"""Ticks between two of the car's own readings of its reference."""


@pytest.fixture(scope="module")
def quick():
    """What a drive that speeds up and slows down all the time asks for."""
    rng = np.random.default_rng(5)
    time = np.cumsum(rng.uniform(1.5, 3.5, 14))
    speed = np.where(np.arange(14) % 2, rng.uniform(2.5, 4.0, 14), 1.0)
    cycle = Cycle("quick", np.append(0.0, time), np.append(0.0, speed))
    lanes = LaneChanges(8.0)
    run = simulate(CAR, cycle, lanes=lanes, output_rate=1 / TICK).trace
    return {c: run[c] for c in ("time_s", *COMMANDS)}


def logged_while_it_acts(asked, seed, **effects):
    """A log by a clock of its own, half a reading later: each row shows what acts."""
    every = np.arange(len(asked["time_s"])) // CLOCK * CLOCK
    acts = {**asked, "speed_ref_mps": asked["speed_ref_mps"][every]}
    true = CAR.changed(effects=effects)
    seen = replay(true, drive_of(Trace(acts), true))
    rng = np.random.default_rng(seed)
    rows = np.arange(CLOCK // 2, len(every) - CLOCK, CLOCK) + rng.integers(-1, 2)
    columns = {name: x[rows] for name, x in acts.items()}
    for name, sd in NOISE.items():
        mean = uniform_filter1d(seen[name], CLOCK, origin=CLOCK // 2 - 1)
        x = (mean if name in FLOWS else seen[name])[rows]
        columns[name] = x + rng.normal(0, sd, len(x))
    columns["speed_mps"] = np.abs(columns["speed_mps"])
    return Logged(Trace(columns, name="acts"), (), None)


RIVALS = ("motor_lag", "gear_loss", "speed_loop", "payload", "speed_sensor_scale")


def test_a_reference_that_acts_before_its_row_is_no_cause(quick):
    log, *again = (logged_while_it_acts(quick, seed) for seed in range(3))
    repeats = [one.log for one in again]
    assert diagnose([log], CAR, repeats=repeats).asserted == ()


def test_nor_does_it_make_a_lag_another_one(quick):
    log = logged_while_it_acts(quick, 3, motor_lag={"time_constant_s": 0.04})
    (one,) = diagnose([log], CAR, candidates=RIVALS).asserted
    assert one.cause.effect == "motor_lag"
    assert one.figures["time_constant_s"].value == pytest.approx(0.04, abs=0.003)


def test_without_a_cause_commands_that_hold_are_told_so_as_well(asked):
    found = diagnose([sent(asked, 0.02)], CAR, candidates=("payload", "speed_loop"))
    assert found.asserted == ()
    assert found.found.engine.problems[0].drive.held == (SINCE, SINCE)
