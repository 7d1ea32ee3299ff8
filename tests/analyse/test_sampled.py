"""Flows that are samples, and flows that are means since the row before."""

from math import inf

import numpy as np
import pytest
from scipy.interpolate import PchipInterpolator

from rcc_sim.analyse.sampled import SAMPLE, drive_as_sampled
from rcc_sim.definitions.cycle import Cycle, parse_cycle
from rcc_sim.definitions.vehicle import load_vehicle
from rcc_sim.simulate.run import simulate
from rcc_sim.trace import Trace

CAR = load_vehicle("r1t_epa")
FINE = 200
NOISE = {"battery_current_a": 0.5, "motor_torque_nm": 1.0, "accel_x_mps2": 0.05}
RNG = np.random.default_rng(3)


def window(columns):
    return drive_as_sampled(Trace(columns, name="log"), CAR).window


def noisy(columns, speed=0.0):
    """The columns of a log with their sensors' noise."""
    n = len(columns["time_s"])
    out = {c: columns[c] + RNG.normal(0, sd, n) for c, sd in NOISE.items()}
    out["time_s"] = columns["time_s"]
    out["speed_mps"] = np.abs(columns["speed_mps"] + RNG.normal(0, speed, n))
    return out


def means(rate, cycle="udds[0:400]", car=CAR):
    return simulate(car, parse_cycle(cycle), imposed=True, output_rate=rate).trace


def samples(rate, cycle="udds[0:400]", first=6):
    """Every so many rows of a fine run, off the corners of the cycle."""
    run = means(FINE, cycle)
    rows = slice(first, None, round(FINE / rate))
    return {c: run[c][rows] for c in ("time_s", "speed_mps", *NOISE)}


@pytest.mark.parametrize("rate", [1.0, 2.0, 10.0])
@pytest.mark.parametrize("speed", [0.0, 0.03])
def test_means_are_told_by_the_log(rate, speed):
    assert window(noisy(means(rate), speed)) == inf


@pytest.mark.parametrize("rate", [5.0, 10.0])
@pytest.mark.parametrize("speed", [0.0, 0.03])
def test_samples_are_told_by_the_log(rate, speed):
    assert window(noisy(samples(rate), speed)) == SAMPLE


def traffic(seconds=1200.0, seed=5):
    """A drive that bends everywhere, as a foot makes it, at 50 rows a second."""
    rng = np.random.default_rng(seed)
    time = np.arange(0.0, seconds, 0.02)
    knots = np.arange(0.0, seconds + 30.0, 6.0)
    speed = PchipInterpolator(knots, 12.0 + 6.0 * rng.standard_normal(len(knots)))
    return Cycle("traffic", time, np.clip(speed(time), 0.5, None))


@pytest.mark.parametrize("rate", [1.0, 2.0, 5.0, 10.0])
@pytest.mark.parametrize("speed", [0.01, 0.02, 0.05])
@pytest.mark.parametrize("averaged", [True, False])
def test_a_speed_that_bends_more_than_it_errs_misleads_no_more_than_an_exact_one(
    rate, speed, averaged
):
    run = simulate(CAR, traffic(), imposed=True, output_rate=50.0).trace
    many = round(50.0 / rate)
    rows = np.arange(many, len(run), many)
    log = {c: run[c][rows] for c in ("time_s", "speed_mps")}
    for c in NOISE:
        mean = np.array([run[c][k - many + 1 : k + 1].mean() for k in rows])
        log[c] = mean if averaged else run[c][rows]
    log = noisy(log, speed)
    del log["accel_x_mps2"]
    assert window(log) == (inf if averaged else SAMPLE)


def test_a_cause_that_is_missing_does_not_mislead():
    heavier = CAR.changed(
        settings={
            "effects.payload.mass_kg": 600.0,
            "effects.auxiliary_load.power_w": 4000.0,
        }
    )
    assert window(noisy(means(2.0, car=heavier), 0.03)) == inf


def test_samples_that_come_a_row_late_are_no_means():
    late = samples(10.0)
    late |= {c: np.roll(late[c], 1) for c in NOISE}
    assert window(noisy(late, 0.03)) == SAMPLE


def test_rows_that_are_close_are_not_asked():
    assert window(noisy(samples(100.0, "udds[20:80]"))) == SAMPLE


def test_a_log_without_flows_and_one_that_stands_are_taken_as_samples():
    log = noisy(samples(10.0))
    assert window({c: log[c] for c in ("time_s", "speed_mps")}) == SAMPLE
    log["speed_mps"] = np.zeros(len(log["time_s"]))
    assert window(log) == SAMPLE


def test_our_own_trace_and_a_stated_window_need_no_asking():
    run = means(10.0)
    assert window(run.columns) == inf
    log = Trace(noisy(samples(10.0)), name="log")
    assert drive_as_sampled(log, CAR, 0.07).window == 0.07


def test_samples_of_another_clock_are_no_means():
    """Flows 30 ms early beside a clean speed, as on a bus: the middle of no row."""
    run = means(FINE)
    rows = np.arange(6, len(run) - 20, 20)
    log = {c: run[c][rows] for c in ("time_s", "speed_mps")}
    log |= {c: run[c][rows - 6] for c in NOISE}
    assert window(noisy(log)) == SAMPLE
