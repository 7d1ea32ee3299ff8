"""The log check finds what was put in, names the channel, and is silent otherwise."""

from __future__ import annotations

import os
import subprocess
import sys

import numpy as np
import pytest
from drives import CAR, ROVER, SEDAN, SOUND, TRUCK, driven, logged, with_fault
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.signal import butter, lfilter

from rcc_sim.analyse.logcheck import Checked, check_log, check_reading
from rcc_sim.analyse.logcheck.finding import is_noisy
from rcc_sim.analyse.logcheck.mistakes import DEG
from rcc_sim.definitions.vehicle import load_vehicle
from rcc_sim.diagnose.judge.verdict import of_another
from rcc_sim.errors import InputError
from rcc_sim.readers.car import ratios
from rcc_sim.readers.log import Log
from rcc_sim.trace import Trace, write_trace

FEW = [CAR, ROVER, TRUCK, SEDAN]
G = 9.80665


def grave(checked):
    return [f for f in checked.findings if f.severity != "info"]


def found(checked, kind, channel):
    return [f for f in checked.findings if (f.kind, f.channel) == (kind, channel)]


# Sound logs


@pytest.mark.parametrize("drive", SOUND, ids=lambda d: f"{d[0]}-{d[1]}-{d[2]}")
@pytest.mark.parametrize("noise", [0.0, 1.0, 3.0])
@pytest.mark.parametrize("judged", [True, False], ids=["vehicle", "alone"])
def test_a_sound_log_earns_nothing_above_a_note(drive, noise, judged):
    vehicle = load_vehicle(drive[0]) if judged else None
    checked = check_log(logged(*drive, noise=noise), vehicle)
    assert not grave(checked)
    assert checked.rate == pytest.approx(drive[2], rel=0.01)


@settings(max_examples=40)
@given(
    drive=st.sampled_from(FEW),
    seed=st.integers(0, 10_000),
    noise=st.floats(0.3, 4.0),
    start=st.floats(-1e3, 1e9),
)
def test_neither_noise_nor_the_hour_makes_a_sound_log_unsound(
    drive, seed, noise, start
):
    log = logged(*drive, seed=seed, noise=noise)
    log = with_fault(log, "time_s", lambda t: t + start)
    assert not grave(check_log(log, load_vehicle(drive[0])))


@pytest.mark.parametrize("vehicle", ["r1t_epa", "bmw_i3"])
def test_a_model_without_noise_at_a_row_a_second_is_no_fault(vehicle):
    trace = driven(vehicle, "udds", None, None, True)
    assert not grave(check_log(trace, load_vehicle(vehicle)))


def test_quick_turns_are_no_noise_and_slowly_filtered_noise_is():
    """A sine of five rows turns at 40 % of them, but never twice in succession."""
    rows = np.arange(2000)
    for period in (5.0, 6.3, 8.0):
        assert not is_noisy(np.sin(2 * np.pi * rows / period))
    white = np.random.default_rng(0).normal(size=4000)
    assert is_noisy(white)
    assert is_noisy(lfilter(*butter(2, 0.2), white))


def test_a_sound_log_passes_through_untouched():
    log = logged(*CAR)
    checked = check_log(log)
    assert list(checked.trace.columns) == list(log.columns)
    for name, values in log.columns.items():
        assert np.array_equal(checked.trace[name], values)


# Units and signs

UNITS = [
    ("speed_mps", 3.6),
    ("speed_mps", 2.2369),
    ("speed_ref_mps", 3.6),
    ("steer_cmd_rad", 57.29578),
    ("yaw_rate_radps", 57.29578),
    ("yaw_rad", 57.29578),
    ("accel_x_mps2", 1 / G),
    ("accel_y_mps2", 1 / G),
    ("accel_x_mps2", 1000 / G),
    ("motor_speed_radps", 30 / np.pi),
    ("motor_current_a", 1000.0),
    ("battery_voltage_v", 1000.0),
    ("battery_current_a", 1000.0),
    ("battery_power_w", 0.001),
    ("x_m", 1000.0),
]
SIGNS = [
    *("battery_current_a", "battery_power_w", "accel_x_mps2", "accel_y_mps2"),
    *("steer_cmd_rad", "yaw_rate_radps", "motor_speed_radps", "motor_current_a"),
    *("motor_torque_nm", "yaw_rad"),
]


