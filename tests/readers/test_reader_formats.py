"""Every format gives the numbers of the drive that was written into it."""

from __future__ import annotations

import gzip
import io

import numpy as np
import pytest

from rcc_sim.errors import InputError
from rcc_sim.readers import on_one_clock, read_log, shipped_maps
from rcc_sim.readers.column_map import UNITS
from rcc_sim.trace import Trace, write_parquet, write_trace
from tests.readers import making
from tests.readers.making import ACCEL, CURRENT, ERPM, SPEED, STEER, TIME, VOLTAGE


def own(path):
    columns = {"time_s": TIME, "speed_mps": SPEED, "battery_current_a": CURRENT}
    with path.open("wb") as file:
        write_trace(Trace(columns), file)
    return path


# Our own columns


def test_our_own_columns_come_back_by_csv_gzip_parquet_and_pipe(tmp_path):
    path = own(tmp_path / "log.csv")
    packed = tmp_path / "log.csv.gz"
    packed.write_bytes(gzip.compress(path.read_bytes()))
    whole = read_log(path)
    parquet = tmp_path / "log.parquet"
    with parquet.open("wb") as file:
        write_parquet(whole.trace, file)
    pipe = read_log("-", stdin=io.BytesIO(path.read_bytes()))
    for log in (whole, read_log(packed), read_log(parquet), pipe):
        assert list(log.trace.columns) == ["time_s", "speed_mps", "battery_current_a"]
        for name, values in (("time_s", TIME), ("speed_mps", SPEED)):
            np.testing.assert_allclose(log.trace[name], values, atol=1e-9)
    assert (whole.reader, whole.guessed, whole.dropped) == ("rccsim", (), ())


def test_a_unit_that_is_not_ours_but_ends_a_name_is_converted(tmp_path):
    path = tmp_path / "log.csv"
    rows = [
        f"{1000 * t:.6f},{3.6 * v:.9f},{v:.9f}"
        for t, v in zip(TIME, SPEED, strict=True)
    ]
    path.write_text("\n".join(["time_ms,speed_kmh,speed_ms", *rows]) + "\n")
    log = read_log(path)
    np.testing.assert_allclose(log.trace["time_s"], TIME, atol=1e-8)
    np.testing.assert_allclose(log.trace["speed_mps"], SPEED, atol=1e-8)
    np.testing.assert_allclose(log.trace["speed_ms"], SPEED, atol=1e-8)  # not a time
    assert "speed_mps from speed_kmh × 0.277777778" in [m.line() for m in log.mapped]


def test_what_stands_in_our_unit_too_is_not_converted_over_it(tmp_path):
    path = tmp_path / "log.csv"
    path.write_text("time_s,speed_mps,speed_kmh\n0,1,9\n1,2,9\n2,3,9\n")
    trace = read_log(path).trace
    assert trace["speed_mps"].tolist() == [1, 2, 3]
    assert trace["speed_kmh"].tolist() == [9, 9, 9]


def test_two_units_of_one_channel_are_both_kept(tmp_path):
    path = tmp_path / "log.csv"
    path.write_text("time_s,speed_kmh,speed_mph\n0,36,9\n1,72,8\n2,36,7\n")
    trace = read_log(path).trace
    assert trace["speed_mps"].tolist() == pytest.approx([10, 20, 10])
    assert trace["speed_mph"].tolist() == [9, 8, 7]


def test_rows_are_kept_where_time_stands_jumps_or_is_blank(tmp_path):
    path = tmp_path / "log.csv"
    path.write_text("time_s,speed_mps\n0,1\n0,2\n5,3\n4,4\n,5\n6,\n\n7,nan\n8,inf\n")
    log = read_log(path)
    expected = [0, 0, 5, 4, np.nan, 6, 7, 8]
    np.testing.assert_array_equal(log.trace["time_s"], expected)
    speeds = [1, 2, 3, 4, 5, np.nan, np.nan, np.nan]
    np.testing.assert_array_equal(log.trace["speed_mps"], speeds)
    assert any("infinite" in note and "row 8" in note for note in log.notes)


