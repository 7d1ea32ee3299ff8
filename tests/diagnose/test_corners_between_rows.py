"""A log at 1 Hz whose speed has its corners between the rows: they are no cause."""

import numpy as np
import pytest
from scipy.interpolate import PchipInterpolator

from rcc_sim.analyse.logged import Logged
from rcc_sim.definitions.vehicle import load_vehicle
from rcc_sim.diagnose.fitting import descent
from rcc_sim.diagnose.fitting.engine import Engine
from rcc_sim.diagnose.fitting.knobs import SLIP, nuisance_knobs
from rcc_sim.diagnose.residuals.lateness import NEIGHBOURS
from rcc_sim.diagnose.residuals.posed import problem_of
from rcc_sim.diagnose.residuals.shapes import SLOPES
from rcc_sim.diagnose.run import diagnose
from rcc_sim.simulate.drive import drive_of
from rcc_sim.simulate.replay import replay
from rcc_sim.trace import Trace

METERS = {
    "sensors.battery_voltage_v.bias_sd": 0.3,
    "sensors.battery_current_a.bias_sd": 0.15,
}
CAR = load_vehicle("bmw_i3").changed(settings=METERS)
FINE = np.arange(0.0, 1200.0, 0.01)


def ramps(seed):
    """Speeds that change by ramps and are held for a while by a foot. [m/s]"""
    rng = np.random.default_rng(seed)
    time, speed = [0.0, 6.0], [0.0, 0.0]
    while time[-1] < FINE[-1]:
        goal = 0.0 if rng.random() < 0.2 and speed[-1] else rng.uniform(4.0, 29.0)
        takes = abs(goal - speed[-1]) / rng.uniform(0.4, 1.4)
        time += [time[-1] + takes, time[-1] + takes + rng.uniform(5.0, 40.0)]
        speed += [goal, goal]
    even = np.interp(FINE, time, speed)
    knots = np.arange(0.0, FINE[-1] + 8.0, 4.0)
    sway = PchipInterpolator(knots, rng.normal(0, 0.15, len(knots)))(FINE)
    return even + sway * np.minimum(even / 4.0, 1.0)  # none at rest


NOISE = {
    "battery_voltage_v": 0.2,
    "battery_current_a": 0.3,
    "motor_torque_nm": 0.5,
}


def polled(seed, effects=None, late=0.2, torque=False):
    """What a socket tells of it each second: the speed, then the battery."""
    speed = ramps(seed)
    fine = Trace({"time_s": FINE, "speed_mps": speed}, name="fine")
    truth = CAR.changed(effects=effects or {})
    exact = replay(truth, drive_of(fine, truth))
    rng = np.random.default_rng(seed)
    at = np.arange(0.37, 1195.0)
    seen = np.interp(at, FINE, speed)
    seen = np.where(seen > 0, seen + rng.normal(0, 0.01, len(at)), 0.0)
    columns = {"time_s": at, "speed_mps": np.maximum(seen, 0.0)}
    for c in NOISE if torque else (c for c in NOISE if c.startswith("battery")):
        read = np.interp(at + late, FINE, exact[c])
        columns[c] = read + rng.normal(0, NOISE[c], len(at))
    return Logged(Trace(columns, name="polled"), (), None)


@pytest.mark.slow
@pytest.mark.parametrize(
    "seed", [1, *(pytest.param(n, marks=pytest.mark.thorough) for n in (2, 3))]
)
def test_a_drive_without_a_cause_has_none(seed):
    found = diagnose([polled(seed)], CAR)
    assert found.asserted == ()
    assert found.status == "no_gap"


@pytest.mark.slow
@pytest.mark.parametrize(
    ("effect", "name", "value"),
    [
        ("payload", "mass_kg", 300.0),
        ("auxiliary_load", "power_w", 1400.0),
    ],
)
def test_what_acts_is_named_alone(effect, name, value):
    (one,) = diagnose([polled(4, {effect: {name: value}})], CAR).asserted
    assert one.cause.effect == effect
    assert one.figures[name].value == pytest.approx(value, rel=0.1)


def test_readings_between_the_rows_move_no_figure_of_the_car():
    """A battery that was asked after the speed, or before it."""
    for late in (-0.3, 0.2):
        problem = problem_of(polled(7, late=late).log, CAR)
        fit = descent.of_tolerances(Engine([problem]))
        pulls = {k.key: (fit.values[k.key] - k.value) / k.sd for k in fit.knobs}
        assert max(abs(x) for key, x in pulls.items() if "bias" not in key) < 1.5


@pytest.mark.parametrize("late", [-0.3, 0.2])
def test_beside_a_torque_the_speed_is_of_another_instant(late):
    """Power is torque times speed: where it changes, that would be an efficiency."""
    problem = problem_of(polled(5, late=late, torque=True).log, CAR)
    fit = descent.of_tolerances(Engine([problem]))
    # a mean since the row before is of half a row ago
    later = late + 0.5 * min(problem.drive.window, problem.row)
    assert fit.values["bias.0.speed_later"] == pytest.approx(later, abs=0.05)
    scale = next(k for k in fit.knobs if k.key == "effects.motor_efficiency.scale")
    assert abs(fit.values[scale.key] - scale.value) < 2 * scale.sd


def test_what_may_be_off_in_such_a_log():
    problem = problem_of(polled(6).log, CAR)
    own = {f"flows_{k:+d}" for k in NEIGHBOURS} | {*SLOPES}
    assert own <= problem.shapes.keys()


def test_a_log_of_which_no_battery_is_compared_has_none():
    log = polled(6).log
    columns = {c: log[c] for c in ("time_s", "speed_mps")}
    columns["accel_x_mps2"] = np.gradient(log["speed_mps"], log["time_s"])
    problem = problem_of(Trace(columns, name="felt"), CAR)
    assert problem.channels == ("accel_x_mps2",)
    assert not any(name.startswith("flows") for name in problem.shapes)


def test_a_stated_slip_may_be_off_wherever_the_speed_is_not_smoothed():
    """What it costs, F² v / C, is there in slow rows as well."""
    car = CAR.changed(settings={SLIP: {"value": 90000.0, "sd": 20000.0}})
    log = polled(6).log
    noise = np.random.default_rng(6).normal(0, 1.0, len(log))
    noisy = Trace({**log.columns, "speed_mps": log["speed_mps"] + noise}, name="noisy")
    for one, felt in ((log, True), (noisy, False)):
        problem = problem_of(one, car)
        assert (problem.drive.smear == 0) == felt
        assert (SLIP in {k.key for k in nuisance_knobs([problem])}) == felt
