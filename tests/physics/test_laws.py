"""The model against closed forms, a second integrator and conservation laws."""

import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from rcc_sim.definitions.cycle import Cycle, parse_cycle
from rcc_sim.definitions.vehicle import load_vehicle
from rcc_sim.similitude.scale import scaled_vehicle
from rcc_sim.simulate.run import LaneChanges, simulate
from rcc_sim.units import G
from tests.cars import car, truck

K_T = 1.5 * 2 * 0.887e-3
N = 11.82 / 0.049
COAST = {"regeneration_limit": {"max_current_a": 0.0}}


def coasting(v_0, duration):
    """From v_0 on, a reference of nothing: with no regeneration the car coasts."""
    t = np.array([0.0, 1e-6, duration])
    return Cycle("coast", t, np.array([v_0, 0.0, 0.0]))


def columns_equal(a, b):
    return all(np.array_equal(a.trace[c], b.trace[c]) for c in a.trace.columns)


effects = st.fixed_dictionaries(
    {},
    optional={
        "drivetrain_damping": st.fixed_dictionaries(
            {"damping_nms_per_rad": st.floats(0, 3e-5)}
        ),
        "drivetrain_friction": st.fixed_dictionaries({"torque_nm": st.floats(0, 3e-3)}),
        "rotor_inertia": st.fixed_dictionaries({"inertia_kgm2": st.floats(0, 1e-5)}),
        "gear_loss": st.fixed_dictionaries({"efficiency": st.floats(0.6, 1)}),
        "copper_loss": st.fixed_dictionaries(
            {"phase_resistance_ohm": st.floats(0, 0.1)}
        ),
        "auxiliary_load": st.fixed_dictionaries({"power_w": st.floats(0, 20)}),
        "battery_resistance": st.fixed_dictionaries(
            {"resistance_ohm": st.floats(0, 0.02)}
        ),
        "regeneration_limit": st.fixed_dictionaries(
            {"max_current_a": st.floats(0, 50)}
        ),
        "speed_dead_zone": st.fixed_dictionaries({"threshold_radps": st.floats(0, 90)}),
        "rolling_resistance": st.fixed_dictionaries(
            {"coefficient": st.floats(0, 0.08)}
        ),
        "aerodynamic_drag": st.fixed_dictionaries({"drag_area_m2": st.floats(0, 0.2)}),
        "road_grade": st.fixed_dictionaries({"slope": st.floats(-0.05, 0.05)}),
        "payload": st.fixed_dictionaries({"mass_kg": st.floats(-0.5, 2)}),
        "wheel_radius": st.fixed_dictionaries({"scale": st.floats(0.9, 1.1)}),
        "tyre_saturation": st.fixed_dictionaries(
            {"friction_coefficient": st.floats(0.3, 1.2)}
        ),
    },
)
drives = st.lists(st.floats(0, 9), min_size=2, max_size=8)


@settings(max_examples=60)
@given(effects=effects, speeds=drives, lanes=st.sampled_from([None, 3.0, 8.0]),
       imposed=st.booleans())  # fmt: skip
def test_the_ledger_closes_for_any_car_and_drive(effects, speeds, lanes, imposed):
    cycle = Cycle("any", 1.5 * np.arange(len(speeds)), np.array(speeds))
    changes = LaneChanges(lanes) if lanes else None
    run = simulate(car(effects), cycle, lanes=changes, imposed=imposed)
    assert abs(run.residual) < 1e-9


@pytest.mark.parametrize("imposed", [False, True])
def test_plain_python_and_machine_code_agree_to_the_last_bit(imposed):
    cycle = Cycle("c", np.array([0.0, 1, 2, 3]), np.array([0, 3, 3, 0.0]))
    rich = car(
        {
            "drivetrain_damping": {"damping_nms_per_rad": 1e-5},
            "rotor_inertia": {"inertia_kgm2": 2e-6},
            "copper_loss": {"phase_resistance_ohm": 0.02},
            "battery_resistance": {"resistance_ohm": 0.02},
            "tyre_saturation": {"friction_coefficient": 0.8},
            "speed_dead_zone": {"threshold_radps": 40.0},
        }
    )
    lanes = LaneChanges(2.0)
    a, b = (
        simulate(rich, cycle, lanes=lanes, imposed=imposed, engine=engine)
        for engine in ("compiled", "interpreted")
    )
    assert columns_equal(a, b)


