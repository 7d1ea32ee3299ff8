"""Sensors that are dead, held, stuck, clipped, coarse, late, biased, or jump."""

from __future__ import annotations

import functools
import time

import numpy as np
import pytest
from drives import CAR, ROVER, TRUCK, driven, logged, with_fault

from rcc_sim.analyse.logcheck import check_log
from rcc_sim.definitions.vehicle import load_vehicle
from rcc_sim.errors import InputError
from rcc_sim.trace import Trace
from rcc_sim.units import G
from tests import one_loop

SENSORS = [
    *("speed_mps", "yaw_rate_radps", "accel_x_mps2", "accel_y_mps2"),
    *("battery_voltage_v", "battery_current_a", "battery_power_w"),
]
FEW = [CAR, ROVER, TRUCK]
each_drive = pytest.mark.parametrize("drive", FEW, ids=lambda d: d[0])
each_sensor = pytest.mark.parametrize("channel", SENSORS)


def found(checked, kind, channel):
    return [f for f in checked.findings if (f.kind, f.channel) == (kind, channel)]


def grave(checked):
    return {(f.kind, f.channel) for f in checked.findings if f.severity != "info"}


@each_drive
@pytest.mark.parametrize("channel", SENSORS[1:])
@pytest.mark.parametrize("value", [0.0, np.nan])
def test_a_dead_channel_is_removed_and_said_so(drive, channel, value):
    checked = check_log(with_fault(logged(*drive), channel, lambda x: x * 0 + value))
    (finding,) = found(checked, "dead", channel)
    assert finding.severity == "error"
    assert channel not in checked.trace
    assert grave(checked) == {("dead", channel)}


def test_a_car_that_drove_straight_in_a_model_has_no_dead_sensor():
    trace = driven("rcc", "hwfet[0:200]", 50, None)
    assert not np.any(trace["yaw_rate_radps"])
    checked = check_log(trace)
    assert not checked.unusable
    assert found(checked, "constant", "yaw_rate_radps")


@each_drive
@each_sensor
def test_a_channel_that_updates_every_fifth_row_is_known_as_slow(drive, channel):
    log = logged(*drive)
    slow = np.arange(len(log)) // 5 * 5
    checked = check_log(with_fault(log, channel, lambda x: x[slow]))
    (finding,) = found(checked, "slow_channel", channel)
    assert "every 5 rows" in finding.what
    assert finding.severity == "info"


