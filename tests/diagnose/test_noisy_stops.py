"""Sound drives that a noisy speed drives, at rest too, beside a torque of their own."""

import numpy as np
import pytest

from rcc_sim.channel import is_nil
from rcc_sim.definitions.cycle import Cycle
from rcc_sim.definitions.vehicle import load_vehicle
from rcc_sim.diagnose.run import diagnose
from rcc_sim.simulate.run import simulate
from rcc_sim.trace import Trace
from tests.scaled_drive import logged

CAR = load_vehicle("tesla_model_3")
NOISE = {
    "time_s": 0.0,
    "steer_cmd_rad": 0.0, "speed_mps": 0.02, "yaw_rate_radps": 0.003,
    "accel_x_mps2": 0.06, "accel_y_mps2": 0.06, "motor_torque_nm": 0.8,
    "battery_voltage_v": 0.3, "battery_current_a": 0.4,
}  # fmt: skip


def driven(rate, car=CAR, seconds=200.0, bends_s=23.0):
    """Return the trace of a drive with two stops, and bends of 2 m/s² between."""
    time = np.array([0, 10, 26, 40, 46, 62, 72, 80, 98, 116, 122, 132, 138, 150, 200.0])
    speed = np.array([0, 0, 13.4, 13.4, 8.7, 8.7, 14, 20, 20, 0, 0, 12.6, 12.6, 5, 5.0])
    fine = np.arange(0.0, seconds, 0.02)
    v = np.interp(fine, time, speed)
    bends = 2.0 * np.sin(2 * np.pi * fine / bends_s) * CAR.wheelbase
    steer = np.where(v > 8, bends / np.maximum(v, 8.0) ** 2, 0.0)
    cycle = Cycle("stops", time[time <= seconds], speed[time <= seconds])
    return simulate(car, cycle, steer=(fine, steer), output_rate=rate).trace


@pytest.mark.slow
@pytest.mark.parametrize("seed", [1, pytest.param(2, marks=pytest.mark.thorough)])
def test_fifty_rows_a_second_with_noise_at_rest_are_no_gap(seed, tmp_path):
    """A limit that cuts what noise foresees, or a power over time, was told."""
    found = diagnose([logged(driven(50.0), CAR, seed, tmp_path, noise=NOISE)], CAR)
    assert (found.status, found.asserted) == ("no_gap", ())
    stated = CAR.figures()["effects.regeneration_limit.max_torque_nm"]
    moved = found.figures().get("effects.regeneration_limit.max_torque_nm", stated)
    assert abs(moved.value - stated.value) < 2 * stated.sd


def test_what_holds_still_is_nil_and_what_pulls_away_is_not():
    time = np.arange(0.0, 30.0, 0.02)
    speed = np.clip(time - 20.0, 0.0, None)  # 1 m/s² from 20 s on
    for noise in (0.005, 0.02, 0.1):
        read = speed + np.random.default_rng(1).normal(0, noise, len(time))
        nil = is_nil(time, read, noise)
        assert nil[time < 19.0].mean() > 0.99
        assert not nil[speed > 0.1 + noise].any()
        assert not is_nil(time, speed + 1.5 * noise, noise).any()


@pytest.mark.slow
def test_a_torque_whose_noise_is_foreseen_makes_no_delay(tmp_path):
    """One of two rows beside what shifts by rows was a smoother of it, at 99 %."""
    for seed in (3, 4):
        noise = NOISE | {"motor_torque_nm": 2.0}
        log = logged(driven(10.0), CAR, seed, tmp_path, noise=noise)
        assert [a.cause.effect for a in diagnose([log], CAR).asserted] == []


@pytest.mark.slow
@pytest.mark.parametrize("lag", [0.0, 0.3])
def test_how_a_car_answers_its_steering_tells_means_from_samples(lag, tmp_path):
    """Half a row that was amiss moved its centre of gravity by three sds.

    A steering that is slow is none of it: it made samples look like means, and those a
    cause of where the load lies.
    """
    slow = {"effects.steering_lag.time_constant_s": lag} if lag else {}
    means = driven(10.0, CAR.changed(settings=slow), bends_s=7.0)
    fine = driven(100.0, CAR.changed(settings=slow), bends_s=7.0)
    rows = np.searchsorted(fine["time_s"], means["time_s"])
    samples = Trace({c: x[rows] for c, x in fine.columns.items()}, name="log")
    for trace, window in ((means, np.inf), (samples, 0.01)):
        found = diagnose([logged(trace, CAR, 5, tmp_path, noise=NOISE)], CAR)
        told, fit = found.found, found.found.fit
        assert [c.effect for c in told.causes] == ["steering_lag"] * bool(lag)
        off = [
            abs(fit.values[k.key] - k.value) / k.sd
            for k in fit.knobs
            if k.key.startswith("body.cg_to")
        ]
        assert max(off) < 2.0
        assert told.engine.problems[0].drive.window == window
