"""V_d, V_q: a second witness of the motor's power, and what bounds torque."""

import numpy as np
import pytest

from rcc_sim.definitions.cycle import Cycle
from rcc_sim.definitions.vehicle import load_vehicle
from rcc_sim.errors import InputError
from rcc_sim.simulate.run import simulate
from tests.cars import car, truck

CYCLE = Cycle("c", np.array([0.0, 2, 4, 6, 8]), np.array([0.0, 5, 5, 1, 0]))
INDUCTANCE = {
    "motor__average_inductance_h": 6.01e-6,
    "motor__inductance_difference_h": 1.31e-6,
}
RICH = {
    "rotor_inertia": {"inertia_kgm2": 2.2e-6},
    "copper_loss": {"phase_resistance_ohm": 0.0195},
    "rolling_resistance": {"coefficient": 0.03},
    "drivetrain_damping": {"damping_nms_per_rad": 1.2e-5},
}
RICH_TRUCK = {"copper_loss": {"phase_resistance_ohm": 0.02}}


@pytest.mark.parametrize("slip", [{}, {"longitudinal_slip": {"stiffness_n": 300.0}}])
def test_dq_power_is_shaft_power_and_copper_loss_of_the_ledger(slip):
    """P_in = 3/2 (V_q I_q + V_d I_d), row by row and over the whole drive."""
    made = car(RICH | slip, **INDUCTANCE)
    run = simulate(made, CYCLE, output_rate=1000.0)
    at = run.trace
    power = 1.5 * (
        at["voltage_q_v"] * at["current_q_a"] + at["voltage_d_v"] * at["current_d_a"]
    )
    assert np.allclose(power[1:], at["battery_power_w"][1:], rtol=1e-9, atol=1e-9)
    copper = np.diff(at["energy_copper_loss_j"], prepend=0.0)
    shaft = power * 1e-3 - copper
    rest = sum(v for k, v in run.ledger.items() if k != "copper_loss")
    assert shaft.sum() == pytest.approx(rest, rel=1e-9)
    assert copper.sum() > 0.01 * power.sum() * 1e-3


def test_the_voltages_are_those_of_the_motor_s_equations():
    run = simulate(car(RICH, **INDUCTANCE), CYCLE, output_rate=1000.0).trace
    w = run["motor_speed_radps"]
    w = np.concatenate([w[:1], w[1:] + w[:-1]])  # electrical, two pole pairs
    i, rows = run["current_q_a"], run["time_s"] > 3.0
    L_q = 6.01e-6 + 1.31e-6 / 2
    assert np.allclose(run["voltage_d_v"][rows], -w[rows] * L_q * i[rows], rtol=1e-9)
    V_q = 0.0195 * i + w * 0.887e-3
    assert np.allclose(run["voltage_q_v"][rows], V_q[rows], rtol=1e-9)
    assert (run["current_d_a"] == 0).all()


def test_no_inductance_no_voltages_and_no_resistance_is_none():
    assert "voltage_q_v" not in simulate(car(RICH), CYCLE).trace
    ideal = {k: v for k, v in RICH.items() if k != "copper_loss"}
    run = simulate(car(ideal, **INDUCTANCE), CYCLE, output_rate=1000.0).trace
    power = 1.5 * run["voltage_q_v"] * run["current_q_a"]
    assert np.allclose(power[1:], run["battery_power_w"][1:], atol=1e-9)


def test_in_torque_mode_too_the_battery_s_voltage_bounds_the_speed():
    fast = Cycle("c", np.array([0.0, 20.0, 60.0]), np.array([0.0, 28.0, 28.0]))
    limited = simulate(truck(RICH_TRUCK, motor__max_power_w=None), fast)
    top = 400.0 / np.sqrt(3) / (4 * 0.098)
    assert limited.trace["motor_speed_radps"].max() == pytest.approx(top, rel=0.02)
    assert any("voltage" in note for note in limited.notes)
    weakened = simulate(truck(RICH_TRUCK), fast)
    assert weakened.trace["speed_mps"][-1] == pytest.approx(28.0, rel=1e-3)
    assert weakened.notes == ()


def test_in_torque_mode_too_the_motor_s_speed_limit_bounds_the_speed():
    fast = Cycle("c", np.array([0.0, 20.0, 60.0]), np.array([0.0, 28.0, 28.0]))
    run = simulate(truck(motor__max_speed_radps=500.0), fast)
    assert run.trace["motor_speed_radps"].max() == pytest.approx(500.0, rel=0.01)
    assert any("speed limit" in note for note in run.notes)


def test_the_paper_s_car_logs_its_voltages():
    assert "voltage_d_v" in simulate(load_vehicle("rcc"), CYCLE).trace


def test_wheels_that_the_loop_would_set_chattering_are_refused():
    slip = {"longitudinal_slip": {"stiffness_n": 100.0}}
    with pytest.raises(InputError, match="chatter") as caught:
        simulate(car(slip), CYCLE)
    assert "rotor_inertia" in caught.value.hint
    held = slip | {"rotor_inertia": {"inertia_kgm2": 2.2e-6}}
    current = simulate(car(held), CYCLE, output_rate=1000.0).trace["motor_current_a"]
    assert np.abs(np.diff(current[2500:3500])).max() < 0.01