def test_mirrored_steering_mirrors_the_trace_bit_for_bit():
    cycle = Cycle("c", np.array([0.0, 2, 6]), np.array([0.0, 5, 5]))
    t = np.linspace(0, 6, 400)
    angle = 0.1 * np.sin(3 * t) + 0.02
    left = simulate(car(), cycle, steer=(t, angle)).trace
    right = simulate(car(), cycle, steer=(t, -angle)).trace
    odd = {"steer_cmd_rad", "yaw_rate_radps", "accel_y_mps2", "y_m", "yaw_rad"}
    for name in left.columns:
        sign = -1.0 if name in odd else 1.0
        assert np.array_equal(left[name], sign * right[name]), name
    assert np.ptp(left["y_m"]) > 1


def test_a_coast_down_follows_its_closed_form():
    C_rr, CdA, v_0 = 0.03, 0.4, 8.0
    A, C = C_rr * 3.78 * G, 0.5 * 1.2 * CdA
    loads = {
        "rolling_resistance": {"coefficient": C_rr},
        "aerodynamic_drag": {"drag_area_m2": CdA},
    }
    run = simulate(car(COAST | loads), coasting(v_0, 30.0)).trace
    t = run["time_s"]
    w = math.sqrt(A * C) / 3.78
    end = math.atan(v_0 * math.sqrt(C / A)) / w
    closed = math.sqrt(A / C) * np.tan(np.maximum(w * (end - t), 0.0))
    assert np.abs(run["speed_mps"] - closed).max() < 2e-4
    assert run["speed_mps"][-1] == 0.0


def test_a_motor_step_decays_as_exp_minus_Bt_over_J():
    """With a featherweight body the vehicle is its rotor: J dω/dt = -B ω."""
    B, J = 1.2e-5, 4e-5
    spin = COAST | {
        "drivetrain_damping": {"damping_nms_per_rad": B},
        "rotor_inertia": {"inertia_kgm2": J},
    }
    light = car(spin, body__mass_kg=0.2, body__yaw_inertia_kgm2=0.002)
    run = simulate(light, coasting(6.0, 8.0)).trace
    J_total = J + 0.2 / N**2
    closed = 6.0 * np.exp(-B / J_total * run["time_s"])
    assert np.allclose(run["speed_mps"], closed, rtol=2e-5)


def test_steady_cornering_has_the_understeer_gradient_of_the_textbook():
    """δ = l/R + (m v²/(R l)) (l_R/(2 C_F) - l_F/(2 C_R)); Gillespie, ch. 6."""
    v, delta = 4.0, 0.01
    cycle = Cycle("c", np.array([0.0, 20.0]), np.array([v, v]))
    run = simulate(car(), cycle, steer=([0.0, 20.0], [delta, delta])).trace
    r, speed = run["yaw_rate_radps"][-1], run["speed_mps"][-1]
    l_F, l_R, m = 0.15876, 0.16523, 3.78
    l = l_F + l_R
    R = speed / r
    gradient = m * speed**2 / (R * l) * (l_R / (2 * 90) - l_F / (2 * 110))
    assert l / R + gradient == pytest.approx(delta, rel=2e-3)
    assert abs(gradient) > 0.1 * delta


def test_scipy_integrates_the_same_drive():
    """The paper's equations written out again, for solve_ivp."""
    m, I_z, l_F, l_R, C_F, C_R = 3.78, 0.0382, 0.15876, 0.16523, 90.0, 110.0
    B, J, C_rr = 1e-5, 2e-6, 0.02
    m_x = m + J * N * N

    def steer(t):
        return 0.12 * np.sin(2.0 * t)

    def rhs(t, state):
        v_x, v_y, r, _, _, psi, gap = state
        d = steer(t)
        error = (3.5 - v_x) * N
        tau = K_T * (0.25 * error + 0.5 * gap)
        F_F = -2 * C_F * (math.atan2(v_y + l_F * r, v_x) - d)
        F_R = -2 * C_R * math.atan2(v_y - l_R * r, v_x)
        F_x = N * (tau - B * N * v_x) - C_rr * m * G
        return [
            (F_x - F_F * math.sin(d) + m * v_y * r) / m_x,
            (F_F * math.cos(d) + F_R) / m - v_x * r,
            (l_F * F_F * math.cos(d) - l_R * F_R) / I_z,
            v_x * math.cos(psi) - v_y * math.sin(psi),
            v_x * math.sin(psi) + v_y * math.cos(psi),
            r,
            error,
        ]

    t = np.linspace(0, 6, 601)
    start = [3.0, 0, 0, 0, 0, 0, 0]
    theirs = solve_ivp(rhs, (0, 6), start, t_eval=t, rtol=1e-9, atol=1e-11).y
    fine = np.linspace(0, 6, 6001)
    made = car(
        {
            "drivetrain_damping": {"damping_nms_per_rad": B},
            "rotor_inertia": {"inertia_kgm2": J},
            "rolling_resistance": {"coefficient": C_rr},
        },
        controller__loop_rate_hz=10000.0,
    )
    cycle = Cycle("c", np.array([0.0, 1e-9, 6.0]), np.array([3.0, 3.5, 3.5]))
    ours = simulate(made, cycle, steer=(fine, steer(fine)), output_rate=100.0).trace
    pairs = (("speed_mps", 0), ("yaw_rate_radps", 2), ("x_m", 3), ("y_m", 4))
    for column, k in pairs:
        scale = np.abs(theirs[k]).max()
        # the model's tyres fade out at v_slip = 0.055 m/s: (0.055/3)²/2 of the slip
        assert np.abs(ours[column] - theirs[k]).max() < 5e-4 * scale, column


