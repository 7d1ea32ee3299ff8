"""A logged drive run again, and the speed behind a noisy sensor."""

import numpy as np
import pytest

from rcc_sim.channel import sensor_noise
from rcc_sim.definitions.cycle import Cycle
from rcc_sim.errors import InputError
from rcc_sim.simulate.drive import drive_of
from rcc_sim.simulate.replay import replay
from rcc_sim.simulate.road import surveyed_slope
from rcc_sim.simulate.run import simulate
from rcc_sim.simulate.smooth import chosen_jerk, smooth_speed, smoothed
from rcc_sim.trace import Trace
from tests.cars import car, truck

CYCLE = Cycle("c", np.array([0, 2, 6, 12, 16.0]), np.array([0, 0, 4, 4, 1.0]))
LOSSES = {"drivetrain_damping": {"damping_nms_per_rad": 1.2e-5}}


def ramps(rate, seed=0, noise=0.004):
    """Speed of a drive of held speeds and ramps, and what a sensor makes of it."""
    rng = np.random.default_rng(seed)
    t = np.arange(0, 120, 1 / rate)
    v = np.interp(t, [0, 5, 15, 40, 55, 80, 95, 120], [0, 0, 8, 8, 15, 15, 3, 3])
    return t, v, v + rng.normal(0, noise, len(t))


@pytest.mark.parametrize("rate", [50.0, 100.0, 1000.0])
def test_a_commanded_run_is_replayed_to_its_own_speed_and_current(rate):
    log = simulate(car(LOSSES), CYCLE, output_rate=rate).trace
    out = replay(car(LOSSES), drive_of(log, car(LOSSES), window=1e9))
    assert np.abs(out["speed_mps"] - log["speed_mps"]).max() < 5e-3
    off = out["motor_current_a"] - log["motor_current_a"]
    assert np.sqrt(np.mean(off[1:] ** 2)) < 0.01 * log["motor_current_a"].max()


def test_half_the_time_step_changes_the_energy_by_less_than_a_thousandth():
    log = simulate(car(LOSSES), CYCLE, output_rate=100).trace
    drive = drive_of(log, car(LOSSES), window=1e9)
    once, twice = (
        replay(car(LOSSES), drive, substeps=k)["battery_power_w"].sum() for k in (1, 2)
    )
    assert once == pytest.approx(twice, rel=1e-3)
    assert once != twice


def test_drawing_the_state_to_the_measurement_takes_a_wrong_speed_away():
    log = simulate(car(LOSSES), CYCLE, output_rate=100).trace
    shown = dict(log.columns) | {
        "speed_mps": log["speed_mps"] + 0.2 * (log["time_s"] > 8)
    }
    drive = drive_of(Trace(shown), car(LOSSES))
    free = replay(car(LOSSES), drive)["speed_mps"]
    drawn = replay(car(LOSSES), drive, (0.01, 1.0, 1.0))["speed_mps"]
    late = log["time_s"] > 9
    assert np.abs(free - log["speed_mps"])[late].max() < 0.01
    assert np.mean((drawn - log["speed_mps"])[late]) > 0.1


def test_gaps_in_what_was_commanded_are_bridged():
    log = simulate(car(LOSSES), CYCLE, output_rate=100).trace
    ref = np.array(log["speed_ref_mps"])
    ref[700:720] = np.nan
    out = replay(
        car(LOSSES),
        drive_of(Trace(dict(log.columns) | {"speed_ref_mps": ref}), car(LOSSES)),
    )
    assert np.abs(out["speed_mps"] - log["speed_mps"]).max() < 5e-3


def test_a_log_without_commands_or_speed_drives_nothing():
    log = Trace({"time_s": np.arange(20.0), "battery_power_w": np.ones(20)}, name="x")
    with pytest.raises(InputError, match="nothing drives truck"):
        drive_of(log, truck())


def test_a_part_of_a_drive_begins_on_its_own_part_of_the_road():
    t = np.arange(0, 60, 0.1)
    log = Trace(
        {"time_s": t, "speed_mps": 0 * t + 10.0, "slope": np.where(t > 30, 0.05, 0.0)}
    )
    drive = drive_of(log, truck())
    whole = replay(truck(), drive)["battery_power_w"]
    part = replay(truck(), drive.part(slice(400, 600)))["battery_power_w"]
    assert part[5:] == pytest.approx(whole[405:], rel=1e-6)
    assert whole[500] == pytest.approx(
        3152.0 * 9.80665 * np.sin(np.arctan(0.05)) * 10.0, rel=1e-3
    )


