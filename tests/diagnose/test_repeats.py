"""Repeats of a drive tell its noise: what they share is none, however it remembers."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import lfilter

from rcc_sim.definitions.cycle import parse_cycle
from rcc_sim.definitions.vehicle import load_vehicle
from rcc_sim.diagnose.fitting.engine import Engine
from rcc_sim.diagnose.residuals.posed import problem_of
from rcc_sim.diagnose.residuals.repeated import not_shared
from rcc_sim.diagnose.run import diagnose
from rcc_sim.similitude.cycles import scale_cycle
from rcc_sim.simulate.run import LaneChanges, simulate
from rcc_sim.trace import Trace
from tests.scaled_drive import NOISE, drive, logged

CAR = load_vehicle("rcc")
MOTOR, NOISY = "motor_current_a", NOISE["motor_current_a"]


def coming_and_going(rows, seed):
    """A course that forgets itself within a second, of unit size."""
    kept = np.exp(-0.01 / 0.7)
    white = np.random.default_rng(seed).normal(size=rows)
    return lfilter([np.sqrt(1 - kept**2)], [1, -kept], white)


@pytest.fixture(scope="module")
def run():
    return drive(CAR, LaneChanges(6.0))


def log_of(run, seed, folder, more, late=0.0):
    """Return the drive as one more log, its motor's current by so much off."""
    columns = dict(run.columns)
    columns[MOTOR] = columns[MOTOR] + more
    log = logged(Trace(columns, name="log"), CAR, seed, folder)
    later = {**log.log.columns, "time_s": log.log["time_s"] + late}
    return replace(log, log=Trace(later, name=log.log.name))


def test_what_logs_share_cancels_and_their_noise_keeps_its_size(run, tmp_path):
    shared = 3 * NOISY * coming_and_going(len(run), 1)
    one, *others = (
        problem_of(log_of(run, k, tmp_path, shared, late=5.0 * k).log, CAR)
        for k in range(3)
    )
    off = one.residuals({})[one.channels.index(MOTOR)]
    apart = not_shared(one, others)
    assert apart.keys() == set(one.channels)
    assert np.nanstd(off) > 2.5 * NOISY
    assert np.nanstd(apart[MOTOR]) == pytest.approx(NOISY, rel=0.05)
    assert np.nanstd(apart["accel_y_mps2"]) == pytest.approx(0.1, rel=0.05)


def test_a_repeat_that_ends_early_tells_as_far_as_it_goes(run, tmp_path):
    one, other = (problem_of(log_of(run, k, tmp_path, 0.0).log, CAR) for k in (0, 1))
    half = Trace({c: x[:3000] for c, x in other.log.columns.items()}, name="half")
    apart = not_shared(one, [problem_of(half, CAR)])[MOTOR]
    assert np.isfinite(apart[1:3000]).all()
    assert np.isnan(apart[3000:]).all()


@pytest.mark.parametrize("shares", [True, False], ids=["shared", "not shared"])
def test_a_memory_is_that_of_the_noise_alone(run, tmp_path, shares):
    """What comes and goes at the same places in each log is no noise; else it is."""
    logs = [
        log_of(run, k, tmp_path, NOISY * coming_and_going(len(run), 1 if shares else k))
        for k in range(3)
    ]
    one, *others = (problem_of(log.log, CAR) for log in logs)
    track = one.channels.index(MOTOR)
    left = one.residuals({})
    alone = Engine([one]).learn_noise(left)[track]
    told = Engine([replace(one, noise=not_shared(one, others))]).learn_noise(left)
    assert alone.foresees(left[track]) > 0.3
    foreseen = told[track].foresees(left[track])
    if shares:
        assert abs(foreseen) < 0.1
    else:
        assert foreseen == pytest.approx(alone.foresees(left[track]), abs=0.1)


@pytest.mark.slow
@pytest.mark.parametrize("seed", [1, pytest.param(2, marks=pytest.mark.thorough)])
def test_bumps_that_pass_for_noise_in_one_log_are_told_by_its_repeats(seed, tmp_path):
    """Slopes of 0.6 % that change every 0.8 m, under the same wheels each time."""
    way = np.arange(0, 120, 0.05)
    kept = np.exp(-0.05 / 0.8)
    white = np.random.default_rng(seed).normal(size=len(way))
    bumps = 0.006 * lfilter([np.sqrt(1 - kept**2)], [1, -kept], white)
    cycle = scale_cycle(parse_cycle("udds[20:125]"), of=load_vehicle("r1t"), to=CAR)
    bumpy = simulate(CAR, cycle.cycle, lanes=LaneChanges(6.0), slope=(way, bumps)).trace
    one, *others = (log_of(bumpy, k, tmp_path, 0.0) for k in range(3))
    assert diagnose([one], CAR).status == "no_gap"
    found = diagnose([one], CAR, repeats=[other.log for other in others])
    assert found.status != "no_gap"
    assert [a.cause.effect for a in found.asserted] in ([], ["road_grade"])
    assert found.asserted or found.left.acts_as == "drag"


@pytest.mark.slow
def test_repeats_that_scatter_more_make_no_gap_of_a_clean_log(run, tmp_path):
    wander = [0.7 * NOISY * coming_and_going(len(run), k) for k in (6, 7)]
    clean, *others = (
        log_of(run, k, tmp_path, more) for k, more in enumerate((0.0, *wander))
    )
    found = diagnose([clean], CAR, repeats=[other.log for other in others])
    assert found.status == "no_gap"
