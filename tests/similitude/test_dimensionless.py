"""A dimensionless trace is the same for two similar vehicles."""

from __future__ import annotations

import numpy as np
import pytest
from similar import car, truck

from rcc_sim.errors import InputError
from rcc_sim.similitude.dimensionless import dimensionless_trace
from rcc_sim.similitude.scale import Scales
from rcc_sim.trace import Trace

COLUMNS = {
    "time_s": 2.0,
    "speed_mps": 20.0,
    "yaw_rate_radps": 0.2,
    "accel_x_mps2": 1.5,
    "battery_power_w": 4e4,
    "energy_kinetic_j": 6e5,
    "x_m": 40.0,
    "steer_cmd_rad": 0.05,
    "throttle": 0.3,
    "motor_torque_nm": 300.0,
    "motor_speed_radps": 500.0,
}


def trace_of(columns):
    return Trace({name: np.array([value]) for name, value in columns.items()})


def row_of(columns, vehicle, *repeating):
    (row,) = dimensionless_trace(trace_of(columns), vehicle, *repeating).rows()
    return row


def test_the_columns_carry_the_papers_numbers():
    (row,) = (found := dimensionless_trace(trace_of(COLUMNS), truck())).rows()
    assert list(row) == [
        "pi_8_time",
        "pi_9_speed",
        "pi_11_yaw_rate",
        "pi_2_accel_x",
        "pi_battery_power",
        "pi_4_energy_kinetic",
        "pi_x",
        "pi_1_steer_cmd",
        "throttle",
        "pi_motor_torque",
        "pi_motor_speed",
    ]
    assert found.left_out == []
    assert row["pi_9_speed"] == pytest.approx(20 * (3152 / (40700 * 3.452)) ** 0.5)


@pytest.mark.parametrize("repeating", [("m", "l", "C_F"), ("m", "l", "C_R")])
def test_the_trace_of_a_similar_vehicle_falls_on_the_same_curve(repeating):
    scaled, _ = Scales.between(car(), truck()).columns(COLUMNS)
    large = row_of(COLUMNS, truck(), repeating)
    small = row_of(scaled, car(), repeating)
    assert list(small) == list(large)
    assert list(small.values()) == pytest.approx(list(large.values()))


def test_electrical_columns_are_left_out_and_named():
    given = {"time_s": 0.0, "motor_current_a": 5.0, "battery_voltage_v": 12.0}
    found = dimensionless_trace(trace_of(given), car())
    assert found.left_out == ["motor_current_a", "battery_voltage_v"]
    assert list(found.columns) == ["pi_8_time"]


def test_empty_cells_stay_empty():
    trace = Trace(
        {"time_s": np.array([0.0, 1.0]), "speed_mps": np.array([np.nan, 2.0])}
    )
    rows = dimensionless_trace(trace, car()).rows()
    assert rows[0]["pi_9_speed"] is None
    assert len(rows) == 2


def test_repeating_variables_must_be_figures_of_the_vehicle():
    with pytest.raises(InputError, match="no figure for"):
        dimensionless_trace(trace_of(COLUMNS), car(), ("m", "l", "t"))
