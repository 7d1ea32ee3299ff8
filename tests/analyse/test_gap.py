"""Where a log and a model part: nothing of itself, an effect in its place, sums."""

import numpy as np
import pytest

from rcc_sim.analyse.gap import gap
from rcc_sim.analyse.gap_alarm import alarm_limit
from rcc_sim.analyse.gap_replays import Tolerances, tolerances
from rcc_sim.analyse.gap_report import document
from rcc_sim.analyse.logged import Logged, open_log
from rcc_sim.definitions.cycle import Cycle
from rcc_sim.errors import InputError
from rcc_sim.simulate.drive import drive_of
from rcc_sim.simulate.run import simulate
from rcc_sim.trace import Trace, write_trace
from tests.cars import car, truck

LOSSES = {
    "drivetrain_damping": {"damping_nms_per_rad": 1.2e-5},
    "rotor_inertia": {"inertia_kgm2": 2.2e-6},
    "copper_loss": {"phase_resistance_ohm": 0.03},
}
HEAVY = {
    "road_load": {"a_n": 300.0, "b_n_s_per_m": 2.0, "c_n_s2_per_m2": 0.8},
    "rotor_inertia": {"inertia_kgm2": 0.2},
    "auxiliary_load": {"power_w": 500.0},
}
SMALL = Cycle(
    "small",
    np.array([0, 2, 6, 10, 14, 18, 22, 26, 30.0]),
    np.array([0, 0, 3, 3, 5, 5, 2, 2, 0.0]),
)
LARGE = Cycle(
    "large",
    np.array([0, 5, 25, 60, 80, 120, 140, 150.0]),
    np.array([0, 0, 15, 15, 25, 25, 0, 0.0]),
)


def steering(duration, size, period):
    t = np.arange(0.0, duration + 0.01, 0.01)
    return t, size * np.sin(2 * np.pi * t / period) * (t > 6)


def small_log(vehicle, rate=100.0, **options):
    options.setdefault("steer", steering(30, 0.08, 4))
    return simulate(vehicle, SMALL, output_rate=rate, **options).trace


def logged(trace, drop=()):
    kept = {
        n: np.array(v)
        for n, v in trace.columns.items()
        if n not in drop and not (n.startswith("energy_"))
    }
    return Logged(Trace(kept, name="log"), (), None)


def by_name(rows, key):
    return {getattr(row, key): row for row in rows}


def assert_no_gap(found, share=1e-3):
    assert abs(found.energy.gap_percent) < 100 * share
    for channel in found.channels:
        size = max(float(np.nanmax(np.abs(found.measured[channel.channel]))), 1e-9)
        assert channel.rmse < share * size, channel


@pytest.mark.parametrize("rate", [10.0, 50.0, 100.0, 1000.0])
def test_a_commanded_trace_of_the_model_has_no_gap(rate):
    vehicle = car(LOSSES)
    log = logged(small_log(vehicle, rate))
    found = gap(log, vehicle)
    assert found.mode == "commanded"
    if rate >= 50:  # what was commanded between the rows is known
        assert_no_gap(found, 2e-3)
    assert abs(found.energy.gap_percent) < 0.5


@pytest.mark.parametrize("rate", [10.0, 20.0, 100.0])
def test_an_imposed_trace_of_the_model_has_no_gap(rate):
    vehicle = truck(HEAVY)
    log = logged(simulate(vehicle, LARGE, output_rate=rate).trace)
    found = gap(log, vehicle)
    assert found.mode == "imposed"
    assert abs(found.energy.gap_percent) < 0.1
    channels = by_name(found.channels, "channel")
    power = channels["battery_power_w"]
    assert power.rmse < 0.02 * np.nanmax(np.abs(log.log["battery_power_w"]))


def test_a_throttled_trace_of_the_model_has_no_gap():
    vehicle = car(
        {"rolling_resistance": {"coefficient": 0.02}},
        controller__mode="throttle",
        controller__force_throttle=[0.0, 1.0],
        controller__force_speed_mps=[0.0, 5.0],
        controller__force_n=[[0.0, 0.0], [20.0, 0.0]],
    )
    t = np.arange(0, 20, 0.01)
    throttle = (t, 0.3 + 0.1 * np.sin(t))
    hold = Cycle("throttle", np.array([0.0, 20.0]), np.zeros(2))
    trace = simulate(vehicle, hold, throttle=throttle, output_rate=100.0).trace
    trace["throttle"][0] = 0.3  # at its first row a trace has not read it yet
    found = gap(logged(trace), vehicle)
    assert found.mode == "commanded"
    assert_no_gap(found, 2e-3)


