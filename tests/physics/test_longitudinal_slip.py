"""Driven tyres that slip: closed forms, scipy, stiff wheels, stops and slopes."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from rcc_sim.definitions.cycle import Cycle, parse_cycle
from rcc_sim.simulate.run import LaneChanges, simulate
from rcc_sim.units import G
from tests.cars import car, truck

N = 11.82 / 0.049
K_T = 1.5 * 2 * 0.887e-3
ROLL = {"rolling_resistance": {"coefficient": 0.05}}
ROTOR = {"rotor_inertia": {"inertia_kgm2": 2.2e-6}}


def slip(stiffness):
    return {"longitudinal_slip": {"stiffness_n": stiffness}}


@pytest.mark.parametrize("imposed", [False, True])
def test_at_steady_speed_the_motor_runs_ahead_by_force_over_stiffness(imposed):
    C, t = 200.0, np.arange(0.0, 41.0)
    cycle = Cycle("c", t, np.minimum(t, 3.0))
    run = simulate(car(ROLL | ROTOR | slip(C)), cycle, imposed=imposed)
    F = 0.05 * 3.78 * G
    rows = run.trace["time_s"] >= 30.0
    way = run.trace["distance_m"][rows]
    road = (way[-1] - way[0]) / np.ptp(run.trace["time_s"][rows])
    seen = run.trace["speed_mps"][-1]
    floor = 1.0 if imposed else math.sqrt(1 + (0.0547 / road) ** 2)
    assert seen / road - 1 == pytest.approx(F / C * floor, rel=1e-3)
    lost = run.trace["energy_longitudinal_slip_j"][rows]
    assert lost[-1] - lost[0] == pytest.approx(F * (seen / road - 1) * np.ptp(way))


def test_scipy_integrates_the_same_wheels():
    """Vehicle, wheels and speed loop written out again, for an implicit solver."""
    m, J, C, C_rr = 3.78, 2.2e-6, 150.0, 0.02
    M, floor = J * N * N, 0.02 * math.sqrt(90 * 0.32399 / m)

    def rhs(_, state):
        v, w, _, gap = state
        error = (4.0 - w) * N
        F = C * (w - v) / math.sqrt(v * v + floor * floor)
        tau = K_T * (0.25 * error + 0.5 * gap)
        return [(F - C_rr * m * G) / m, (N * tau - F) / M, v, error]

    t = np.linspace(0, 4, 401)
    start, tight = [3.0, 3.0, 0.0, 0.0], {"rtol": 1e-9, "atol": 1e-11}
    theirs = solve_ivp(rhs, (0, 4), start, method="Radau", t_eval=t, **tight).y
    effects = {"rolling_resistance": {"coefficient": C_rr}} | ROTOR | slip(C)
    cycle = Cycle("c", np.array([0.0, 1e-9, 4.0]), np.array([3.0, 4.0, 4.0]))
    fast = car(effects, controller__loop_rate_hz=20000.0)
    ours = simulate(fast, cycle, output_rate=100.0).trace
    assert np.abs(ours["speed_mps"] - theirs[1])[1:].max() < 2e-3
    assert np.abs(ours["distance_m"] - theirs[2]).max() < 1e-3
    step = simulate(car(effects), cycle, output_rate=100.0).trace
    assert np.abs(step["speed_mps"] - theirs[1])[10:].max() < 5e-3


@settings(max_examples=60)
@given(
    stiffness=st.floats(20, 1e6),
    inertia=st.floats(1e-6, 1e-5),
    slope=st.floats(-0.1, 0.1),
    efficiency=st.floats(0.7, 1.0),
    friction=st.floats(0, 0.01),
    speeds=st.lists(
        st.sampled_from([0.0, 0.05, 0.3, 2.0, 6.0]), min_size=2, max_size=8
    ),
    lanes=st.sampled_from([None, 4.0]),
    imposed=st.booleans(),
)
def test_the_ledger_closes_whatever_slips(
    stiffness, inertia, slope, efficiency, friction, speeds, lanes, imposed
):
    effects = ROLL | slip(stiffness) | {
        "rotor_inertia": {"inertia_kgm2": inertia},
        "road_grade": {"slope": slope},
        "gear_loss": {"efficiency": efficiency},
        "drivetrain_friction": {"torque_nm": friction},
        "drivetrain_damping": {"damping_nms_per_rad": 1e-5},
        "speed_dead_zone": {"threshold_radps": 40.0},
    }  # fmt: skip
    cycle = Cycle("any", 1.5 * np.arange(len(speeds)), np.array(speeds))
    changes = LaneChanges(lanes) if lanes else None
    run = simulate(car(effects), cycle, lanes=changes, imposed=imposed)
    assert abs(run.residual) < 1e-9
    assert all(np.isfinite(run.trace[c]).all() for c in run.trace.columns)
    assert (run.trace["motor_speed_radps"] >= 0).all()


def test_stiff_tyres_come_to_rolling_ones_at_the_same_step():
    """The slip's own time constant M/K falls to nanoseconds; the step stays 1 ms."""
    cycle = Cycle("c", np.array([0.0, 2, 5, 7, 9]), np.array([0.0, 5, 5, 0, 0]))
    rolling = simulate(car(ROLL | ROTOR), cycle)
    gaps = []
    for C in (3e3, 3e4, 3e7):
        stiff = simulate(car(ROLL | ROTOR | slip(C)), cycle)
        gap = np.abs(stiff.trace["speed_mps"] - rolling.trace["speed_mps"]).max()
        gaps.append(gap)
    assert gaps[2] < gaps[1] < gaps[0] < 0.05
    assert gaps[2] < 1e-4