def test_words_under_a_name_that_is_not_ours_are_dropped_and_said(tmp_path):
    path = tmp_path / "log.csv"
    path.write_text("time_s,mode,speed_mps\n0,D,1\n1,R,2\n")
    log = read_log(path)
    assert log.dropped == ("mode",)
    assert list(log.trace.columns) == ["time_s", "speed_mps"]


def test_stamps_of_an_epoch_count_from_the_first_second_so_that_csv_holds_them(
    tmp_path,
):
    path = tmp_path / "log.csv"
    start = 1_700_000_000
    rows = [f"{start + k / 100:.2f},{k}" for k in range(300)]
    path.write_text("time_s,speed_mps\n" + "\n".join(rows))
    log = read_log(path)
    np.testing.assert_allclose(log.trace["time_s"], np.arange(300) / 100, atol=1e-6)
    assert "time_s 0 is 2023-11-14T22:13:20Z" in log.notes


def test_windows_dashes_and_byte_order_marks_do_not_hide_a_log(tmp_path):
    path = tmp_path / "log.csv"
    path.write_bytes(b"\xef\xbb\xbftime_s,speed_mps,note\r\n0,1,a\r\n1,2,b\r\n")
    np.testing.assert_array_equal(read_log(path).trace["time_s"], [0, 1])
    path.write_bytes(b"time_s,speed_mps,a \x96 b\n0,1,x\n1,2,y\n")
    np.testing.assert_array_equal(read_log(path).trace["speed_mps"], [1, 2])
    path.write_bytes("time_s,speed_mps\n0,1\n1,2\n".encode("utf-16"))
    np.testing.assert_array_equal(read_log(path).trace["speed_mps"], [1, 2])


# VESC Tool


def test_what_a_spreadsheet_says_to_itself_is_no_header(tmp_path):
    path = tmp_path / "log.csv"
    path.write_text("\ufeffsep=;\ntime_s;speed_mps\n0;0,5\n1;0,75\n", "utf-8")
    log = read_log(path).trace
    assert log["speed_mps"].tolist() == [0.5, 0.75]


def test_a_vesc_tool_log_is_si(tmp_path):
    log = read_log(making.write_vesc(tmp_path / "ride.csv"))
    trace = log.trace
    assert log.reader == "vesc_tool"
    np.testing.assert_allclose(trace["time_s"], 1 + TIME, atol=1e-9)
    np.testing.assert_allclose(trace["speed_mps"], SPEED)
    np.testing.assert_allclose(trace["motor_speed_erpm"], ERPM)
    np.testing.assert_allclose(trace["battery_current_a"], CURRENT)
    np.testing.assert_allclose(trace["battery_voltage_v"], VOLTAGE)
    np.testing.assert_allclose(trace["accel_x_mps2"], ACCEL, atol=1e-12)
    np.testing.assert_allclose(trace["yaw_rate_radps"], making.YAW_RATE, atol=1e-12)
    assert "fault_code" in log.dropped and "" not in log.dropped


def test_a_vesc_tool_log_goes_on_over_midnight(tmp_path):
    log = read_log(making.write_vesc(tmp_path / "ride.csv", start_ms=86_398_000))
    np.testing.assert_allclose(log.trace["time_s"], 86_398 + TIME, atol=1e-9)


def test_what_a_vesc_does_not_have_is_blank_or_left_out(tmp_path):
    log = read_log(making.write_vesc(tmp_path / "ride.csv", imu=False))
    for name in ("yaw_rate_radps", "accel_x_mps2", "accel_y_mps2", "elevation_m"):
        assert np.isnan(log.trace[name]).all()
    assert "motor_temperature_degc" not in log.trace
    assert [flaw.channel for flaw in log.flaws if flaw.kind == "dead"] == ["temp_motor"]


