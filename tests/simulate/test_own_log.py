"""A car's simulated log, run again by the same car, is the log."""

import numpy as np
import pytest

from rcc_sim.definitions.cycle import Cycle
from rcc_sim.simulate.drive import drive_of
from rcc_sim.simulate.replay import replay
from rcc_sim.simulate.run import simulate
from tests.cars import car

CYCLE = Cycle("waves", np.arange(31.0), 2 + 1.5 * np.sin(np.arange(31.0)))


@pytest.mark.parametrize("period", [0.0, 0.01, 0.05, 0.25])
def test_a_reference_in_steps_comes_when_the_log_says(period):
    stepped = car({"reference_sampling": {"period_s": period}})
    log = simulate(stepped, CYCLE, output_rate=100.0).trace
    again = replay(stepped, drive_of(log, stepped))
    assert again["speed_mps"] == pytest.approx(log["speed_mps"], abs=2e-3)
    off = again["motor_current_a"] - log["motor_current_a"]
    assert np.sqrt(np.mean(off**2)) < 0.02 * np.std(log["motor_current_a"])