@pytest.mark.parametrize("drive", FEW, ids=lambda d: d[0])
@pytest.mark.parametrize(("channel", "factor"), UNITS)
def test_a_wrong_unit_is_found_with_its_mend_and_no_other_is(drive, channel, factor):
    log = logged(*drive)
    if channel not in log:
        pytest.skip(f"{drive[0]} logs no {channel}")
    checked = check_log(
        with_fault(log, channel, lambda x: x * factor), load_vehicle(drive[0])
    )
    (finding,) = found(checked, "unit", channel)
    assert finding.factor == pytest.approx(1 / factor, rel=1e-3)
    assert grave(checked) == [finding]
    assert checked.unusable == (channel,)


@pytest.mark.parametrize(
    ("unit", "ratio"), [(1.0, 13), (1.0, 16), (DEG, 13), (DEG, 16), (DEG, 20)]
)
@pytest.mark.parametrize("drive", [TRUCK, CAR], ids=lambda d: d[0])
def test_a_steering_wheels_angle_is_told_from_the_road_wheels_degrees(
    drive, unit, ratio
):
    """A model car has no steering wheel: there it is some other unit, or degrees."""
    log = with_fault(logged(*drive), "steer_cmd_rad", lambda x: ratio * unit * x)
    (finding,) = found(check_log(log, load_vehicle(drive[0])), "unit", "steer_cmd_rad")
    assert ("steering wheel" in finding.what) == (drive is TRUCK)
    if drive is TRUCK:
        assert finding.factor == pytest.approx(1 / (ratio * unit), rel=0.25)


BARE = ("time_s", "speed_mps", "speed_ref_mps")


@pytest.mark.parametrize("drive", FEW, ids=lambda d: d[0])
@pytest.mark.parametrize("factor", [1000.0, 0.001], ids=["thousand", "thousandth"])
@pytest.mark.parametrize(
    ("channel", "beside"),
    [("battery_power_w", ()), ("battery_current_a", ("battery_voltage_v",))],
)
def test_power_alone_in_another_unit_is_no_clock_in_another(
    drive, factor, channel, beside
):
    log = logged(*drive)
    few = {name: log[name] for name in (*BARE, channel, *beside) if name in log}
    few[channel] = few[channel] * factor
    checked = check_log(Trace(few, name="few"), load_vehicle(drive[0]))
    assert checked.unusable == (channel,)
    (finding,) = found(checked, "unit", channel)
    assert finding.factor == pytest.approx(1 / factor)


def test_of_two_likely_mistakes_the_same_is_named_in_every_process(tmp_path):
    log = with_fault(logged(*CAR), "battery_current_a", lambda x: x * 1000)
    few = (*BARE, "motor_speed_radps", "battery_voltage_v", "battery_current_a")
    with (tmp_path / "log.csv").open("wb") as file:
        write_trace(Trace({c: log[c] for c in few}, name="few"), file)
    told = {
        subprocess.run(
            [sys.executable, "-m", "rcc_sim", "check", "log.csv", "--vehicle", CAR[0]],
            capture_output=True,
            cwd=tmp_path,
            env={**os.environ, "PYTHONHASHSEED": seed},
        ).stdout
        for seed in "01"
    }
    assert len(told) == 1


@pytest.mark.parametrize("drive", FEW, ids=lambda d: d[0])
@pytest.mark.parametrize("channel", SIGNS)
@pytest.mark.parametrize("judged", [True, False], ids=["vehicle", "alone"])
def test_a_wrong_sign_is_found_and_no_other_is(drive, channel, judged):
    log = logged(*drive)
    if channel not in log:
        pytest.skip(f"{drive[0]} logs no {channel}")
    vehicle = load_vehicle(drive[0]) if judged else None
    checked = check_log(with_fault(log, channel, lambda x: -x), vehicle)
    (finding,) = found(checked, "sign", channel)
    assert finding.factor == -1
    assert grave(checked) == [finding]


