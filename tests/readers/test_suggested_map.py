"""A draft of a column map: what a header says by words and units."""

import numpy as np
import pyarrow
import pytest
from pyarrow import parquet

from rcc_sim.analyse.logcheck.draft import checked_draft
from rcc_sim.definitions.vehicle import load_vehicle
from rcc_sim.errors import InputError
from rcc_sim.readers import read_log
from rcc_sim.readers.column_map import load_map, map_of, shipped_maps
from rcc_sim.readers.suggest import Entry, drafted, meaning_of, unit_in
from rcc_sim.source import open_source
from tests.program import rccsim


@pytest.mark.parametrize(
    ("name", "column", "unit"),
    [
        ("Vehicle Speed (km/h)", "speed_mps", "km/h"),
        ("HV Battery Current (A)", "battery_current_a", "A"),
        ("BatteryVoltage [V]", "battery_voltage_v", "V"),
        ("Motor RPM", "motor_speed_radps", "rpm"),
        ("rpm_motor", "motor_speed_radps", "rpm"),
        ("erpm", "motor_speed_erpm", ""),
        ("GyrZ_dps", "yaw_rate_radps", "deg/s"),
        ("AccX_g", "accel_x_mps2", "g"),
        ("obs_wz", "yaw_rate_radps", ""),
        ("CH2_thr", "throttle", ""),
        ("Tq_est", "motor_torque_nm", ""),
        ("baro_cm", "elevation_m", "cm"),
        ("Pack A(+chg)", "battery_current_a", "A"),
        ("t", "time_s", ""),
        ("t [ms]", "time_s", "ms"),
        ("v_in", "battery_voltage_v", ""),
        ("Vbat (mV)", "battery_voltage_v", "mV"),
        ("i_in", "battery_current_a", ""),
        ("gz [deg/s]", "yaw_rate_radps", "deg/s"),
        ("current_in", "battery_current_a", ""),
        ("duty_cycle_now", "duty_cycle", ""),
        ("Motor Torque [Nm]", "motor_torque_nm", "N m"),
        ("Heating Power [kW]", "aux_power_w", "kW"),
        ("SoC [%]", "state_of_charge_percent", "%"),
        ("Longitudinal Acceleration [m/s^2]", "accel_x_mps2", "m/s^2"),
        ("yaw_rate_dps", "yaw_rate_radps", "deg/s"),
        ("Timestamp", "time_s", ""),
        ("Altitude (m)", "elevation_m", "m"),
        ("Vbat mV", "battery_voltage_v", "mV"),
        ("u_bat_mV", "battery_voltage_v", "mV"),
        ("ay_g", "accel_y_mps2", "g"),
        ("v_mps", "speed_mps", "m/s"),
        ("Sollgeschwindigkeit [km/h]", "speed_ref_mps", "km/h"),
        ("Lenkwinkel [deg]", "steer_cmd_rad", "deg"),
        ("Motordrehzahl [rpm]", "motor_speed_radps", "rpm"),
        ("Batteriestrom [A]", "battery_current_a", "A"),
        ("Batteriespannung [V]", "battery_voltage_v", "V"),
        ("Motorstrom [A]", "motor_current_a", "A"),
        ("Längsbeschleunigung [m/s^2]", "accel_x_mps2", "m/s^2"),
        ("Ubat mV", "battery_voltage_v", "mV"),
        ("/odom/twist/twist/linear/x", "speed_mps", ""),
        ("drive.drive.speed", "speed_ref_mps", ""),
        ("/drive/drive/steering_angle", "steer_cmd_rad", ""),
        ("/cmd_vel/linear/x", "speed_ref_mps", ""),
        ("motor_amps", "motor_current_a", "A"),
        ("bat_mA", "battery_current_a", "mA"),
        ("bat_V", "battery_voltage_v", "V"),
        ("target_kmh", "speed_ref_mps", "km/h"),
        ("yaw_dps", "yaw_rate_radps", "deg/s"),
        ("/imu/angular_velocity/z", "yaw_rate_radps", ""),
        ("/sensors/core/state/speed", "motor_speed_erpm", ""),
    ],
)
def test_a_name_and_its_unit_are_understood(name, column, unit):
    assert meaning_of(name).column == column
    assert unit_in(name) == unit