def test_ramps_in_whole_kmh_are_no_slow_channel():
    """As a dashboard shows them, between speeds that a cruise control holds."""
    t = np.arange(0.0, 200.0, 0.1)
    ramps = np.interp(
        t, [0, 10, 20, 50, 60, 120, 130, 140], [0, 0, 14, 14, 25, 25, 0, 0]
    )
    speed = np.round(3.6 * ramps) / 3.6
    power = 5000 + 100 * np.random.default_rng(1).normal(size=len(t))
    log = Trace({"time_s": t, "speed_mps": speed, "battery_power_w": power}, name="x")
    checked = check_log(log)
    assert not found(checked, "slow_channel", "speed_mps")
    came = speed[np.arange(len(t)) // 5 * 5]  # twice a second: it leaps by several
    seldom = Trace({**log.columns, "speed_mps": came}, name="x")
    assert found(check_log(seldom), "slow_channel", "speed_mps")


@each_drive
@pytest.mark.parametrize(
    "channel", ["speed_mps", "yaw_rate_radps", "accel_x_mps2", "accel_y_mps2"]
)
def test_a_channel_that_freezes_while_the_car_drives_is_masked_there(drive, channel):
    log = logged(*drive)
    t, v = log["time_s"], log["speed_mps"]
    length = max(30, round(2 / np.median(np.diff(t))))
    fast = np.convolve(v > 0.3 * v.max(), np.ones(length), "valid")
    first = int(np.argmax(fast))

    def freeze(x):
        x[first : first + length] = x[first]
        return x

    checked = check_log(with_fault(log, channel, freeze))
    (finding,) = found(checked, "stuck", channel)
    assert finding.start_s == pytest.approx(t[first], abs=0.11)
    empty = np.isnan(checked.trace[channel])
    assert empty[first + 1 : first + length].all()
    assert empty.sum() <= length


def test_every_stretch_that_is_stuck_is_masked():
    log = logged(*ROVER)
    fast = np.flatnonzero(log["speed_mps"] > 0.5 * log["speed_mps"].max())
    firsts = [int(fast[0]), int(fast[-1]) - 150]

    def freeze(x):
        for first, length in zip(firsts, (100, 150), strict=True):
            x[first : first + length] = x[first]
        return x

    checked = check_log(with_fault(log, "accel_x_mps2", freeze))
    (finding,) = found(checked, "stuck", "accel_x_mps2")
    assert "2 times" in finding.what
    assert np.isnan(checked.trace["accel_x_mps2"]).sum() == 99 + 149


@each_drive
@each_sensor
def test_spikes_are_found_row_by_row(drive, channel):
    log = logged(*drive)
    rows = np.linspace(50, len(log) - 50, 8).astype(int)

    def spoil(x):
        x[rows] += 6 * np.ptp(x)
        return x

    checked = check_log(with_fault(log, channel, spoil))
    assert found(checked, "glitch", channel)
    assert np.array_equal(np.flatnonzero(np.isnan(checked.trace[channel])), rows)


@each_drive
@pytest.mark.parametrize("channel", ["yaw_rate_radps", "accel_x_mps2", "accel_y_mps2"])
def test_a_sensor_at_the_end_of_its_range_is_found(drive, channel):
    log = logged(*drive)
    wall = float(np.quantile(np.abs(log[channel]), 0.93))
    checked = check_log(with_fault(log, channel, lambda x: np.clip(x, -wall, wall)))
    assert grave(checked) == {("saturated", channel)}


@each_drive
@pytest.mark.parametrize("channel", ["yaw_rate_radps", "accel_x_mps2", "accel_y_mps2"])
def test_a_wall_that_noise_leaves_at_once_is_found(drive, channel):
    """Rows one by one: of readings that never repeat, eight alike are no chance."""
    log = logged(*drive)
    rng = np.random.default_rng(3)
    shaken = log[channel] + np.std(log[channel]) * rng.standard_normal(len(log))
    wall = float(np.quantile(shaken, 0.995))
    for reads in (lambda x: shaken, lambda x: np.minimum(shaken, wall)):
        checked = check_log(with_fault(log, channel, reads))
        walls = found(checked, "saturated", channel)
        assert len(walls) == (reads(0).max() == wall)


@each_drive
@pytest.mark.parametrize("channel", ["yaw_rate_radps", "accel_x_mps2", "accel_y_mps2"])
@pytest.mark.parametrize("digits", [4, 12, 40, 400])
def test_a_coarse_sensor_within_its_range_is_at_no_wall(drive, channel, digits):
    log = logged(*drive)
    rng = np.random.default_rng(4)
    shaken = log[channel] + np.std(log[channel]) * rng.standard_normal(len(log))
    step = np.ptp(shaken) / digits
    checked = check_log(
        with_fault(log, channel, lambda x: step * np.round(shaken / step))
    )
    assert not found(checked, "saturated", channel)


@each_drive
@pytest.mark.parametrize("seconds", [-3.0, -1.2, 1.2, 3.0])
@pytest.mark.parametrize(
    "channel", ["accel_x_mps2", "accel_y_mps2", "yaw_rate_radps", "motor_speed_radps"]
)
def test_a_clock_of_its_own_is_found_and_measured(drive, channel, seconds):
    log = logged(*drive)
    t = log["time_s"]
    rng = np.random.default_rng(1)
    noise = 1e-9 * rng.standard_normal(len(t))  # the ends of the shift would be held
    checked = check_log(
        with_fault(log, channel, lambda x: np.interp(t - seconds, t, x) + noise)
    )
    (finding,) = found(checked, "clock_offset", channel)
    assert finding.severity == "warning"
    side = "after" if seconds > 0 else "before"
    assert side in finding.what
    said = float(finding.what.split()[1])
    slip = 0.35 if channel == "accel_y_mps2" else 0.15  # sideslip has a lag of its own
    assert said == pytest.approx(abs(seconds), abs=slip)


@pytest.mark.parametrize("bias", [-0.5, -0.3, 0.25])
@pytest.mark.parametrize("channel", ["accel_x_mps2", "accel_y_mps2", "yaw_rate_radps"])
def test_a_bias_is_read_off_where_the_car_stands(channel, bias):
    checked = check_log(with_fault(logged(*CAR), channel, lambda x: x + bias))
    (finding,) = found(checked, "bias", channel)
    assert finding.severity == "info"
    said, doubt = (float(word) for word in finding.what.split()[1:4:2])
    assert said == pytest.approx(bias, abs=max(5 * doubt, 0.01))


def test_first_rows_of_zeros_are_left_out():
    log = logged(*CAR)
    columns = {n: v.copy() for n, v in log.columns.items()}
    for name in columns.keys() - {"time_s"}:
        columns[name][:15] = 0.0
    checked = check_log(Trace(columns))
    assert checked.trace["time_s"][0] == log["time_s"][15]
    assert {kind for kind, _ in grave(checked)} == {"zero_start"}


def test_a_log_in_milliseconds_is_checked_as_the_same_in_seconds():
    log = logged(*CAR)
    columns = {n: v.copy() for n, v in log.columns.items() if n != "yaw_rate_radps"}
    for name in columns.keys() - {"time_s"}:
        columns[name][:15] = 0.0
    columns["accel_y_mps2"][:] = 0.0  # noisy sensors beside it: it is dead
    columns = {n: np.delete(v, slice(500, 531)) for n, v in columns.items()}
    one = check_log(Trace(columns))
    other = check_log(Trace({**columns, "time_s": 1e3 * columns["time_s"]}))
    told = {f.kind: (f.what, f.where) for f in one.findings}
    assert {"gap", "zero_start", "dead"} <= told.keys()
    again = {f.kind: (f.what, f.where) for f in other.findings}
    assert again.keys() - told.keys() == {"time_unit"}
    for kind in ("gap", "zero_start", "dead"):
        assert again[kind] == told[kind]


@each_drive
def test_a_command_that_starts_while_the_car_drives_is_late(drive):
    log = logged(*drive)
    speed = log["speed_mps"]
    first = int(np.argmax(speed > 0.8 * speed.max()))

    def late(x):
        x[:first] = 0.0
        return x

    checked = check_log(with_fault(log, "speed_ref_mps", late))
    (finding,) = found(checked, "late_command", "speed_ref_mps")
    assert finding.end_s == pytest.approx(log["time_s"][first])


def test_reversing_is_reported_by_window():
    time_s = np.arange(0, 60, 0.05)
    speed = np.clip(np.sin(time_s / 3), -0.4, 1) + np.random.default_rng(0).normal(
        0, 0.005, len(time_s)
    )
    checked = check_log(Trace({"time_s": time_s, "speed_mps": speed}))
    (finding,) = found(checked, "reversing", "speed_mps")
    turns = [3 * np.pi * k for k in range(1, 7)]
    assert finding.start_s == pytest.approx(turns[0], abs=0.3)
    assert finding.where.count("–") == 3


def test_a_place_that_jumps_for_good_is_reported():
    def jump(x):
        x[len(x) // 2 :] += 40.0
        return x

    log = logged(*CAR)
    checked = check_log(with_fault(log, "x_m", jump))
    (finding,) = found(checked, "pose_jump", "x_m")
    assert finding.start_s == pytest.approx(log["time_s"][len(log) // 2])


def climbing(lost):
    """Heights of a hilly road in whole metres, as a receiver tells them, some lost."""
    log = logged(*TRUCK)
    time = log["time_s"]
    way = np.concatenate([[0], np.cumsum(log["speed_mps"][1:] * np.diff(time))])
    height = 80 + 30 * np.sin(way / 400)
    return Trace({**log.columns, "elevation_m": np.round(lost(height))}, name="hills")


def test_a_height_that_leaps_there_and_back_is_masked():
    def lose(x):
        x[300:340] = -111.0
        return x

    assert not [f for f in check_log(climbing(lambda x: x)).findings
                if f.kind == "height_leap"]  # fmt: skip
    checked = check_log(climbing(lose))
    (finding,) = found(checked, "height_leap", "elevation_m")
    assert finding.severity == "warning"
    assert finding.action.startswith("40 rows")
    assert not found(checked, "missing", "elevation_m")
    lost = np.isnan(checked.trace["elevation_m"])
    np.testing.assert_array_equal(np.flatnonzero(lost), np.arange(300, 340))


def test_a_height_that_leaps_for_good_is_said_and_left():
    def step(x):
        x[len(x) // 2 :] += 200.0
        return x

    checked = check_log(climbing(step))
    (finding,) = found(checked, "height_leap", "elevation_m")
    assert "not mended" in finding.action
    assert np.isfinite(checked.trace["elevation_m"]).all()


def test_missing_values_stay_missing_and_are_reported():
    def lose(x):
        x[300:700] = np.nan
        return x

    checked = check_log(with_fault(logged(*CAR), "accel_x_mps2", lose))
    (finding,) = found(checked, "missing", "accel_x_mps2")
    assert finding.severity == "warning"
    assert np.isnan(checked.trace["accel_x_mps2"]).sum() == 400


def test_a_channel_of_a_slower_topic_is_no_loss():
    def thin(x):
        x[np.arange(len(x)) % 10 != 0] = np.nan
        return x

    log = with_fault(logged(*CAR), "battery_voltage_v", thin)
    checked = check_log(log, load_vehicle("rcc"))
    assert found(checked, "sparse", "battery_voltage_v")
    assert not grave(checked)


@pytest.mark.parametrize(
    ("columns", "words"),
    [
        ({"speed_mps": np.arange(9.0)}, "no column time_s"),
        ({"time_s": np.arange(9.0)}, "no channel"),
        ({"time_s": np.arange(1.0), "speed_mps": np.ones(1)}, "no log"),
        ({"time_s": np.full(9, np.nan), "speed_mps": np.ones(9)}, "usable rows"),
        ({"time_s": np.arange(9.0), "speed_mps": np.full(9, np.nan)}, "no channel"),
        ({"time_s": np.zeros(9), "speed_mps": np.ones(9)}, "usable rows"),
    ],
)
def test_what_is_no_log_is_refused(columns, words):
    with pytest.raises(InputError, match=words):
        check_log(Trace(columns, name="x.csv"))


def test_a_log_of_75_seconds_at_100_hertz_takes_a_blink():
    log = logged(*ROVER)
    log = Trace({n: v[:7500] for n, v in list(log.columns.items())[:10]})
    check_log(log)
    start = time.process_time()
    check_log(log)
    assert time.process_time() - start < 0.1


@pytest.mark.slow
def test_ten_hours_at_100_hertz_take_seconds():
    log = logged(*ROVER)
    many = 3_600_000 // len(log) + 1
    names = [n for n in log.columns if n != "time_s"][:9]
    columns = {n: np.tile(log[n], many)[:3_600_000] for n in names}
    columns = {"time_s": np.arange(3_600_000) * 0.01, **columns}
    start = time.process_time()
    checked = check_log(Trace(columns))
    assert time.process_time() - start < 6
    assert len(checked.trace) == 3_600_000


def test_steering_that_is_logged_from_halfway_on_is_late():
    log = logged(*ROVER)

    def late(x):
        x[: len(x) // 2] = 0.0
        return x

    checked = check_log(with_fault(log, "steer_cmd_rad", late))
    assert found(checked, "late_command", "steer_cmd_rad")


@each_drive
@pytest.mark.parametrize("bias", [-0.4, 0.1, 0.4])
def test_a_gyro_with_a_bias_does_not_make_the_steering_late(drive, bias):
    log = with_fault(logged(*drive), "yaw_rate_radps", lambda x: x + bias)
    assert not found(check_log(log), "late_command", "steer_cmd_rad")


@pytest.mark.parametrize("drive", [ROVER, TRUCK], ids=lambda d: d[0])
@pytest.mark.parametrize("channel", ["battery_current_a", "battery_power_w"])
def test_a_current_that_lost_its_sign_is_known(drive, channel):
    log = logged(*drive)
    assert log[channel].min() < -0.1 * log[channel].max()
    (finding,) = found(check_log(with_fault(log, channel, np.abs)), "sign", channel)
    assert "lost its sign" in finding.what
    assert finding.severity == "error"


@each_drive
def test_a_current_that_stops_at_zero_has_lost_no_sign(drive):
    fault = functools.partial(np.maximum, 0.0)
    checked = check_log(with_fault(logged(*drive), "battery_current_a", fault))
    assert not found(checked, "sign", "battery_current_a")


@pytest.mark.parametrize("row", [0.02, 0.033, 0.05, 0.1])
def test_a_car_that_has_followed_its_last_command_reads_no_acceleration(row):
    """What a row shows as the next goes out is no speed in mph, nor another unit."""
    car = load_vehicle("rcc").changed(settings=one_loop.STIFF)
    came = one_loop.rows(car, row, 0.0, 40.0, seed=5)
    assert not units(check_log(Trace(came, name="log"), car))


def test_and_an_acceleration_in_g_is_told_beside_it():
    car = load_vehicle("rcc").changed(settings=one_loop.STIFF)
    came = one_loop.rows(car, 0.033, 0.0, 40.0, seed=5)
    came["accel_x_mps2"] = came["accel_x_mps2"] / G
    assert units(check_log(Trace(came, name="log"), car)) == ["accel_x_mps2"]


def units(checked):
    """Channels that are said to have another unit."""
    return [f.channel for f in checked.findings if f.kind == "unit"]