def test_electrical_turns_are_told_from_mechanical_ones_by_the_poles():
    car = load_vehicle("rcc")
    pairs = car.motor.poles / 2
    erpm = with_fault(
        logged(*CAR), "motor_speed_radps", lambda x: x * pairs * 30 / np.pi
    )
    (finding,) = found(check_log(erpm, car), "unit", "motor_speed_radps")
    assert "ERPM" in finding.what
    assert 1 / finding.factor == pytest.approx(pairs * 30 / np.pi)


def test_two_wrong_channels_are_both_found():
    log = with_fault(logged(*TRUCK), "battery_current_a", lambda x: -x)
    log = with_fault(log, "accel_x_mps2", lambda x: x / G)
    assert set(check_log(log).unusable) == {"battery_current_a", "accel_x_mps2"}


@pytest.mark.parametrize("drive", FEW, ids=lambda d: d[0])
def test_a_speed_whose_name_says_another_unit_than_it_has_is_told(drive):
    log = with_fault(logged(*drive), "speed_mps", lambda x: x / 3.6)
    checked = check_log(log, load_vehicle(drive[0]))
    (finding,) = found(checked, "unit", "speed_mps")
    assert finding.factor == pytest.approx(3.6)
    assert grave(checked) == [finding]


@pytest.mark.parametrize("drive", FEW, ids=lambda d: d[0])
@pytest.mark.parametrize("times", ["gear", 1000.0], ids=["at the wheels", "mN m"])
def test_a_torque_at_the_wheels_or_in_thousandths_is_told_by_the_mass(drive, times):
    car = load_vehicle(drive[0])
    if times == "gear":
        times = car.drivetrain.gear_ratio.value
    log = with_fault(logged(*drive), "motor_torque_nm", lambda x: x * times)
    checked = check_log(log, car)
    (finding,) = found(checked, "unit", "motor_torque_nm")
    assert finding.factor == pytest.approx(1 / times)
    assert grave(checked) == [finding]


def test_three_wrong_units_are_found_where_one_relation_tells_of_them_all():
    """Speed, turn and lateral acceleration; what the file says of the steering fits."""
    log, car = logged(*CAR, noise=1.0), load_vehicle(CAR[0])
    wrong = {"speed_mps": 3.6, "yaw_rate_radps": DEG, "accel_y_mps2": 1 / 9.80665}
    columns = {c: log[c] * wrong.get(c, 1.0) for c in ("time_s", *wrong)}
    columns["steer_cmd_rad"] = log["steer_cmd_rad"] * 4.0  # a command, not an angle
    for judged in (None, car):
        checked = check_log(Trace(columns, name="log"), judged)
        told = {f.channel: f.factor for f in checked.findings if f.kind == "unit"}
        assert told == {c: pytest.approx(1 / f, rel=1e-3) for c, f in wrong.items()}


def test_nothing_is_mended_in_silence():
    log = with_fault(logged(*CAR), "accel_x_mps2", lambda x: -x)
    assert np.array_equal(check_log(log).trace["accel_x_mps2"], log["accel_x_mps2"])


# The time base


@pytest.mark.parametrize("drive", FEW, ids=lambda d: d[0])
@pytest.mark.parametrize("factor", [1e3, 1e6, 1e9])
def test_time_that_is_not_in_seconds_is_found(drive, factor):
    checked = check_log(with_fault(logged(*drive), "time_s", lambda t: t * factor))
    (finding,) = found(checked, "time_unit", "time_s")
    assert finding.severity == "error"
    assert finding.factor == pytest.approx(1 / factor)
    assert checked.rate == pytest.approx(drive[2], rel=0.01)


def test_milliseconds_at_a_thousand_rows_a_second_are_seen_by_the_motion():
    log = with_fault(logged(*SOUND[1]), "time_s", lambda t: t * 1e3)
    (finding,) = found(check_log(log), "time_unit", "time_s")
    assert finding.factor == pytest.approx(1e-3)