@pytest.mark.parametrize(
    "name", ["Cell Voltage max [V]", "Motor Current limit [A]", "Wheel Speed FL [km/h]",
             "Battery Temperature [°C]", "Speed [V]", "v_in [A]",
             "erpm_cmd", "Gear",
             "v_m", "ay_V", "limit_A", "cell_V", "wheel_kmh"],
)  # fmt: skip
def test_what_only_sounds_alike_is_left_out(name):
    assert meaning_of(name) is None


@pytest.mark.parametrize(
    ("name", "unit"),
    [
        ("SWA [deg]", "deg"),
        ("Steering Wheel Angle [deg]", "deg"),
        ("steering_wheel_angle_rad", ""),
        ("SteeringWheelAngle", ""),
        ("Lenkradwinkel [deg]", "deg"),
    ],
)
def test_a_steering_wheel_is_told_with_the_ratio_to_put_in(tmp_path, name, unit):
    log = tmp_path / "log.csv"
    log.write_text(f"Time [s],Speed [m/s],{name}\n0,5,1\n0.1,5,2\n")
    (entry,) = (e for e in drafted(open_source(str(log))).entries if e.name == name)
    assert (entry.column, entry.unit) == ("steer_cmd_rad", unit)
    assert entry.factor == pytest.approx(1 / 16)
    assert "the car's own ratio for 16" in entry.toml()


@pytest.mark.parametrize(
    "name", ["Steering Wheel Torque [Nm]", "SteeringWheelRate", "Wheel speed [km/h]"]
)
def test_what_else_is_told_at_a_wheel_is_no_steering(tmp_path, name):
    log = tmp_path / "log.csv"
    log.write_text(f"time_s,{name}\n0,5\n0.1,5\n")
    assert all(
        e.column != "steer_cmd_rad" for e in drafted(open_source(str(log))).entries
    )


def test_a_steering_wheel_in_degrees_by_its_rows_keeps_its_ratio():
    """Its header told the wheel, its rows tell the unit."""
    entry = Entry("steer_cmd_rad", "SteeringWheelAngle", "", 1 / 16, "of the wheel")
    mended = entry.times(0.01745329, "is in degrees")
    assert (mended.unit, mended.factor) == ("deg", pytest.approx(1 / 16))
    assert mended.because == "of the wheel; is in degrees"


@pytest.mark.parametrize("other", ["Speed [km/h]", "Gear"])
def test_a_wheels_speed_is_the_cars_where_no_other_is_logged(tmp_path, other):
    log = tmp_path / "ride.csv"
    log.write_text(f"t,WheelSpd_kmh,{other}\n0,1,1\n")
    by = {e.column: e.name for e in drafted(open_source(log)).entries}
    assert by["speed_mps"] == (other if other.startswith("S") else "WheelSpd_kmh")


def test_a_draft_reads_the_log_that_it_was_made_for(tmp_path):
    log, by = tmp_path / "ride.csv", tmp_path / "map.toml"
    rows = [
        f"2025-03-01 12:00:{k:02d}.5;{3.6 * k};{400 - k};{k / 2};7" for k in range(60)
    ]
    head = "Time;Vehicle Speed (km/h);HV Battery Voltage (V);Battery Current [A];Gear"
    log.write_text("\n".join([head, *rows]))
    with pytest.raises(InputError) as error:
        read_log(log)
    assert "--suggest-map" in error.value.hint
    done = rccsim("convert", log, "--suggest-map", "-o", by)
    assert done.returncode == 0, done.stderr
    draft = by.read_text()
    assert "#   Gear" in draft and 'unit = "date"' in draft
    trace = read_log(log, columns=by).trace
    np.testing.assert_allclose(np.diff(trace["time_s"]), 1.0)
    np.testing.assert_allclose(trace["speed_mps"], np.arange(60))
    np.testing.assert_allclose(trace["battery_current_a"], np.arange(60) / 2)