@pytest.mark.parametrize("vehicle", ["car", "truck"])
def test_on_a_slope_it_stands_pulls_away_and_stops_without_creep_or_jitter(vehicle):
    hill = {"road_grade": {"slope": 0.08}, "rolling_resistance": {"coefficient": 0.02}}
    if vehicle == "car":
        made = car(hill | ROTOR | slip(400.0))
    else:
        hill["rotor_inertia"] = {"inertia_kgm2": 0.2}
        made = truck(hill | slip(4e5))
    cycle = Cycle(
        "c", np.array([0.0, 5, 9, 13, 17, 30]), np.array([0.0, 0, 3, 3, 0, 0])
    )
    rate = 1000.0 if vehicle == "car" else 100.0
    run = simulate(made, cycle, output_rate=rate).trace
    t, w = run["time_s"], run["speed_mps"]
    for still in (t < 4.9, t > 25.0):
        assert (w[still] == 0).all()
        assert np.ptp(run["distance_m"][still]) == 0
    pull = (t > 5.5) & (t < 8.5)
    assert (np.diff(w[pull]) > 0).all()
    away = (t > 5.0) & (t < 5.5)
    turns = np.diff(np.sign(np.diff(w[away])))
    assert np.count_nonzero(turns) <= 2
    assert (
        run["motor_current_a" if vehicle == "car" else "motor_torque_nm"].max() < 60e3
    )


def test_half_the_step_and_the_other_way_to_run_agree_on_what_slips():
    cycle = parse_cycle("udds[0:130]")
    cycle = Cycle("s", 0.2256 * cycle.time_s, 0.416 * cycle.speed_mps)
    made = car(ROLL | ROTOR | slip(300.0))
    one, two = (simulate(made, cycle, substeps=n) for n in (1, 2))
    assert one.battery_energy == pytest.approx(two.battery_energy, rel=1e-3)
    known = simulate(made, cycle, imposed=True).ledger["longitudinal_slip"]
    assert known == pytest.approx(two.ledger["longitudinal_slip"], rel=0.1)


def test_slip_beyond_what_a_stiffness_describes_is_said():
    cycle = Cycle("c", np.array([0.0, 0.5, 2.0]), np.array([0.0, 6.0, 6.0]))
    notes = simulate(car(ROTOR | slip(30.0)), cycle).notes
    assert any("slip by up to" in note for note in notes)
    notes = simulate(car(ROTOR | slip(3000.0)), cycle).notes
    assert not any("slip by up to" in note for note in notes)
