"""Stamps that jitter where rows came evenly, and rows that really came unevenly."""

import subprocess
import sys

import numpy as np
import pytest
from scipy.signal import savgol_filter

from rcc_sim.analyse.even_clock import (
    ENOUGH,
    FEW,
    SMOOTH,
    along_lines,
    even_times,
    nats_for_even,
    on_even_clock,
)
from rcc_sim.definitions.vehicle import load_vehicle
from rcc_sim.trace import Trace
from tests import one_loop

TRIP, ROW = load_vehicle("r1t_epa"), 0.1


def speed_at(time):
    return 10 + 6 * np.sin(time / 4) + 2 * np.sin(time / 1.3)


def drive(jitter, *, stamped, lost=0.0, n=1500, noise=0.005, seed=1):
    """A log of which the stamps, or the rows themselves, come so many rows off."""
    rng = np.random.default_rng(seed)
    kept = rng.random(n) >= lost
    true = ROW * np.arange(n)[kept] * (1 + 3e-5)  # a clock that is a little off
    off = np.clip(
        jitter * ROW * rng.standard_normal(len(true)), -0.45 * ROW, 0.45 * ROW
    )
    seen = true if stamped else true + off
    speed = speed_at(seen) + rng.normal(0, noise, len(true))
    return true, Trace({"time_s": true + off, "speed_mps": speed}, name="log")


@pytest.mark.parametrize("lost", [0.0, 0.002])
@pytest.mark.parametrize("jitter", [0.05, 0.2])
def test_stamps_that_jitter_are_evened(jitter, lost):
    true, log = drive(jitter, stamped=True, lost=lost)
    found, (told,) = on_even_clock(log, TRIP)
    before, after = (np.std(x["time_s"] - true) for x in (log, found))
    assert after < before / 4
    assert "jitters" in told.what and told.kind == "jitter"
    assert np.all(np.diff(found["time_s"]) > 0)
    np.testing.assert_array_equal(found["speed_mps"], log["speed_mps"])


@pytest.mark.parametrize("jitter", [0.0, 0.05, 0.2])
def test_rows_that_came_when_they_are_stamped_stay(jitter):
    _, log = drive(jitter, stamped=False)
    assert on_even_clock(log, TRIP) == (log, ())


def test_what_the_speed_does_not_tell_stays():
    """At a noise that hides it, at rest, without a speed, and in a few rows."""
    for log in (
        drive(0.1, stamped=True, noise=1.0)[1],
        drive(0.2, stamped=True, n=FEW - 1)[1],
    ):
        assert on_even_clock(log, TRIP) == (log, ())
    time = drive(0.2, stamped=True)[1]["time_s"]
    for columns in ({"speed_mps": np.zeros(len(time))}, {"yaw_rate_radps": time}):
        log = Trace({"time_s": time, **columns}, name="log")
        assert on_even_clock(log, TRIP) == (log, ())


def test_the_lines_are_those_of_a_savitzky_golay_filter():
    x = np.cumsum(np.random.default_rng(3).normal(size=600))
    expected = savgol_filter(x, SMOOTH, 1)
    np.testing.assert_allclose(along_lines(x), expected, atol=1e-9)
    few = x[:20]
    line = np.polyval(np.polyfit(range(20), few, 1), range(20))
    np.testing.assert_allclose(along_lines(few), line, atol=1e-9)


def test_a_log_of_exact_stamps_pays_for_no_filter():
    code = (
        "import numpy as np, sys; from rcc_sim.trace import Trace;"
        "from rcc_sim.analyse.even_clock import on_even_clock;"
        "t = np.round(np.arange(500) * 0.01, 3);"
        "on_even_clock(Trace({'time_s': t, 'speed_mps': t}, name='log'), None);"
        "assert 'scipy.ndimage' not in sys.modules"
    )
    subprocess.run([sys.executable, "-c", code], check=True)


@pytest.mark.parametrize("stiff", [True, False])
def test_rows_of_a_loop_that_commands_and_logs_stay(stiff):
    """A stiff car's speed goes as evenly as the cycle that is sent row by row."""
    car = load_vehicle("rcc").changed(settings=one_loop.STIFF if stiff else {})
    log = Trace(one_loop.rows(car, ROW, 0.1, 80.0, seed=5), name="log")
    even = even_times(log["time_s"])
    seems = nats_for_even(log["speed_mps"], log["time_s"], even) > ENOUGH
    assert seems is stiff
    assert on_even_clock(log, car) == (log, ())


@pytest.mark.parametrize("row", [0.02, 0.1])
def test_late_stamps_of_a_commanded_drive_are_evened(row):
    car = load_vehicle("rcc")
    came = one_loop.rows(car, row, 0.0, 80.0, seed=5)
    delays = np.random.default_rng(1).standard_normal(len(came["time_s"]))
    late = 0.15 * row * np.abs(delays)
    log = Trace({**came, "time_s": came["time_s"] + late}, name="log")
    found, (told,) = on_even_clock(log, car)
    assert told.kind == "jitter"
    off = np.std(found["time_s"] - came["time_s"])
    assert off < np.std(late) / 4
