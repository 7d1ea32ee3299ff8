"""A model that is drawn to a log by readings that came late."""

import numpy as np
import pytest

from rcc_sim.definitions.vehicle import load_vehicle
from rcc_sim.simulate.drive import drive_of
from rcc_sim.simulate.replay import earlier, replay
from rcc_sim.trace import Trace


@pytest.fixture(scope="module")
def car():
    return load_vehicle("dart_jetracer")  # its speed comes 0.13 s late


@pytest.fixture(scope="module")
def log(car):
    t = np.arange(0, 30, 0.02)
    throttle = np.where(t % 5 < 2, 0.3, 0.0)
    blank = np.zeros(len(t))
    given = {"time_s": t, "throttle": throttle, "speed_mps": blank}
    trace = Trace(given | {"steer_cmd_rad": blank}, name="pulses")
    speed = replay(car, drive_of(trace, car))["speed_mps"]
    return Trace(trace.columns | {"speed_mps": speed}, name="pulses")


def test_a_model_that_made_a_log_is_not_drawn_away_from_it(car, log):
    free = replay(car, drive_of(log, car))
    drawn = replay(car, drive_of(log, car), (0.2, 1.0, 1.0))
    assert np.abs(free["speed_mps"] - log["speed_mps"]).max() < 1e-9
    off = np.abs(drawn["speed_mps"] - log["speed_mps"])
    assert off.max() < 0.03 * log["speed_mps"].max()  # less than a row is off


def test_a_late_reading_goes_to_the_row_it_belongs_to(car, log):
    drive = drive_of(log, car)
    x = np.arange(len(drive.time), dtype=float)
    assert earlier(drive, x, 0.0) is x
    moved = earlier(drive, x, 0.13)  # six rows and a half
    np.testing.assert_array_equal(moved[:-7], x[6:-1])
    assert np.isnan(moved[-6:]).all()  # nobody knows yet


def test_what_was_not_read_stays_unknown(car, log):
    drive = drive_of(log, car)
    x = np.ones(len(drive.time))
    x[100:110] = np.nan
    assert np.isnan(earlier(drive, x, 0.1)[95:105]).all()
    assert np.isfinite(earlier(drive, x, 0.1)[:95]).all()