@pytest.mark.parametrize("encoding", ["latin-1", "utf-16"])
def test_words_of_any_encoding_are_told_as_they_stand(tmp_path, encoding):
    path = tmp_path / "log.csv"
    path.write_bytes("time_s,speed_mps\n0,1\n1,2\n2,été\n".encode(encoding))
    with pytest.raises(InputError, match=r"speed_mps, row 3: .*number: 'été'"):
        read_log(path)
    path.write_bytes("time_s,état\n0,1\n1,é,2\n2,3\n".encode(encoding))
    with pytest.raises(InputError, match="row 2: should have 2 fields") as told:
        read_log(path)
    assert told.value.hint.endswith("1,é,2")


# Column maps

MAP = """
[map]
separator = "semicolon"
encoding = "latin-1"
decimal = ","
skip_rows = 1

[columns]
time_s = { from = "Zeit", unit = "ms" }
speed_mps = { from = "Geschwindigkeit", unit = "km/h" }
battery_current_a = { from = "Strom", sign = -1 }
steer_cmd_rad = { from = "Lenkung °", unit = "deg", offset = 0.02 }
aux_power_w = { sum = [{ from = "Heizung", unit = "kW" }, { from = "Klima" }] }
"""
TABLE = (
    "made by a logger\n"
    "Zeit ;Geschwindigkeit;Strom; Lenkung °;Heizung;Klima;Notiz\n"
    "0;36,0;-2,5;10;1,5;200;gut\n"
    "500;72,0;3,5;-10;0;100;schlecht\n"
)


def test_a_map_gives_units_signs_sums_and_reads_a_decimal_comma(tmp_path):
    (tmp_path / "log.csv").write_bytes(TABLE.encode("latin-1"))
    (tmp_path / "map.toml").write_text(MAP)
    log = read_log(tmp_path / "log.csv", columns=tmp_path / "map.toml")
    trace = log.trace
    np.testing.assert_allclose(trace["time_s"], [0, 0.5])
    np.testing.assert_allclose(trace["speed_mps"], [10, 20])
    np.testing.assert_allclose(trace["battery_current_a"], [2.5, -3.5])
    np.testing.assert_allclose(trace["aux_power_w"], [1700, 100])
    np.testing.assert_allclose(
        trace["steer_cmd_rad"], np.radians([10, -10]) + 0.02, rtol=1e-12
    )
    assert log.dropped == ("Notiz",)


def test_a_file_without_a_clock_counts_by_its_rate(tmp_path):
    (tmp_path / "log.csv").write_text("v\n1\n2\n3\n")
    text = '[map]\nrate_hz = 4\n[columns]\nspeed_mps = "v"\n'
    (tmp_path / "map.toml").write_text(text)
    log = read_log(tmp_path / "log.csv", columns=tmp_path / "map.toml")
    np.testing.assert_array_equal(log.trace["time_s"], [0, 0.25, 0.5])
    assert "no clock" in log.guessed[0]


def test_a_clock_of_hours_goes_on_over_midnight_and_reverse_is_negative(tmp_path):
    (tmp_path / "log.csv").write_text(
        "T,v,gear\n23:59:59,3.6,D\n00:00:00,7.2,D\n00:00:01.5,3.6,R\n"
    )
    (tmp_path / "map.toml").write_text(
        '[columns]\ntime_s = { from = "T", unit = "h:m:s", wrap_s = 86400 }\n'
        'speed_mps = { from = "v", unit = "km/h", '
        'negative_where = { from = "gear", equals = "R" } }\n'
    )
    trace = read_log(tmp_path / "log.csv", columns=tmp_path / "map.toml").trace
    np.testing.assert_allclose(trace["time_s"], [86399, 86400, 86401.5])
    np.testing.assert_allclose(trace["speed_mps"], [1, 2, -1])


def test_a_clock_may_have_a_decimal_comma(tmp_path):
    (tmp_path / "log.csv").write_text("T;v\n08:15:00,990;0,5\n08:15:02,020;1,5\n")
    (tmp_path / "map.toml").write_text(
        '[columns]\ntime_s = { from = "T", unit = "h:m:s" }\nspeed_mps = "v"\n'
    )
    trace = read_log(tmp_path / "log.csv", columns=tmp_path / "map.toml").trace
    np.testing.assert_allclose(np.diff(trace["time_s"]), [1.03])
    np.testing.assert_allclose(trace["speed_mps"], [0.5, 1.5])