def test_rows_that_go_back_in_time_are_left_out_and_no_others():
    def back(t):
        t[500:503] -= 0.5
        return t

    log = with_fault(logged(*CAR), "time_s", back)
    checked = check_log(log)
    (finding,) = found(checked, "backwards", "time_s")
    assert finding.severity == "warning"
    good = np.delete(log["time_s"], np.s_[500:503])
    assert np.array_equal(checked.trace["time_s"], good)


def test_one_stamp_that_leaps_ahead_costs_one_row():
    def leap(t):
        t[700] += 1e4
        return t

    checked = check_log(with_fault(logged(*CAR), "time_s", leap))
    assert len(checked.trace) == len(logged(*CAR)) - 1


def test_a_clock_that_wraps_at_midnight_is_called_that():
    log = with_fault(logged(*SEDAN), "time_s", lambda t: (t + 86_000) % 86_400)
    (finding,) = found(check_log(log), "backwards", "time_s")
    assert "midnight" in finding.what
    assert "add a day" in finding.action


def test_a_clock_that_starts_anew_tells_where_to_cut():
    log = with_fault(
        logged(*CAR), "time_s", lambda t: np.where(t < t[900], t, t - t[900])
    )
    (finding,) = found(check_log(log), "backwards", "time_s")
    assert finding.severity == "error"
    assert finding.where == "row 901"
    assert "each drive in a file of its own" in finding.action


def test_rows_in_no_order_are_to_be_put_in_order():
    order = np.random.default_rng(1).permutation(len(logged(*CAR)))
    log = with_fault(logged(*CAR), "time_s", lambda t: t[order])
    (finding,) = found(check_log(log), "backwards", "time_s")
    assert "in the order in which they were measured" in finding.action


@settings(max_examples=30)
@given(st.lists(st.floats(allow_infinity=False, width=32), min_size=20, max_size=200))
def test_whatever_the_stamps_the_rows_kept_increase(stamps):
    stamps = np.array(stamps)
    log = Trace({"time_s": stamps, "speed_mps": np.sin(np.arange(len(stamps)))})
    try:
        kept = check_log(log).trace["time_s"]
    except InputError:
        assert len(np.unique(stamps[np.isfinite(stamps)])) < len(stamps)
        return
    assert np.all(np.diff(kept) > 0)


def test_repeated_stamps_and_missing_ones_are_counted():
    def spoil(t):
        t[100] = t[99]
        t[200:205] = np.nan
        return t

    log = with_fault(logged(*CAR), "time_s", spoil)
    checked = check_log(log)
    assert "1 rows" in found(checked, "duplicate_stamps", "time_s")[0].what
    assert "5 rows" in found(checked, "missing_stamp", "time_s")[0].what
    assert len(checked.trace) == len(log) - 6


def test_rows_that_share_a_coarse_stamp_are_told_by_how_many():
    time = np.arange(600) / 10.0
    log = Trace({"time_s": np.floor(time + 0.3), "speed_mps": np.sin(time) + 2.0})
    (one,) = found(check_log(log), "duplicate_stamps", "time_s")
    assert "each stamp has 10 rows: a --map with rate_hz = 10 and no" in one.action
    twice = np.sort(np.concatenate([time, time[:100]]))
    log = Trace({"time_s": twice, "speed_mps": np.sin(twice) + 2.0})
    (one,) = found(check_log(log), "duplicate_stamps", "time_s")
    assert one.action == "100 rows left out"


def test_a_logger_that_was_switched_off_lost_no_rows():
    time = np.arange(400) / 10.0
    time[200:] += 1800.0
    time[300:] += 3600.0
    trace = Trace({"time_s": time, "speed_mps": np.sin(time) + 2.0})
    (found,) = [f for f in check_log(trace).findings if f.channel == "time_s"]
    assert found.kind == "pause" and "2 times, up to 3600 s" in found.what
    assert (found.start_s, found.end_s) == (pytest.approx(1829.9), pytest.approx(5430))