def test_regimes_and_stages_each_sum_to_the_gap():
    more = LOSSES | {"rolling_resistance": {"coefficient": 0.03}}
    found = gap(logged(small_log(car(more))), car(LOSSES))
    whole = found.energy.gap_wh
    assert whole > 0
    assert sum(r.gap_wh for r in found.regimes) == pytest.approx(whole, rel=1e-9)
    assert sum(s.gap_wh for s in found.stages) == pytest.approx(whole, rel=1e-9)


def test_rolling_resistance_shows_as_mechanical_and_not_while_standing():
    more = LOSSES | {"rolling_resistance": {"coefficient": 0.03}}
    found = gap(logged(small_log(car(more))), car(LOSSES))
    stages = by_name(found.stages, "stage")
    assert stages["mechanical"].share > 0.8
    regimes = by_name(found.regimes, "regime")
    assert abs(regimes["standstill"].gap_wh) < 0.02 * found.energy.gap_wh


def test_an_auxiliary_load_shows_as_electrical_and_evenly_over_time():
    more = LOSSES | {"auxiliary_load": {"power_w": 10.0}}
    found = gap(logged(small_log(car(more))), car(LOSSES))
    stages = by_name(found.stages, "stage")
    assert stages["electrical"].share > 0.95
    assert found.energy.gap_wh == pytest.approx(10.0 * 30 / 3600, rel=0.02)
    regimes = by_name(found.regimes, "regime")
    per_second = regimes["standstill"].gap_wh / regimes["standstill"].time_s
    assert per_second == pytest.approx(10.0 / 3600, rel=0.05)


def test_a_slower_loop_shows_as_control():
    slow = LOSSES | {"speed_loop": {"proportional_scale": 0.1, "integral_scale": 0.1}}
    found = gap(logged(small_log(car(slow))), car(LOSSES))
    stages = by_name(found.stages, "stage")
    assert abs(stages["control"].share) == max(abs(s.share) for s in found.stages)
    channels = by_name(found.channels, "channel")
    assert channels["speed_mps"].ratio > 3
    assert channels["battery_voltage_v"].rmse < 1e-12


def test_a_steering_offset_shows_in_the_yaw_rate_and_not_in_the_speed():
    off = LOSSES | {"steering_offset": {"angle_rad": 0.03}}
    found = gap(logged(small_log(car(off))), car(LOSSES))
    channels = by_name(found.channels, "channel")
    assert channels["yaw_rate_radps"].bias > 0
    assert channels["yaw_rate_radps"].theil.bias > 0.5
    assert channels["yaw_rate_radps"].score < channels["speed_mps"].score
    assert "yaw_rate_radps" in {w.channel for w in found.windows}