def test_dates_are_seconds_since_1970_whatever_their_zone(tmp_path):
    log, by = tmp_path / "log.csv", tmp_path / "map.toml"
    log.write_text(
        "T,v\n1970-01-02 00:00:00.25,1\n1970-01-02T00:00:01Z,2\n"
        "1970-01-02T02:00:02.5+02:00,3\n"
    )
    by.write_text(
        '[columns]\ntime_s = { from = "T", unit = "date" }\nspeed_mps = "v"\n'
    )
    trace = read_log(log, columns=by).trace
    np.testing.assert_allclose(trace["time_s"], [86400.25, 86401, 86402.5])
    log.write_text("T,v\n1970-01-02 00:00:00,1\n1970-01-02 0:1,2\n")
    with pytest.raises(InputError, match=r"T, row 2: should be a date.*0:1"):
        read_log(log, columns=by)


def test_ten_tenths_that_a_logger_did_not_carry_are_carried(tmp_path):
    header = "throttle,rps,adjust,acc_x,acc_y,acc_z,mag_x,mag_y,mag_z,gyr_z\n"
    rows = "6,1.10,0,-52.10,0.10,1,0,0,0,0\n6,2.0,0,-53.0,1.0,1,0,0,0,0\n"
    (tmp_path / "log.csv").write_text(header + rows)
    trace = read_log(tmp_path / "log.csv").trace
    for column in ("motor_speed_radps", "accel_x_mps2", "accel_y_mps2"):
        assert trace[column][0] == pytest.approx(trace[column][1], rel=1e-12)


def test_a_column_whose_factor_the_file_lacks_is_told_to_be_left_out(tmp_path):
    (dart,) = [m for m in shipped_maps() if m.name == "dart"]
    names = [n for n in dart.header if n != "safety_value"]
    rows = [",".join([str(k), *["1"] * (len(names) - 1)]) for k in range(1, 4)]
    (tmp_path / "log.csv").write_text("\n".join([",".join(names), *rows]))
    log = read_log(tmp_path / "log.csv", columns="dart")
    assert "throttle" not in log.trace
    assert "throttle" in log.dropped
    assert any("throttle: no safety_value" in note for note in log.notes)


def test_rows_before_the_first_sensor_message_are_blank(tmp_path):
    (dart,) = [m for m in shipped_maps() if m.name == "dart_vicon"]
    zeros, rest = [], []
    for name in dart.header:
        zeros.append("100" if name == "vicon time" else "0")
        rest.append({"vicon time": "100.1", "throttle": "0.4"}.get(name, "1"))
    lines = [",".join(dart.header), ",".join(zeros), ",".join(rest)]
    (tmp_path / "log.csv").write_text("\n".join(lines))
    trace = read_log(tmp_path / "log.csv").trace
    np.testing.assert_array_equal(trace["speed_mps"], [np.nan, 1])
    np.testing.assert_array_equal(trace["throttle"], [np.nan, 0.4])
    np.testing.assert_array_equal(trace["x_m"], [0, 1])


@pytest.mark.parametrize("by", shipped_maps(), ids=lambda m: m.name)
def test_a_shipped_map_says_what_it_is_for_and_where_that_is_known_from(by):
    assert by.title and by.origin
    assert all(
        unit in UNITS for t in by.columns.values() for p in t if (unit := p.unit)
    )


# Bags

STARTS = pytest.mark.parametrize("start", [0, 1_700_000_000_000_000_000])


