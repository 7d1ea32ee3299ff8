"""What a logged steering does between its rows."""

from types import SimpleNamespace

import numpy as np
import pytest
from scipy.interpolate import CubicHermiteSpline

from rcc_sim.physics.logged_steering import STRAIGHT, enter_cell, steering_at
from rcc_sim.physics.tables import BEFORE, LINE, SINCE
from rcc_sim.simulate.drive import drive_of
from rcc_sim.simulate.replay import replay
from rcc_sim.trace import Trace
from tests.cars import car

AT = np.linspace(0.0, 3.0, 1201)


def between(time, steer, at, held=LINE):
    """The kernel's steering at some times."""
    u, found = SimpleNamespace(), []
    for t in at:
        i = min(int(np.searchsorted(time, t, side="right")) - 1, len(time) - 2)
        enter_cell(u, time, steer, i, held)
        found.append(steering_at(u, t))
    return np.array(found)


@pytest.fixture
def rows():
    """Rows of 0.1 s that jitter, and a turn every eight of them."""
    jitter = np.random.default_rng(2).uniform(-0.02, 0.02, 31)
    time = np.linspace(0.0, 3.0, 31) + jitter * (np.arange(31) % 30 > 0)
    return time, 0.2 * np.sin(2 * np.pi * time / 0.8)


def test_a_hand_moves_along_hermites_cubic_with_the_slopes_of_parabolas(rows):
    time, steer = rows
    slopes = np.gradient(steer, time)
    inner = AT[(AT >= time[1]) & (AT <= time[-2])]
    expected = CubicHermiteSpline(time, steer, slopes)(inner)
    # where a line is taken it errs by a sixteenth of its bend
    assert between(time, steer, inner) == pytest.approx(expected, abs=STRAIGHT / 8)


def test_it_cuts_no_turn_as_a_line_does(rows):
    time, steer = rows
    true = 0.2 * np.sin(2 * np.pi * AT / 0.8)
    inner = (AT >= time[1]) & (AT <= time[-2])
    curve, line = between(time, steer, AT), np.interp(AT, time, steer)
    off = [float(np.std((x - true)[inner])) for x in (curve, line)]
    assert off[0] < 0.25 * off[1]


def test_at_its_ends_it_runs_straight_and_a_held_one_is_a_rows(rows):
    time, steer = rows
    ends = AT[(AT < time[1]) | (AT >= time[-2])]
    assert between(time, steer, ends) == pytest.approx(np.interp(ends, time, steer))
    last = np.searchsorted(time, AT[:-1], side="right") - 1
    assert between(time, steer, AT[:-1], SINCE) == pytest.approx(steer[last])
    assert between(time, steer, AT[:-1], BEFORE) == pytest.approx(steer[last + 1])
    u = SimpleNamespace()
    enter_cell(u, time, steer, 0, LINE)
    assert steering_at(u, -0.1) == steer[0]
    for held in (LINE, SINCE, BEFORE):
        enter_cell(u, time[:1], np.array([0.1]), 0, held)
        assert steering_at(u, 5.0) == 0.1


@pytest.mark.parametrize("imposed", [True, False])
def test_seldom_rows_turn_the_car_as_many_do(imposed):
    """A slalom of 1.25 Hz at 10 Hz, held against the same at 1 kHz."""
    found = []
    for row in (0.1, 0.001):
        t = np.arange(0, 12, row)
        columns = {"time_s": t, "steer_cmd_rad": 0.1 * np.sin(2 * np.pi * t / 0.8)}
        columns["speed_mps" if imposed else "speed_ref_mps"] = np.minimum(t, 3.0)
        drive = drive_of(Trace(columns), car())
        assert not drive.held[1]
        found.append(replay(car(), drive)["yaw_rate_radps"][:: round(0.1 / row)])
    seldom, often = (x[40:] for x in found)
    assert np.std(seldom - often) < 0.02 * np.std(often)