@pytest.mark.parametrize("share", [0.05, 0.15, 0.3])
def test_rows_lost_here_and_there_are_counted(share):
    """Of an even clock: that some are missing makes the others no less even."""
    rng = np.random.default_rng(4)
    kept = rng.random(6000) > share
    kept[[0, -1]] = True
    time = np.round(np.arange(6000) / 100 + rng.normal(0, 1e-4, 6000), 5)[kept]
    trace = Trace({"time_s": time, "speed_mps": np.sin(time) + 2.0})
    (found,) = [f for f in check_log(trace).findings if f.channel == "time_s"]
    assert found.kind in ("gap", "lost_rows")
    told = int(found.what.split()[1])
    assert told == pytest.approx(6000 - kept.sum(), rel=0.02)


def test_a_step_that_is_next_to_none_is_no_multiple_of_the_usual_one():
    """Of one short step and one long, neither is near their median."""
    time = np.array([0.0, 1.0, 21.0])
    checked = check_log(Trace({"time_s": time, "speed_mps": time}))
    assert found(checked, "jitter", "time_s")


@pytest.mark.parametrize(("times", "mend"), [(1.0, None), (2.0, 0.5), (0.5, 2.0)])
def test_poles_taken_for_pole_pairs_are_told_from_a_speed_in_miles(times, mend):
    """A log whose speed is the motor's ERPM alone."""
    car = load_vehicle(CAR[0])
    log = logged(*CAR)
    erpm = times * log["speed_mps"] * ratios(car).radps_per_mps
    columns = {
        n: v
        for n, v in log.columns.items()
        if not n.startswith(("speed_mps", "motor_speed"))
    }
    columns["motor_speed_erpm"] = np.round(erpm * ratios(car).erpm_per_radps)
    checked = check_reading(Log(Trace(columns, name="log"), "rccsim"), car)
    wrong = [(f.kind, f.channel, f.factor) for f in grave(checked)]
    assert wrong == (
        []
        if mend is None
        else [("poles", "speed_mps", mend), ("poles", "motor_speed_radps", mend)]
    )


def test_a_gap_is_given_with_its_place_and_length():
    log = logged(*CAR)
    t = log["time_s"]
    keep = (t < 20) | (t > 22)
    checked = check_log(Trace({n: v[keep] for n, v in log.columns.items()}))
    (finding,) = found(checked, "gap", "time_s")
    assert finding.severity == "warning"
    assert finding.start_s == pytest.approx(20, abs=0.02)
    assert finding.end_s == pytest.approx(22, abs=0.02)


# What the vehicle's figures say of a speed


@pytest.mark.parametrize(("factor", "unit"), [(3.6, "km/h"), (2.2369, "mph")])
def test_power_and_mass_tell_a_speed_that_is_in_another_unit(factor, unit):
    """A town drive in km/h is no faster than a motorway in m/s."""
    log = driven("bmw_i3", "udds", None, None, True)
    kept = ("time_s", "speed_mps", "battery_voltage_v", "battery_current_a")
    slow = Trace({name: log[name][:400] for name in kept}, name="log")
    wrong = with_fault(slow, "speed_mps", lambda v: factor * v)
    (finding,) = found(check_log(wrong, load_vehicle("bmw_i3")), "unit", "speed_mps")
    assert unit in finding.what
    assert finding.factor == pytest.approx(1 / factor, rel=1e-6)
    assert not grave(check_log(slow, load_vehicle("bmw_i3")))


@pytest.mark.parametrize(("factor", "unit"), [(3.6, "km/h"), (2.2369, "mph")])
def test_a_speed_is_told_whose_reference_is_in_the_same_other_unit(factor, unit):
    """The two agree; only what the mass takes tells."""
    log = driven("bmw_i3", "udds", None, None, True)
    kept = ("time_s", "battery_voltage_v", "battery_current_a")
    town = {name: log[name][:400] for name in kept}
    speeds = ("speed_mps", "speed_ref_mps")
    car = load_vehicle("bmw_i3")

    def told(by: float) -> Checked:
        speed = by * log["speed_mps"][:400]
        return check_log(Trace(town | dict.fromkeys(speeds, speed)), car)

    for channel in speeds:
        (finding,) = found(told(factor), "unit", channel)
        assert finding.factor == pytest.approx(1 / factor, rel=1e-6)
        assert unit in finding.what
    assert not grave(told(1.0))