def assert_the_drive(log):
    trace = log.trace
    drive = on_one_clock(trace)
    t0 = drive["time_s"][0]
    np.testing.assert_allclose(drive["time_s"] - t0, TIME, atol=1e-9)
    np.testing.assert_array_equal(drive["speed_mps"], SPEED)
    np.testing.assert_array_equal(drive["motor_speed_erpm"], ERPM)
    np.testing.assert_array_equal(drive["battery_voltage_v"], VOLTAGE)
    np.testing.assert_array_equal(drive["battery_current_a"], CURRENT)
    np.testing.assert_allclose(drive["accel_x_mps2"], ACCEL / 10, atol=1e-12)
    np.testing.assert_allclose(drive["yaw_rate_radps"], making.YAW_RATE, atol=1e-12)
    said = np.isfinite(trace["steer_cmd_rad"])
    np.testing.assert_array_equal(
        trace["steer_cmd_rad"][said], STEER[::5].astype(np.float32)
    )
    assert np.isnan(drive["steer_cmd_rad"][0])  # no command before the first
    np.testing.assert_array_equal(
        drive["steer_cmd_rad"][1:6], np.full(5, np.float32(STEER[0]))
    )


@STARTS
@pytest.mark.parametrize("in_g", [True, False])
def test_an_mcap_bag_gives_the_drive_whatever_the_imus_unit(tmp_path, start, in_g):
    bag = making.write_bag(
        tmp_path / "bag", making.stores()[0], start_ns=start, imu_in_g=in_g
    )
    log = read_log(bag)
    assert_the_drive(log)
    assert any("g and deg/s" in guess for guess in log.guessed) == in_g


@pytest.mark.parametrize("layout", [0, 1], ids=["new VescState", "old VescState"])
def test_an_sqlite3_bag_without_definitions_gives_the_drive(tmp_path, layout):
    store = making.stores()[layout]
    bag = making.write_bag(tmp_path / "bag", store, "SQLITE3")
    log = read_log(making.without_definitions(bag))
    assert_the_drive(log)


def test_a_bag_is_the_same_by_ros1_sqlite3_mcap_folder_and_file(tmp_path):
    bag = making.write_bag(tmp_path / "a", making.stores()[1], "SQLITE3")
    one = making.convert_bag(bag, tmp_path / "one.bag")
    two = making.convert_bag(one, tmp_path / "two", "mcap")
    packed = tmp_path / "one.bag.gz"
    packed.write_bytes(gzip.compress(one.read_bytes()))
    files = [*bag.glob("*.db3"), *two.glob("*.mcap")]
    first = read_log(bag)
    assert_the_drive(first)
    for path in (one, two, packed, *files):
        trace = read_log(path).trace
        assert set(trace.columns) == set(first.trace.columns)
        for name, values in first.trace.columns.items():
            np.testing.assert_array_equal(trace[name], values)


def test_the_vescs_own_imu_message_is_read_without_its_definition(tmp_path):
    from rosbags.rosbag2 import StoragePlugin, Writer

    store, kind = making.stores()[0], "vesc_msgs/msg/VescImuStamped"
    plugin = StoragePlugin.SQLITE3
    with Writer(tmp_path / "bag", version=8, storage_plugin=plugin) as bag:
        link = bag.add_connection("/vesc/sensors/imu", kind, typestore=store)
        for k in range(5):
            values = {
                "imu.linear_acceleration.x": 0.1,
                "imu.linear_acceleration.z": 1.0,
                "imu.angular_velocity.z": 90.0,
            }
            message = making.filled(
                store, kind, header=making.header(store, k * 10**8), **values
            )
            bag.write(link, k * 10**8, store.serialize_cdr(message, kind))
    making.without_definitions(tmp_path / "bag")
    log = read_log(tmp_path / "bag")
    np.testing.assert_allclose(log.trace["accel_x_mps2"], 0.1 * making.G)
    np.testing.assert_allclose(log.trace["yaw_rate_radps"], np.pi / 2)
    assert any("g and deg/s" in guess for guess in log.guessed)


def test_a_topic_in_the_cars_namespace_is_found(tmp_path):
    text = (
        '[map]\nformat = "bag"\n[columns]\nspeed_mps = "/*/odom:twist.twist.linear.x"'
    )
    (tmp_path / "map.toml").write_text(text)
    store = making.stores()[0]
    message = making.filled(
        store, "nav_msgs/msg/Odometry", **{"twist.twist.linear.x": 7.0}
    )
    extra = [("/ego/odom", "nav_msgs/msg/Odometry", k, message) for k in (1, 2)]
    bag = making.write_bag(tmp_path / "bag", store, extra=extra)
    log = read_log(bag, columns=tmp_path / "map.toml")
    np.testing.assert_array_equal(log.trace["speed_mps"], [7, 7])
    assert any(name.startswith("/odom ") for name in log.dropped)