def test_the_shipped_map_of_a_real_logger_is_drafted_from_its_header(tmp_path):
    (i3,) = [m for m in shipped_maps() if m.name == "bmw_i3_tum"]
    log = tmp_path / "trip.csv"
    log.write_text(";".join(i3.header) + "\n" + ";".join("1" for _ in i3.header))
    draft = drafted(open_source(log)).toml()
    for column in ("time_s", "speed_mps", "motor_torque_nm", "battery_current_a"):
        (term,) = i3.columns[column]
        assert f'{column} = {{ from = "{term.sources[0]}"' in draft


def steered_rows(most, name="steering"):
    """A header of no known logger, and a steering that swings so far."""
    t = 0.1 * np.arange(100)
    steer = np.clip(1.5 * most * np.sin(t), -most, most)
    rows = (f"{x:.1f},1.5,{s:.6f}" for x, s in zip(t, steer, strict=True))
    return "\n".join([f"time,speed,{name}", *rows])


@pytest.mark.parametrize(
    ("most", "name", "column"),
    [
        (1.0, None, "steering"),
        (0.8, "dart_jetracer", "steering"),
        (0.8, None, "steer_cmd_rad"),
        (0.8, "rcc", "steer_cmd_rad"),
    ],
)
def test_a_steering_command_is_not_taken_for_an_angle(tmp_path, most, name, column):
    log = tmp_path / "run.csv"
    log.write_text(steered_rows(most))
    car = load_vehicle(name) if name else None
    draft, unread = checked_draft(open_source(log), car)
    assert unread is None
    assert [e.column for e in draft.entries if e.name == "steering"] == [column]


def test_a_header_that_says_minus_one_to_one_is_believed(tmp_path):
    log = tmp_path / "run.csv"
    for most, column in ((0.8, "steering"), (1.2, "steer_cmd_rad")):
        log.write_text(steered_rows(most, "steering [-1..1]"))
        draft, _ = checked_draft(open_source(log))
        assert [e.column for e in draft.entries][-1] == column


def test_a_file_that_a_shipped_map_reads_gets_that_map(tmp_path):
    dart = load_map("dart")
    log = tmp_path / "run.csv"
    row = ",".join("1" for _ in dart.header)
    log.write_text("\n".join([",".join(dart.header), row, row]))
    done = rccsim("convert", log, "--suggest-map")
    assert map_of(done.stdout, log).columns == dart.columns
    assert "shipped map dart" in done.stderr


def test_parquet_is_drafted_and_read_as_the_same_table_in_csv(tmp_path):
    t = np.arange(200) * 0.05
    table = {
        "Timestamp": [f"2026-05-01 10:00:{x:09.6f}" for x in t],
        "Velocity [km/h]": 36.0 * np.sin(t / 3.0) ** 2,
        "Battery Voltage [V]": np.full(len(t), 12.3),
        "gear": ["reverse" if x % 2 > 1.5 else "drive" for x in t],
        "lights": [bool(x > 5) for x in t],
    }
    parquet.write_table(pyarrow.table(table), tmp_path / "log.parquet")
    table["lights"] = [str(lit).lower() for lit in table["lights"]]
    rows = zip(*table.values(), strict=True)
    rows = [",".join(table), *(",".join(map(str, row)) for row in rows)]
    (tmp_path / "log.csv").write_text("\n".join(rows) + "\n")
    drafts, logs = [], []
    for name in ("log.csv", "log.parquet"):
        draft, unread = checked_draft(open_source(tmp_path / name))
        assert unread is None
        turned = "{ from = 'gear', equals = 'reverse' }"
        dark = "{ from = 'lights', equals = 'true' }"
        text = draft.toml().replace(
            'unit = "km/h"',
            f'unit = "km/h", negative_where = {turned}, blank_where = {dark}',
        )
        (tmp_path / "map.toml").write_text(text)
        drafts.append(draft.entries)
        logs.append(read_log(tmp_path / name, columns=tmp_path / "map.toml").trace)
    assert drafts[0] == drafts[1] and len(drafts[0]) == 3
    assert logs[0].columns.keys() == logs[1].columns.keys()
    for name, values in logs[0].columns.items():
        np.testing.assert_array_equal(values, logs[1][name])
    assert logs[1]["speed_mps"][35] < 0 and np.isnan(logs[1]["speed_mps"][150])
