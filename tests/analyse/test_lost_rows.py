"""Rows that a logger lost are put back, empty: commands went on in them."""

from dataclasses import replace
from math import inf

import numpy as np
import pytest

from rcc_sim.analyse.logged import open_log
from rcc_sim.analyse.lost_rows import with_lost_rows
from rcc_sim.definitions.vehicle import load_vehicle
from rcc_sim.physics.tables import SINCE
from rcc_sim.simulate.drive import drive_of
from rcc_sim.simulate.replay import replay
from rcc_sim.trace import Trace
from tests import one_loop

CAR = load_vehicle("rcc").changed(settings=one_loop.STIFF)
ROW = 0.05
TIME = ROW * np.arange(600)
SENT = {
    "time_s": TIME,
    "speed_ref_mps": one_loop.wanted(TIME),
    "steer_cmd_rad": 0.1 * np.sin(2.0 * TIME),
}


def answered(log):
    """Return what a car does whose commands hold from row to row."""
    drive = replace(drive_of(log, CAR, inf), held=(SINCE, SINCE))
    return replay(CAR, drive)


def without(rows, columns=SENT):
    kept = np.setdiff1d(np.arange(len(columns["time_s"])), rows)
    return kept, Trace({c: x[kept] for c, x in columns.items()}, name="log")


@pytest.mark.parametrize("at_once", [1, 2, 3])
def test_a_car_goes_on_by_commands_in_rows_that_were_lost(at_once):
    """Held since the last row, its last command would come late by every one of them.

    And the mean of a current since the row before is not one since the last that came.
    """
    true = answered(Trace(SENT, name="log"))
    lost = np.concatenate([np.arange(n, n + at_once) for n in range(40, 590, 23)])
    kept, log = without(lost)
    filled = with_lost_rows(log, CAR)
    np.testing.assert_allclose(filled["time_s"], TIME, atol=1e-9)
    assert np.isnan(filled["speed_ref_mps"][lost]).all()
    there = answered(filled)
    asleep = answered(log)
    for name in ("yaw_rate_radps", "motor_current_a", "speed_mps"):
        off = np.std(there[name][kept] - true[name][kept])
        was = np.std(asleep[name] - true[name][kept])
        assert off < 0.3 * was


@pytest.mark.parametrize("jitter", [0.1, 0.3])
def test_a_loop_that_runs_late_has_lost_none(jitter):
    log = Trace(one_loop.rows(CAR, ROW, jitter, 40.0, seed=3), name="log")
    assert with_lost_rows(log, CAR) is log


def test_a_logger_that_writes_what_changes_has_lost_none():
    rng = np.random.default_rng(1)
    kept = np.cumsum(1 + (rng.random(400) < 0.2) * rng.integers(1, 4, 400))
    _, log = without(np.setdiff1d(np.arange(600), kept[kept < 600]))
    assert with_lost_rows(log, CAR) is log


def test_neither_a_pause_nor_a_drive_without_commands_is_filled():
    paused = {**SENT, "time_s": TIME + 100.0 * (TIME > 10.0)}
    assert len(with_lost_rows(Trace(paused, name="log"), CAR)) == len(TIME)
    _, log = without([100], {"time_s": TIME, "speed_mps": SENT["speed_ref_mps"]})
    assert with_lost_rows(log, CAR) is log


def test_a_log_is_opened_with_the_rows_that_it_lost(tmp_path):
    _, log = without([100, 250], answered(Trace(SENT, name="log")) | SENT)
    columns = [c for c in log.columns if np.isfinite(log[c]).all()]
    np.savetxt(
        tmp_path / "log.csv",
        np.column_stack([log[c] for c in columns]),
        delimiter=",",
        header=",".join(columns),
        comments="",
    )
    opened = open_log(tmp_path / "log.csv", CAR)
    assert len(opened.log) == len(TIME)
    assert np.isnan(opened.log["speed_mps"][[100, 250]]).all()
    (told,) = [f for f in opened.findings if f.kind == "lost_rows"]
    assert "about 2 rows" in told.what