@pytest.mark.parametrize(
    ("factor", "words"), [(3.6, "km/h"), (2.2369, "mph"), (1.0, "")]
)
def test_a_speed_to_which_the_motor_cannot_turn_is_told(factor, words):
    """Where no other channel tells of it: 60 000 ERPM are 13 m/s of this car."""
    log = logged(*CAR)
    fast = 12.0 / log["speed_mps"].max() * log["speed_mps"]
    some = {"time_s": log["time_s"], "speed_mps": factor * fast}
    checked = check_log(Trace(some | {"x_m": log["x_m"]}), load_vehicle("rcc"))
    findings = found(checked, "unit", "speed_mps")
    assert [words in f.what for f in findings] == [True] * bool(words)


def test_a_speed_eight_per_cent_off_the_motors_is_told():
    log = logged(*CAR, noise=1.0)
    low = with_fault(log, "speed_mps", lambda v: 0.92 * v)
    car = load_vehicle(CAR[0])
    (finding,) = found(check_log(low, car), "inconsistent", "speed_mps")
    assert "1.09 times" in finding.what
    near = with_fault(log, "speed_mps", lambda v: 0.985 * v)
    assert not found(check_log(near, car), "inconsistent", "speed_mps")


def test_a_voltage_of_another_battery_asks_whose_log_it_is():
    log, car = logged(*CAR), load_vehicle("rcc")
    assert not found(check_log(log, car), "other_battery", "battery_voltage_v")
    columns = dict(log.columns)
    columns["battery_voltage_v"] = 4.3 * log["battery_voltage_v"]
    checked = check_log(Trace(columns, name="log"), car)
    (finding,) = found(checked, "other_battery", "battery_voltage_v")
    assert "was it this vehicle" in finding.action
    assert of_another(checked.findings) == f"battery_voltage_v {finding.what}"


def test_what_is_off_beside_a_named_mistake_is_told_beside_it():
    """In millivolts, of a battery of 4.3 times the volts."""
    log = logged(*CAR, noise=1.0)
    high = with_fault(log, "battery_voltage_v", lambda u: 4300 * u)
    checked = check_log(high, load_vehicle(CAR[0]))
    (unit,) = found(checked, "unit", "battery_voltage_v")
    assert "mV" in unit.what
    (other,) = found(checked, "other_battery", "battery_voltage_v")
    assert other.what.startswith("is 4.3 times the vehicle file's")
    (power,) = found(checked, "inconsistent", "battery_power_w")
    assert "0.23" in power.what


def test_a_log_of_another_vehicle_is_no_wrong_unit():
    """Of a scaled car's log beside a pick-up's file, and the other way round."""
    for drive, other in ((CAR, TRUCK), (TRUCK, CAR)):
        checked = check_log(logged(*drive, noise=1.0), load_vehicle(other[0]))
        (finding,) = found(checked, "other_vehicle", "log")
        assert "was it this vehicle" in finding.action
        assert finding.what in of_another(checked.findings)
        assert not found(checked, "unit", "battery_voltage_v")
        assert not found(checked, "unit", "battery_current_a")
        assert not found(checked, "unit", "speed_mps")
        assert not checked.unusable


def test_one_channel_in_no_known_unit_is_no_other_vehicle():
    """A voltage in tenths: the power that it makes is off by as much."""
    log, car = logged(*CAR, noise=1.0), load_vehicle(CAR[0])
    columns = dict(log.columns) | {"battery_voltage_v": 10 * log["battery_voltage_v"]}
    columns.pop("battery_power_w", None)
    checked = check_log(Trace(columns, name="log"), car)
    assert not found(checked, "other_vehicle", "log")
    (finding,) = found(checked, "other_battery", "battery_voltage_v")
    assert "tenths of a volt" in finding.action and "factor = 0.1" in finding.action