def test_halving_the_step_quarters_the_error():
    cycle = Cycle("c", np.array([0.0, 2, 5]), np.array([2.0, 6, 6]))
    t = np.linspace(0, 5, 50)
    rough = car(
        {"aerodynamic_drag": {"drag_area_m2": 0.3}}, controller__loop_rate_hz=20.0
    )
    yaw = [
        simulate(
            rough, cycle, steer=(t, 0.1 * np.sin(3 * t)), substeps=n, output_rate=20.0
        ).trace["yaw_rad"][-1]
        for n in (8, 16, 32, 256)
    ]
    errors = [abs(value - yaw[-1]) for value in yaw[:-1]]
    for coarse, fine in pairwise(errors):
        assert 3.0 < coarse / fine < 5.5


@pytest.mark.parametrize(
    ("lanes", "power"), [(None, 623e3), (50.0, 623e3), (None, 15e3)]
)
def test_a_vehicle_scaled_by_its_groups_gives_the_scaled_trace(lanes, power):
    """No g, no ρ; loop rate and gains scale with the rest. By 15 kW it falls behind."""
    own = {
        "drivetrain_damping": {"damping_nms_per_rad": 0.25},
        "rotor_inertia": {"inertia_kgm2": 0.2},
        "gear_loss": {"efficiency": 0.95},
        "motor_efficiency": {"scale": 0.85},
        "auxiliary_load": {"power_w": 500.0},
    }
    large = truck(own, motor__max_power_w=power)
    m, l, F = 1 / 900.0, 1 / 10.0, 1 / 420.0
    small = scaled_vehicle(large, "small", mass=m, length=l, force=F)
    T, V = math.sqrt(m * l / F), math.sqrt(l * F / m)
    cycle = parse_cycle("udds[20:60]")
    tiny = Cycle("tiny", T * cycle.time_s, V * cycle.speed_mps)
    a = simulate(large, cycle, lanes=LaneChanges(lanes) if lanes else None)
    b = simulate(
        small, tiny, lanes=LaneChanges(l * lanes) if lanes else None, output_rate=10 / T
    )
    for column, factor in (
        ("speed_mps", V), ("battery_power_w", F * V), ("y_m", l),
        ("yaw_rate_radps", 1 / T), ("energy_drivetrain_damping_j", F * l),
        ("battery_energy_j", F * l), ("accel_y_mps2", l / T**2),
    ):  # fmt: skip
        one, other = factor * a.trace[column], b.trace[column]
        assert np.abs(one - other).max() <= 1e-6 * max(np.abs(one).max(), 1e-12), column


def test_a_vehicle_on_a_slope_stands_and_pulls_away():
    cycle = Cycle("c", np.array([0.0, 5, 8, 12]), np.array([0.0, 0, 3, 3]))
    hill = {"road_grade": {"slope": 0.1}, "rolling_resistance": {"coefficient": 0.02}}
    run = simulate(car(hill), cycle).trace
    waits = run["time_s"] < 4.9
    assert (run["speed_mps"][waits] == 0).all()
    assert (run["speed_mps"] >= 0).all()
    assert run["speed_mps"][-1] == pytest.approx(3.0, abs=0.1)


