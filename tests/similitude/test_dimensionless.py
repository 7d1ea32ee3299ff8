"""A dimensionless trace is the same for two similar vehicles."""

from __future__ import annotations

import gzip
import io

import pytest
from similar import car, truck

from rcc_sim.errors import InputError
from rcc_sim.similitude.dimensionless import dimensionless_trace
from rcc_sim.similitude.scale import Scales

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


def text_of(columns):
    values = ",".join(repr(v) for v in columns.values())
    return io.StringIO(f"{','.join(columns)}\n{values}\n")


def test_the_columns_carry_the_papers_numbers():
    (row,), left_out = dimensionless_trace(text_of(COLUMNS), truck())
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
    assert left_out == []
    assert row["pi_9_speed"] == pytest.approx(20 * (3152 / (40700 * 3.452)) ** 0.5)


@pytest.mark.parametrize("repeating", [("m", "l", "C_F"), ("m", "l", "C_R")])
def test_the_trace_of_a_similar_vehicle_falls_on_the_same_curve(repeating):
    scaled, _ = Scales.between(car(), truck()).columns(COLUMNS)
    (large,), _ = dimensionless_trace(text_of(COLUMNS), truck(), repeating)
    (small,), _ = dimensionless_trace(text_of(scaled), car(), repeating)
    assert list(small) == list(large)
    assert list(small.values()) == pytest.approx(list(large.values()))


def test_electrical_columns_are_left_out_and_named():
    source = text_of({"time_s": 0.0, "motor_current_a": 5.0, "battery_voltage_v": 12.0})
    rows, left_out = dimensionless_trace(source, car())
    assert left_out == ["motor_current_a", "battery_voltage_v"]
    assert list(rows[0]) == ["pi_8_time"]


def test_a_compressed_file_and_empty_cells_are_read(tmp_path):
    path = tmp_path / "trace.csv.gz"
    path.write_bytes(gzip.compress(b"time_s,speed_mps\n0,\n1,2\n"))
    rows, _ = dimensionless_trace(str(path), car())
    assert rows[0]["pi_9_speed"] is None
    assert len(rows) == 2


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("", "no column time_s"),
        ("a,b\n1,2\n", "no column time_s"),
        ("time_s,speed_mps\n", "at least one row"),
        ("time_s,speed_mps\n0,fast\n", "line 2: speed_mps should be a number"),
        ("time_s,speed_mps\n0\n", "line 2: should have 2 cells"),
        ("time_s,x_m,x_m\n0,1,2\n", "x_m is there twice"),
    ],
)
def test_a_trace_that_is_not_sound_is_refused_by_line(text, says):
    with pytest.raises(InputError, match=says):
        dimensionless_trace(io.StringIO(text), car())


def test_repeating_variables_must_be_figures_of_the_vehicle():
    with pytest.raises(InputError, match="no figure for"):
        dimensionless_trace(text_of(COLUMNS), car(), ("m", "l", "t"))