def test_the_limit_of_an_alarm_is_the_quantile_of_the_largest_of_many_normals():
    """Of n independent windows: P(max |z| > L) = 0.05, by the closed form."""
    from scipy.stats import norm

    rng = np.random.default_rng(3)
    count, rows = 400, 10
    e = np.repeat(rng.standard_normal(2 * count), rows // 2)
    nothing = Tolerances((), np.arange(len(e)), {})
    limit = alarm_limit({"c": e}, {"c": np.ones(len(e))}, nothing, rows)
    exact = norm.ppf(0.5 + 0.5 * 0.95 ** (1 / (2 * count)))
    assert limit == pytest.approx(exact, rel=0.05)


def test_figures_that_move_all_windows_at_once_raise_the_limit_no_more_than_one():
    from scipy.stats import norm

    n, rows = 4000, 10
    moved = Tolerances(("k",), np.arange(n), {"c": np.ones((1, n))})
    limit = alarm_limit({"c": np.zeros(n)}, {"c": np.ones(n)}, moved, rows)
    assert limit == pytest.approx(max(norm.ppf(0.975), 2.0), abs=0.3)


def test_the_motor_stands_before_the_speed_and_the_battery_that_follow_it():
    more = LOSSES | {"drivetrain_friction": {"torque_nm": 0.004}}
    found = gap(logged(small_log(car(more))), car(LOSSES))
    order = [c.channel for c in found.channels]
    assert order[0] in ("motor_torque_nm", "motor_current_a")
    assert order.index("motor_current_a") < order.index("battery_power_w")


def test_windows_say_when_an_effect_acts():
    log = small_log(car(LOSSES))
    noise = np.random.default_rng(5).normal(0, 0.5, len(log))
    late = np.array(log["battery_power_w"]) + noise
    late[1500:2000] += 20.0
    current = late / 12.0
    columns = dict(log.columns) | {
        "battery_power_w": late,
        "battery_current_a": current,
    }
    found = gap(logged(Trace(columns)), car(LOSSES))
    power = [w for w in found.windows if w.channel == "battery_power_w"]
    assert len(power) == 1
    assert power[0].start_s == pytest.approx(15.0, abs=1.0)
    assert power[0].end_s == pytest.approx(20.0, abs=1.0)


def test_the_gap_is_none_where_the_sds_explain_it():
    unsure = {
        "drivetrain_damping": {"damping_nms_per_rad": {"value": 1e-4, "sd": 3e-5}}
    }
    true = {"drivetrain_damping": {"damping_nms_per_rad": 1.3e-4}}
    sure = {"drivetrain_damping": {"damping_nms_per_rad": 1e-4}}
    log = logged(small_log(car(true)))
    assert gap(log, car(unsure)).energy.within
    off = gap(log, car(sure)).energy
    assert not off.within and off.beyond(1.0) and not off.beyond(1e3)


def test_tolerance_is_that_of_a_figure_to_which_energy_is_proportional():
    """An idle load of P ± s on a car that stands: E = P t, u = s t."""
    unsure = {"auxiliary_load": {"power_w": {"value": 20.0, "sd": 2.0}}}
    t = np.arange(0, 60, 0.01)
    still = Trace(
        {
            "time_s": t,
            "speed_ref_mps": 0 * t,
            "speed_mps": 0 * t,
            "battery_power_w": 0 * t + 21.0,
        }
    )
    energy = gap(Logged(still, (), None), car(unsure)).energy
    assert energy.tolerance_wh == pytest.approx(2.0 * 60 / 3600, rel=1e-2)
    assert energy.gap_wh == pytest.approx(1.0 * 60 / 3600, rel=1e-2)


def test_a_stage_is_unsure_by_the_figures_that_act_in_it_and_no_others():
    """An auxiliary load of ± 40 W over the drive is electrical: 40 W times its time."""
    log = simulate(truck(HEAVY), LARGE, output_rate=10.0).trace
    sure = gap(logged(log), truck(HEAVY))
    doubt = HEAVY | {"auxiliary_load": {"power_w": {"value": 500.0, "sd": 40.0}}}
    found = gap(logged(log), truck(doubt))
    exact = 40.0 * (log["time_s"][-1] - log["time_s"][0]) / 3600
    before, after = (by_name(g.stages, "stage") for g in (sure, found))
    added = {
        name: after[name].u_val_wh ** 2 - before[name].u_val_wh ** 2 for name in after
    }
    assert np.sqrt(added["electrical"]) == pytest.approx(exact, rel=0.02)
    assert abs(added["mechanical"]) < 1e-3 * exact**2
    stands = by_name(found.regimes, "regime")["standstill"]
    assert stands.u_val_wh == pytest.approx(40.0 * stands.time_s / 3600, rel=0.05)


def test_repeats_tell_the_noise_of_a_channel():
    rng = np.random.default_rng(3)
    log = small_log(car(LOSSES))

    def noisy():
        columns = dict(log.columns)
        for name, sd in (("speed_mps", 0.02), ("yaw_rate_radps", 0.05)):
            columns[name] = log[name] + rng.normal(0, sd, len(log))
        return logged(Trace(columns, name="log"))

    one, *others = noisy(), noisy(), noisy()
    found = gap(one, car(LOSSES), repeats=[o.log for o in others])
    channels = by_name(found.channels, "channel")
    assert channels["speed_mps"].noise_from == "repeats"
    assert channels["speed_mps"].noise == pytest.approx(0.02, rel=0.05)
    assert channels["yaw_rate_radps"].noise == pytest.approx(0.05, rel=0.05)


def test_a_repeat_of_another_drive_is_refused():
    log = small_log(car(LOSSES))
    columns = dict(log.columns)
    for name in columns.keys() - {"time_s"}:
        columns[name] = np.roll(columns[name], len(log) // 3)
    other = Trace(columns, name="other.csv")
    with pytest.raises(InputError, match=r"--repeats: other.csv: speed.*: not the dr"):
        gap(logged(log), car(LOSSES), repeats=[other])


def test_without_repeats_the_noise_is_guessed_from_the_log_and_called_so():
    rng = np.random.default_rng(4)
    log = small_log(car(LOSSES))
    columns = dict(log.columns) | {
        "speed_mps": log["speed_mps"] + rng.normal(0, 0.02, len(log))
    }
    found = gap(logged(Trace(columns, name="log")), car(LOSSES))
    speed = by_name(found.channels, "channel")["speed_mps"]
    assert speed.noise_from == "guess"
    assert speed.noise == pytest.approx(0.02, rel=0.15)
    assert any("guessed" in note for note in found.notes)


@pytest.mark.parametrize(
    ("stated", "origin"), [(0.025, "vehicle file"), (0.005, "rough road")]
)
def test_a_noise_is_called_the_files_unless_the_log_strays_by_more(stated, origin):
    rng = np.random.default_rng(4)
    log = small_log(car(LOSSES))
    columns = dict(log.columns) | {
        "speed_mps": log["speed_mps"] + rng.normal(0, 0.02, len(log))
    }
    told = car(LOSSES).changed(settings={"sensors.speed_mps.noise_sd": stated})
    found = gap(logged(Trace(columns, name="log")), told)
    speed = by_name(found.channels, "channel")["speed_mps"]
    assert speed.noise_from == origin
    assert speed.noise == pytest.approx(max(stated, 0.02), rel=0.15)


def test_a_log_without_a_battery_is_judged_at_the_shaft():
    drop = ("battery_power_w", "battery_current_a", "battery_voltage_v")
    found = gap(logged(small_log(car(LOSSES)), drop), car(LOSSES))
    assert found.energy.at == "shaft"
    assert abs(found.energy.gap_percent) < 0.5


def test_a_log_without_any_power_has_no_energy_gap_but_channels():
    log = small_log(car(LOSSES))
    kept = ("time_s", "speed_ref_mps", "speed_mps")
    short = Trace({n: log[n] for n in kept}, name="log")
    out = document(gap(Logged(short, (), None), car(LOSSES)))
    assert out["energy"]["gap_wh"] is None
    assert [c["channel"] for c in out["channels"]] == ["speed_mps"]
    assert out["stages"] == []


def test_theils_shares_sum_to_one():
    off = LOSSES | {"rolling_resistance": {"coefficient": 0.05}}
    found = gap(logged(small_log(car(off))), car(LOSSES))
    for channel in found.channels:
        if channel.theil is not None:
            t = channel.theil
            assert t.bias + t.variance + t.covariance == pytest.approx(1.0)


def test_a_drive_in_pieces_is_the_drive_in_one(monkeypatch):
    from rcc_sim.analyse import gap_replays

    vehicle = car(LOSSES)
    log = small_log(vehicle)
    whole = gap(logged(log), vehicle)
    monkeypatch.setattr(gap_replays, "PIECE", 700)
    monkeypatch.setattr(gap_replays, "RUN_IN", 5.0)
    pieces = gap(logged(log), vehicle)
    assert pieces.energy.simulated_wh == pytest.approx(
        whole.energy.simulated_wh, rel=2e-3
    )


def written(tmp_path, columns):
    path = tmp_path / "log.csv"
    with path.open("wb") as file:
        write_trace(Trace(columns, name="log"), file)
    return path


def test_a_log_that_nothing_drives_is_refused_with_what_it_should_hold(tmp_path):
    t = np.arange(0, 10, 0.01)
    path = written(tmp_path, {"time_s": t, "battery_power_w": 50 + np.sin(t)})
    vehicle = truck(HEAVY)
    needs = r"nothing drives truck.*torque.*speed_mps"
    with pytest.raises(InputError, match=needs) as refused:
        gap(open_log(path, vehicle), vehicle)
    assert "battery_power_w" in refused.value.hint
    assert "--suggest-map" in refused.value.hint


def test_commands_in_a_wrong_unit_are_not_called_missing(tmp_path):
    log = small_log(car(LOSSES)).columns
    for name in ("speed_mps", "speed_ref_mps"):
        log[name] = log[name] * 3.6
    with open(tmp_path / "log.csv", "wb") as file:
        write_trace(Trace(log), file)
    there = open_log(tmp_path / "log.csv", car(LOSSES))
    with pytest.raises(InputError, match="is in km/h") as caught:
        gap(there, car(LOSSES))
    assert "speed_ref_mps cannot be used either" in str(caught.value.hint)


def test_a_throttle_does_not_drive_a_vehicle_in_speed_mode(tmp_path):
    t = np.arange(0, 10, 0.01)
    columns = {
        "time_s": t,
        "throttle": 0.2 + 0.1 * np.sin(t),
        "accel_x_mps2": np.sin(t),
    }
    vehicle = car(LOSSES)
    with pytest.raises(InputError, match="speed_ref_mps, or speed_mps"):
        gap(open_log(written(tmp_path, columns), vehicle), vehicle)


@pytest.mark.parametrize("rows", [1, 2, 5])
def test_a_few_rows_are_no_log(tmp_path, rows):
    t = np.arange(rows) * 0.01
    path = written(tmp_path, {"time_s": t, "speed_mps": t, "battery_power_w": t + 1})
    with pytest.raises(InputError, match="row"):
        open_log(path, car(LOSSES))


def test_channels_of_nothing_but_gaps_are_refused(tmp_path):
    t = np.arange(0, 5, 0.01)
    nothing = np.full(len(t), np.nan)
    path = written(tmp_path, {"time_s": t, "speed_mps": nothing})
    with pytest.raises(InputError):
        open_log(path, car(LOSSES))


def test_a_hidden_column_is_not_there_and_an_unknown_one_is_an_error(tmp_path):
    log = small_log(car(LOSSES))
    columns = {n: log[n] for n in ("time_s", "speed_ref_mps", "speed_mps")}
    columns["battery_power_w"] = log["battery_power_w"]
    path = written(tmp_path, columns)
    found = open_log(path, car(LOSSES), hide=["battery_power_w"])
    assert "battery_power_w" not in found.log
    with pytest.raises(InputError, match="no column yaw to hide"):
        open_log(path, car(LOSSES), hide=["yaw"])


def test_reversing_is_left_out_and_reported(tmp_path):
    t = np.arange(0, 40, 0.01)
    rng = np.random.default_rng(0)
    speed = np.where(t < 25, 2 * np.sin(np.pi * t / 25), -np.sin(np.pi * (t - 25) / 15))
    columns = {
        "time_s": t,
        "speed_mps": speed + rng.normal(0, 0.005, len(t)),
        "battery_power_w": 5 + rng.normal(0, 0.1, len(t)),
    }
    found = open_log(written(tmp_path, columns), car(LOSSES))
    backwards = [f for f in found.findings if f.kind == "reversing"]
    assert len(backwards) == 1
    assert backwards[0].start_s == pytest.approx(25, abs=0.5)
    assert np.isnan(found.log["battery_power_w"][t > 26]).mean() > 0.9
    assert np.isfinite(found.log["battery_power_w"][t < 24]).all()


def test_unix_time_stamps_survive_a_file_and_make_no_difference(tmp_path):
    log = small_log(car(LOSSES))
    names = ("speed_ref_mps", "speed_mps", "steer_cmd_rad", "battery_power_w")
    columns = {"time_s": log["time_s"], **{n: log[n] for n in names}}
    later = columns | {"time_s": log["time_s"] + 1_732_000_000.25}
    (tmp_path / "a").mkdir()
    first = open_log(written(tmp_path / "a", columns), car(LOSSES))
    second = open_log(written(tmp_path, later), car(LOSSES))
    assert np.diff(second.log["time_s"]) == pytest.approx(0.01, abs=1e-6)
    a, b = (gap(one, car(LOSSES), window=1.0) for one in (first, second))
    assert b.energy.simulated_wh == pytest.approx(a.energy.simulated_wh, rel=1e-3)


@pytest.mark.parametrize(("slope", "sd"), [(-0.01, 0.01), (-0.01, 0.0101)])
def test_a_shift_is_of_one_sd_more_where_that_makes_the_figure_nil(slope, sd):
    unsure = car({"road_grade": {"slope": {"value": slope, "sd": sd}}})
    drive = drive_of(small_log(unsure), unsure)
    moved = tolerances(unsure, drive, ["battery_power_w"]).moved["battery_power_w"][0]
    climb = sd * np.nanmean(drive.commands.ref)
    assert np.nanmean(moved) == pytest.approx(3.78 * 9.80665 * climb, rel=0.05)


def test_a_figure_that_cannot_be_an_sd_larger_is_tried_an_sd_smaller():
    def band(sd):
        unsure = car({"gear_loss": {"efficiency": {"value": 0.98, "sd": sd}}})
        drive = drive_of(small_log(unsure), unsure)
        return tolerances(unsure, drive, ["motor_current_a"]).moved["motor_current_a"]

    one, three = band(0.01), band(0.03)
    assert np.nanmean(three) == pytest.approx(3 * np.nanmean(one), rel=0.1)
    assert np.nanmean(one) < 0  # the better the gears, the less the motor does
