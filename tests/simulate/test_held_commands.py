"""Commands that hold between rows, and commands that run straight."""

import numpy as np
import pytest

from rcc_sim.simulate.drive import drive_of, holds
from rcc_sim.simulate.replay import replay
from rcc_sim.trace import Trace
from tests.cars import car

T = np.arange(0, 12, 0.1)
SPEED = np.minimum(T, 2.0)


def test_messages_hold_and_hands_move():
    stepped = np.where((T // 2) % 2 > 0, 0.2, 0.0)
    assert holds(stepped)
    assert holds(stepped + 0.1 * (T > 7.05))
    assert not holds(0.2 * np.sin(T))
    assert not holds(np.interp(T, [0, 4, 5, 8, 9, 12], [0, 0, 0.2, 0.2, 0, 0]))
    assert not holds(0 * T)


def test_a_command_that_holds_acts_from_its_row_on():
    """The yaw angle of a step is the steady rate times the time since its own row."""
    steer = np.where(T > 5.95, 0.1, 0.0)
    log = Trace({"time_s": T, "speed_ref_mps": SPEED, "steer_cmd_rad": steer})
    drive = drive_of(log, car())
    assert drive.held == (False, True)
    out = replay(car(), drive)
    rate = out["yaw_rate_radps"]
    assert abs(rate[T < 6.01]).max() == 0.0
    begins = T[-1] - out["yaw_rad"][-1] / rate[-1]  # less what the yaw takes to settle
    assert begins == pytest.approx(6.0, abs=0.03)


@pytest.mark.parametrize("imposed", [True, False])
def test_the_heading_is_the_integral_of_the_yaw_rate(imposed):
    t = np.arange(0, 12, 0.01)
    steer = 0.1 * np.sin(1.3 * t)
    columns = {"time_s": t, "steer_cmd_rad": steer}
    columns["speed_mps" if imposed else "speed_ref_mps"] = np.minimum(t, 2.0)
    drive = drive_of(Trace(columns), car())
    assert drive.imposed == imposed
    out = replay(car(), drive)
    rate = out["yaw_rate_radps"]
    sums = np.concatenate([[0.0], np.cumsum(0.5 * (rate[1:] + rate[:-1]) * 0.01)])
    np.testing.assert_allclose(out["yaw_rad"], sums, atol=2e-3)


def test_a_gyro_is_held_against_the_heading_where_that_was_measured():
    t = np.arange(0, 12, 0.01)
    columns = {"time_s": t, "steer_cmd_rad": 0.1 * np.sin(t), "speed_mps": 0 * t + 2}
    late = car({"sensor_delay": {"yaw_rate_delay_s": 0.1}})
    true = np.where(t < 6, 3.0 * np.cos(t), np.nan)
    drive = drive_of(Trace(columns), car())
    out = replay(late, drive, turned=true)["yaw_rate_radps"]
    seen = (t > 0.2) & (t < 5.9)
    np.testing.assert_allclose(out[seen], 3 * np.cos(t - 0.1)[seen], atol=1e-3)
    model = replay(late, drive)["yaw_rate_radps"]
    np.testing.assert_allclose(out[t > 6.2], model[t > 6.2])