# MDF


def test_csv_to_mf4_and_back_is_the_same(tmp_path):
    asammdf = pytest.importorskip("asammdf")
    log = read_log(own(tmp_path / "log.csv"))
    t = log.trace["time_s"]
    half = slice(None, None, 2)
    with asammdf.MDF(version="4.10") as file:
        file.append([asammdf.Signal(log.trace["speed_mps"], t, name="speed_mps")])
        slow = log.trace["battery_current_a"][half]
        file.append([asammdf.Signal(slow, t[half], name="battery_current_a")])
        file.append([asammdf.Signal(slow, t[half], name="Engine.Something")])
        file.save(tmp_path / "log.mf4")
    back = read_log(tmp_path / "log.mf4")
    np.testing.assert_array_equal(back.trace["time_s"], t)
    np.testing.assert_array_equal(back.trace["speed_mps"], log.trace["speed_mps"])
    np.testing.assert_array_equal(back.trace["battery_current_a"][half], slow)
    assert np.isnan(back.trace["battery_current_a"][1::2]).all()
    assert back.dropped == ("Engine.Something",)


def test_a_map_reads_an_mf4_of_any_names(tmp_path):
    asammdf = pytest.importorskip("asammdf")
    with asammdf.MDF(version="4.10") as file:
        file.append([asammdf.Signal(SPEED * 3.6, TIME, name="VehSpd")])
        file.save(tmp_path / "log.mf4")
    text = '[columns]\nspeed_mps = { from = "VehSpd", unit = "km/h" }\n'
    (tmp_path / "map.toml").write_text(text)
    log = read_log(tmp_path / "log.mf4", columns=tmp_path / "map.toml")
    np.testing.assert_allclose(log.trace["speed_mps"], SPEED)


# One clock


def test_on_one_clock_holds_commands_and_interpolates_what_was_measured():
    nan = np.nan
    trace = Trace(
        {
            "time_s": np.array([0.0, 1, 2, 3, 4]),
            "speed_mps": np.array([nan, 10, nan, 30, 40]),
            "throttle": np.array([0.5, nan, 0.7, nan, nan]),
            "yaw_rate_radps": np.array([0.0, nan, 2, nan, nan]),
        }
    )
    one = on_one_clock(trace)
    np.testing.assert_array_equal(one["time_s"], [1, 3, 4])
    np.testing.assert_array_equal(one["throttle"], [0.5, 0.7, 0.7])
    np.testing.assert_array_equal(one["yaw_rate_radps"], [1, nan, nan])


def test_on_one_clock_leaves_a_gap_blank_and_turns_the_short_way():
    time = np.arange(0.0, 10.0, 0.05)
    heading = (2 * time + np.pi) % (2 * np.pi) - np.pi
    pose = (np.arange(len(time)) % 2 == 0) & ~((time > 4) & (time < 6))
    trace = Trace(
        {
            "time_s": time,
            "speed_mps": np.ones(len(time)),
            "yaw_rad": np.where(pose, heading, np.nan),
        }
    )
    one = on_one_clock(trace)
    in_gap = (time > 4.01) & (time < 5.99)
    assert np.isnan(one["yaw_rad"][in_gap]).all()
    there = ~in_gap & (time <= time[pose][-1])
    off = np.angle(np.exp(1j * (one["yaw_rad"] - heading)))[there]
    np.testing.assert_allclose(off, 0, atol=1e-9)
    np.testing.assert_array_equal(one["yaw_rad"][pose], heading[pose])


def test_on_one_clock_a_channel_without_any_value_stays_blank():
    time = np.arange(4.0)
    blank = {n: np.full(4, np.nan) for n in ("throttle", "battery_voltage_v")}
    one = on_one_clock(Trace({"time_s": time, "speed_mps": time, **blank}))
    for name in blank:
        assert np.isnan(one[name]).all()