@pytest.mark.parametrize(
    ("factor", "kind"), [(1.0, ""), (1000.0, "unit"), (10.0, "other_battery")]
)
def test_a_voltage_that_never_changes_is_judged_by_the_file(factor, kind):
    log, car = logged(*CAR, noise=0.0), load_vehicle("rcc")
    stiff = np.full(len(log), 12.0 * factor)
    columns = {"time_s": log["time_s"], "speed_mps": log["speed_mps"]}
    columns["battery_power_w"] = 12.0 * log["battery_current_a"]
    columns["battery_current_a"] = log["battery_current_a"]
    columns["battery_voltage_v"] = stiff
    checked = check_log(Trace(columns, name="log"), car)
    told = [f for f in checked.findings if f.channel == "battery_voltage_v"]
    assert [f.kind for f in told if f.severity != "info"] == [kind] * bool(kind)
    if kind == "unit":
        assert told[0].factor == pytest.approx(1e-3)
        assert not found(checked, "unit", "battery_power_w")


@pytest.mark.parametrize("by_power", [True, False], ids=["power", "volts_amperes"])
def test_a_standing_car_tells_auxiliaries_that_are_in_kilowatts(by_power):
    """It draws its base load of 524 W besides, and nothing else."""
    log = driven("bmw_i3", "udds", None, None, True)
    heat = 2000.0 + 500.0 * np.sin(0.01 * log["time_s"])
    more = {name: log[name] for name in ("battery_voltage_v", "battery_current_a")}
    more["battery_current_a"] = more["battery_current_a"] + heat / 380.0
    if by_power:
        more = {"battery_power_w": log["battery_power_w"] + heat}
    columns = {"time_s": log["time_s"], "speed_mps": log["speed_mps"], **more}
    right = Trace({**columns, "aux_power_w": heat}, name="log")
    car = load_vehicle("bmw_i3")
    assert not grave(check_log(right, car))
    wrong = with_fault(right, "aux_power_w", lambda p: p / 1000)
    (finding,) = found(check_log(wrong, car), "unit", "aux_power_w")
    assert "kW" in finding.what and finding.factor == pytest.approx(1000.0)
    fan = with_fault(right, "aux_power_w", lambda p: p / 200)  # alone is logged
    assert not grave(check_log(fan, car))


@pytest.mark.parametrize(
    ("column", "unit"), [("battery_voltage_v", "kV"), ("battery_current_a", "kA")]
)
def test_thousands_of_volts_and_amperes_are_told(column, unit):
    log = with_fault(
        driven("bmw_i3", "udds", None, None, True), column, lambda x: x / 1000
    )
    (finding,) = found(check_log(log, load_vehicle("bmw_i3")), "unit", column)
    assert unit in finding.what and finding.factor == pytest.approx(1000.0)


@pytest.mark.parametrize(("jitter", "lost"), [(0.08, 0.02), (0.08, 0.15), (0.14, 0.15)])
def test_rows_lost_are_counted_though_the_others_jitter(jitter, lost):
    rng = np.random.default_rng(4)
    every = np.cumsum(0.05 * (1 + jitter * rng.standard_normal(3000)))
    time = every[rng.random(3000) >= lost]
    trace = Trace({"time_s": time, "speed_mps": 2 + np.sin(time)})
    told = {f.kind: f for f in check_log(trace).findings}
    found = told.get("lost_rows") or told["gap"]
    count = int(found.what.split()[1])
    assert count == pytest.approx(3000 - len(time), rel=0.1)


def test_a_loop_that_runs_late_now_and_then_lost_no_rows():
    rng = np.random.default_rng(4)
    time = np.cumsum(0.05 + rng.exponential(0.02, 3000))
    trace = Trace({"time_s": time, "speed_mps": 2 + np.sin(time)})
    kinds = {f.kind for f in check_log(trace).findings}
    assert "lost_rows" not in kinds and "jitter" in kinds