@pytest.mark.parametrize("noise", [0.004, 0.05])
def test_the_noise_of_a_sensor_is_found_whatever_the_drive(noise):
    _, _, seen = ramps(10.0, noise=noise)
    assert sensor_noise(seen) == pytest.approx(noise, rel=0.15)


def test_a_quantised_speed_has_at_least_a_third_of_its_step_as_noise():
    _, v, _ = ramps(10.0)
    assert sensor_noise(np.round(v, 1)) >= 0.1 / 3 - 1e-9


@pytest.mark.parametrize("rate", [10.0, 100.0])
def test_smoothing_takes_most_of_the_noise_away_and_keeps_the_ramps(rate):
    t, v, seen = ramps(rate)
    calm, accel, _ = smoothed(t, seen)
    assert np.std(calm - v) < 0.6 * np.std(seen - v)
    middle = (t > 8) & (t < 13)
    assert accel[middle] == pytest.approx(0.8, abs=0.05)
    held = (t > 20) & (t < 38)
    assert np.abs(accel[held]).max() < 0.05


def test_a_speed_without_noise_stays_as_it_is():
    t, v, _ = ramps(10.0)
    calm, _, _ = smoothed(t, v)
    assert np.array_equal(calm, v)


def test_the_chosen_jerk_is_nearly_the_best_of_the_grid_for_the_hidden_truth():
    t, v, seen = ramps(10.0)
    noise = sensor_noise(seen)
    chosen = chosen_jerk(t, seen, noise=noise)

    def missed(jerk):
        return np.std(smooth_speed(t, seen, noise=noise, jerk=jerk)[0] - v)

    best = min(missed(chosen * factor) for factor in (0.03, 0.1, 0.3, 1, 3, 10, 30))
    assert missed(chosen) < 1.3 * best


def test_smoothing_in_pieces_is_smoothing_in_one(monkeypatch):
    from rcc_sim.simulate import smooth

    t, _, seen = ramps(100.0)
    whole, _ = smooth_speed(t, seen, noise=0.004, jerk=0.05)
    monkeypatch.setattr(smooth, "PIECE", 3000)
    pieces, _ = smooth_speed(t, seen, noise=0.004, jerk=0.05)
    assert np.abs(pieces - whole).max() < 1e-4


def test_rows_without_a_speed_are_bridged():
    t, v, seen = ramps(10.0)
    seen[220:230] = np.nan
    calm, _, _ = smoothed(t, seen)
    assert np.abs(calm - v)[215:235].max() < 0.01


def test_a_noisy_survey_of_a_flat_road_is_flat():
    rng = np.random.default_rng(1)
    s = np.linspace(0, 6000, 6000)
    _, slope = surveyed_slope(s, rng.normal(0, 0.3, len(s)))
    assert np.abs(slope).max() < 1e-3


def test_a_surveyed_hill_has_its_slope():
    rng = np.random.default_rng(1)
    s = np.linspace(0, 6000, 6000)
    height = 20 * np.sin(2 * np.pi * s / 3000)
    where, slope = surveyed_slope(s, height + rng.normal(0, 0.2, len(s)))
    true = 20 * 2 * np.pi / 3000 * np.cos(2 * np.pi * where / 3000)
    run = true / 1.0
    assert slope[5:-5] == pytest.approx(run[5:-5], abs=3e-3)


@pytest.mark.parametrize("step", [0.5, 1.0, 5.0])
def test_rounded_heights_give_the_slope_of_the_hill(step):
    """A reading stands for metres, then leaps: what a map or a barometer gives."""
    s = np.cumsum(1.2 + 0.5 * np.sin(np.arange(6000) / 300))
    height = 20 * np.sin(2 * np.pi * s / 3000)
    true = 20 * 2 * np.pi / 3000 * np.cos(2 * np.pi * s / 3000)
    where, slope = surveyed_slope(s, step * np.round(height / step))
    left = np.interp(s, where, slope) - true
    assert np.sqrt(np.mean(left**2)) < 0.1 * np.sqrt(np.mean(true**2))


def test_a_flat_stretch_before_a_rounded_hill_stays_flat():
    s = np.linspace(0.0, 3000.0, 3001)
    where, slope = surveyed_slope(s, np.round(0.04 * np.maximum(s - 1500, 0)))
    assert np.abs(slope[where < 1400]).max() < 0.004
    assert slope[where > 1700] == pytest.approx(0.04, abs=0.004)
