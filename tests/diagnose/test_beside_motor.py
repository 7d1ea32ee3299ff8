"""What pushes a car shows in its motor's current and its battery's, and counts once."""

from dataclasses import replace

import numpy as np
import pytest

from rcc_sim.definitions.cycle import Cycle
from rcc_sim.diagnose.fitting.engine import Engine
from rcc_sim.diagnose.residuals.beside_motor import MOTOR, SPEED, drawn_by_motor
from rcc_sim.diagnose.residuals.posed import problem_of
from rcc_sim.diagnose.residuals.terminals import CURRENT, POWER
from rcc_sim.simulate.run import simulate
from rcc_sim.trace import Trace
from tests.cars import car

LOSSES = {
    "drivetrain_damping": {"damping_nms_per_rad": 1.2e-5},
    "copper_loss": {"phase_resistance_ohm": 0.03},
}
CYCLE = Cycle("c", np.array([0, 3, 20, 40, 60.0]), np.array([0, 2, 4, 3, 5.0]))
NOISE = {MOTOR: 0.2, CURRENT: 0.05, "speed_mps": 0.002, "battery_voltage_v": 0.0}
SEEN = ("time_s", "speed_ref_mps", *NOISE)


def rough_drive(seed=0):
    """A log of a road whose slope, which no channel tells, changes every two metres."""
    rng = np.random.default_rng(seed)
    vehicle, at = car(LOSSES), np.arange(0, 300, 2.0)
    slope = (at, rng.normal(0.0, 0.01, len(at)))
    run = simulate(vehicle, CYCLE, slope=slope, output_rate=100.0).trace
    columns = {c: run[c] + rng.normal(0, NOISE.get(c, 0.0), len(run)) for c in SEEN}
    return Trace(columns, name="log"), vehicle


def slow(x, rows=100):
    return x[: len(x) // rows * rows].reshape(-1, rows).mean(axis=1)


def test_what_a_rough_road_does_to_both_currents_counts_once():
    problem = problem_of(*rough_drive())
    left = dict(zip(problem.channels, problem.residuals({}), strict=True))
    plain = problem.log[CURRENT] - problem.nominal[CURRENT]
    moves = slow(problem.log["speed_mps"]) > 1.0
    motor = slow(left[MOTOR])[moves]
    assert np.corrcoef(motor, slow(plain)[moves])[0, 1] > 0.9
    assert abs(np.corrcoef(motor, slow(left[CURRENT])[moves])[0, 1]) < 0.4
    assert np.std(slow(left[CURRENT])[moves]) < 0.3 * np.std(slow(plain)[moves])


@pytest.mark.parametrize("of", [CURRENT, POWER])
def test_what_the_battery_gives_per_ampere_is_the_slope_of_its_power(of):
    """P = K_t ω i + 3/2 R i², by differences."""
    vehicle = car(LOSSES)
    run = simulate(vehicle, CYCLE, output_rate=100.0).trace
    R = LOSSES["copper_loss"]["phase_resistance_ohm"]

    def given(i):
        shaft = run["motor_torque_nm"] / run[MOTOR] * run[SPEED] * i
        per = run["battery_voltage_v"] if of == CURRENT else 1.0
        return (shaft + 1.5 * R * i**2) / per

    drives = np.abs(run[MOTOR]) > 0.5
    with np.errstate(divide="ignore", invalid="ignore"):
        by = (given(run[MOTOR] + 1e-3) - given(run[MOTOR] - 1e-3)) / 2e-3
    told = drawn_by_motor(vehicle, run.columns, of)
    np.testing.assert_allclose(told[drives], by[drives], rtol=1e-6)


def test_an_offset_of_the_motors_meter_is_told_where_it_shows():
    """As in a log that reads so much more: the battery is judged beside it."""
    problem = problem_of(*rough_drive())
    log = Trace({**problem.log.columns, MOTOR: problem.log[MOTOR] + 0.3}, name="more")
    engine, other = (Engine([p]) for p in (problem, replace(problem, log=log)))
    key = f"bias.0.{MOTOR}"
    for (_, c), a, b in zip(
        engine.tracks, engine.residuals({}), other.residuals({key: 0.3}), strict=True
    ):
        np.testing.assert_allclose(b, a, atol=1e-9, err_msg=c)


def test_a_meter_that_is_all_noise_tells_nothing_of_the_battery():
    log, vehicle = rough_drive()
    rng = np.random.default_rng(1)
    noisy = {**log.columns, MOTOR: log[MOTOR] + rng.normal(0, 20.0, len(log))}
    problem = problem_of(Trace(noisy, name="log"), vehicle)
    left = dict(zip(problem.channels, problem.residuals({}), strict=True))
    plain = problem.log[CURRENT] - problem.nominal[CURRENT]
    assert np.std(left[CURRENT] - plain) < 0.5 * np.std(plain)


@pytest.mark.parametrize(
    ("kept", "judged"),
    [(1.0, "all"), (0.7, "where it is known"), (0.3, "all")],
)
def test_where_the_motors_current_was_lost_the_push_is_no_other_noise(kept, judged):
    """Its rows alone are judged; where most were lost, the battery by itself."""
    problem = problem_of(*rough_drive())
    n = len(problem.log)
    lost = np.arange(n) > kept * n
    lost[::7] |= kept == 1.0  # single rows lost are bridged
    current = np.where(lost, np.nan, problem.log[MOTOR])
    log = Trace({**problem.log.columns, MOTOR: current}, name="lost")
    other = problem_of(log, problem.vehicle)
    rows = dict(zip(other.channels, other.judged, strict=True))[CURRENT]
    late = np.arange(n) > kept * n + 20
    assert rows[1 : int(kept * n)].all()
    assert rows[late].all() == (judged == "all")
    assert rows[late].any() == (judged == "all" and kept < 1.0)
