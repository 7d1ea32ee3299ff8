"""A log's speed is that of wheels that slip: the road's comes after it."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rcc_sim.analyse.sampled import SAMPLE
from rcc_sim.definitions.cycle import parse_cycle
from rcc_sim.definitions.vehicle import load_vehicle
from rcc_sim.diagnose.causes.candidates import candidates_for
from rcc_sim.diagnose.fitting.knobs import SLIP, tolerance_knobs
from rcc_sim.diagnose.residuals.posed import problem_of
from rcc_sim.diagnose.residuals.sizes import stiffest
from rcc_sim.physics.effects.longitudinal_slip import road_speed
from rcc_sim.simulate.drive import drive_of
from rcc_sim.simulate.replay import replay
from rcc_sim.simulate.run import simulate
from rcc_sim.trace import Trace

SEEN = ("speed_mps", "accel_x_mps2")
ROLLS = load_vehicle("r1t")
WEIGHT = ROLLS.body.mass_kg.value * 9.81


BRAKES = {
    "by the motor": {},
    "shared": {"effects.friction_brake.share": 0.3},
    "limited": {"effects.regeneration_limit.max_torque_nm": 60.0},
}


@pytest.mark.parametrize("brakes", BRAKES)
@pytest.mark.parametrize("weights", [8.0, 20.0])
def test_a_run_whose_wheels_slip_is_found_again_from_their_speed(weights, brakes):
    rolls = ROLLS.changed(settings=BRAKES[brakes])
    slips = rolls.changed(settings={SLIP: weights * WEIGHT})
    run = simulate(slips, parse_cycle("us06[0:120]"), imposed=True, output_rate=100.0)
    true = run.trace
    log = Trace({c: true[c] for c in ("time_s", "speed_mps")}, name="log")

    def missed(vehicle, column):
        seen = replay(vehicle, drive_of(log, vehicle))
        return np.std(seen[column] - true[column]) / np.std(true[column])

    for column in ("motor_torque_nm", "accel_x_mps2", "battery_power_w"):
        assert missed(slips, column) < 0.025
        assert missed(slips, column) < 0.1 * missed(rolls, column)


def test_brakes_that_take_over_leave_the_motor_at_its_limit_all_the_while():
    """What the rotor takes of a limited torque is less for the wheels, and back."""
    slips = ROLLS.changed(settings=BRAKES["limited"] | {SLIP: 8.0 * WEIGHT})
    run = simulate(slips, parse_cycle("us06[0:60]"), imposed=True, output_rate=250.0)
    torque = run.trace["motor_torque_nm"]
    limited = torque[1:] < -45.0
    assert limited.sum() > 500
    assert np.mean(np.abs(np.diff(torque))[limited] > 1.0) < 0.02


def test_rows_however_close_leave_the_road_its_speed():
    """What brakes take in changes from step to step; no step may answer the last."""
    slips = ROLLS.changed(settings=BRAKES["limited"] | {SLIP: 20.0 * WEIGHT})
    run = simulate(slips, parse_cycle("us06[0:60]"), imposed=True, output_rate=100.0)
    rng = np.random.default_rng(4)
    time = run.trace["time_s"] + rng.uniform(0.0, 0.0099, len(run.trace))
    columns = {c: np.interp(time, run.trace["time_s"], run.trace[c]) for c in SEEN}
    log = Trace({"time_s": time, "speed_mps": columns["speed_mps"]}, name="log")
    accel = replay(slips, drive_of(log, slips, SAMPLE))["accel_x_mps2"]
    assert np.std(accel - columns["accel_x_mps2"]) < 0.05 * np.std(accel)


@given(
    v_0=st.floats(0.0, 40.0),
    v_1=st.floats(0.01, 40.0),
    resists=st.floats(-0.1, 0.3),
    weights=st.floats(3.0, 100.0),
    dt=st.floats(0.001, 0.1),
)
def test_the_road_speed_is_that_by_which_its_wheels_turn(
    v_0, v_1, resists, weights, dt
):
    m, C, R = 2000.0, weights * 2000.0 * 9.81, resists * 2000.0 * 9.81
    slip = (m * (v_1 - v_0) / dt + R) / C
    if slip > -0.9:
        assert road_speed(v_1 * (1 + slip), v_0, m, dt, R, C) == pytest.approx(v_1)


def test_a_stiffness_that_a_drive_cannot_tell_is_neither_tolerance_nor_cause():
    """Noise of a speed looks like less behind a softer tyre."""
    given = {"time_s": np.arange(0.0, 60.0, 0.1)}
    given["speed_mps"] = 10 + 4 * np.sin(given["time_s"] / 5)
    given["battery_power_w"] = 1e4 * np.sin(given["time_s"] / 5)
    most = stiffest(problem_of(Trace(given), ROLLS))

    def is_free(stiffness):
        figure = {"stiffness_n": {"value": stiffness, "sd": 0.2 * stiffness}}
        car = ROLLS.changed(effects={"longitudinal_slip": figure})
        problem = problem_of(Trace(given), car)
        able = {c.effect for c in candidates_for([problem], ())}
        free = SLIP in {k.key for k in tolerance_knobs([problem])}
        assert free is ("longitudinal_slip" in able)
        return free

    assert is_free(0.8 * most)
    assert not is_free(1.2 * most)