def test_a_vehicle_held_by_friction_does_not_creep():
    """Thrust below the static resistance moves nothing, for however long."""
    stuck = {"rolling_resistance": {"coefficient": 0.3}, "drivetrain_friction":
             {"torque_nm": 0.05}}  # fmt: skip
    gentle = car(stuck, controller__integral_gain_a_per_rad=0.0)
    cycle = Cycle("c", np.array([0.0, 60.0]), np.array([0.05, 0.05]))
    slow = Cycle("c", np.array([0.0, 1e-3, 60.0]), np.array([0.0, 0.05, 0.05]))
    run = simulate(gentle, slow).trace
    assert run["distance_m"][-1] == 0.0
    assert run["motor_current_a"][-1] > 0
    assert simulate(gentle, cycle).trace["speed_mps"][-1] == 0.0


def test_commanded_and_imposed_agree_where_the_driver_follows_well():
    van = truck(
        {
            "road_load": {"a_n": 200.0, "b_n_s_per_m": 9.0, "c_n_s2_per_m2": 0.4},
            "rotor_inertia": {"inertia_kgm2": 0.2},
            "motor_efficiency": {"scale": 0.9},
        }
    )
    cycle = parse_cycle("udds[0:340]")
    driven, imposed = (simulate(van, cycle, imposed=i) for i in (False, True))
    assert driven.battery_energy == pytest.approx(imposed.battery_energy, rel=2e-3)


@pytest.mark.parametrize(
    "name", ["rcc", "r1t", "r1t_epa", "f1tenth", "bmw_i3", "twizy"]
)
def test_half_the_step_changes_the_energy_by_less_than_a_thousandth(name):
    vehicle = load_vehicle(name)
    cycle = parse_cycle("udds[0:130]")
    if vehicle.controller.mode == "speed":
        cycle = Cycle("s", 0.2256 * cycle.time_s, 0.416 * cycle.speed_mps)
    lanes = LaneChanges(20 * vehicle.wheelbase)
    one, two = (simulate(vehicle, cycle, lanes=lanes, substeps=n) for n in (1, 2))
    assert one.battery_energy == pytest.approx(two.battery_energy, rel=1e-3)


def test_lateral_manoeuvres_cost_what_the_tyres_lose():
    cycle = Cycle("c", np.array([0.0, 3, 12]), np.array([0.0, 5, 5]))
    base = {"drivetrain_damping": {"damping_nms_per_rad": 1e-5}}
    straight = simulate(car(base), cycle)
    lanes = simulate(car(base), cycle, lanes=LaneChanges(6.0, width=0.8, length=3.0))
    slip = lanes.ledger["tyre_slip_front"] + lanes.ledger["tyre_slip_rear"]
    assert slip > 0
    more = lanes.battery_energy - straight.battery_energy
    assert more == pytest.approx(slip, rel=0.1)


def test_scipy_integrates_a_relaxed_tyre_too():
    m, I_z, l_F, l_R, C_F, C_R, v, sigma = (
        3.78,
        0.0382,
        0.15876,
        0.16523,
        90,
        110,
        4.0,
        0.2,
    )

    def steer(t):
        return 0.06 * np.sin(2.0 * t)

    def rhs(t, state):
        v_x, v_y, r, a_F, a_R, psi, _ = state
        F_F, F_R = -2 * C_F * a_F, -2 * C_R * a_R
        d = steer(t)
        return [
            -F_F * math.sin(d) / m + v_y * r,
            (F_F * math.cos(d) + F_R) / m - v_x * r,
            (l_F * F_F * math.cos(d) - l_R * F_R) / I_z,
            v_x / sigma * (math.atan2(v_y + l_F * r, v_x) - d - a_F),
            v_x / sigma * (math.atan2(v_y - l_R * r, v_x) - a_R),
            r,
            v_x * math.sin(psi) + v_y * math.cos(psi),
        ]

    t = np.linspace(0, 5, 501)
    theirs = solve_ivp(rhs, (0, 5), [v] + [0] * 6, t_eval=t, rtol=1e-9, atol=1e-11).y
    fine = np.linspace(0, 5, 5001)
    free = car(
        COAST | {"tyre_relaxation": {"length_m": sigma}},
        controller__proportional_gain_as_per_rad=0.0,
        controller__integral_gain_a_per_rad=0.0,
        controller__loop_rate_hz=10000.0,
    )
    cycle = Cycle("c", np.array([0.0, 5.0]), np.array([v, v]))
    ours = simulate(free, cycle, steer=(fine, steer(fine)), output_rate=100.0).trace
    for column, k in (("yaw_rate_radps", 2), ("yaw_rad", 5), ("y_m", 6)):
        gap = np.abs(ours[column] - theirs[k]).max()
        assert gap < 1e-3 * np.abs(theirs[k]).max(), column
