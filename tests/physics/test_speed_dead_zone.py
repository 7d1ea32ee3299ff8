"""The dead zone of a digital loop: what it sees is a mean over when it looks."""

import numpy as np
import pytest

from rcc_sim.definitions.cycle import Cycle
from rcc_sim.diagnose.residuals.posed import problem_of
from rcc_sim.physics.effects.speed_dead_zone import seen_speed
from rcc_sim.simulate.run import simulate
from rcc_sim.trace import Trace
from tests.cars import car

LAUNCH = Cycle("launch", np.array([0.0, 1.0, 4.0]), np.array([0.0, 0.0, 4.0]))
SHY = {
    "rolling_resistance": {"coefficient": 0.02},
    "speed_dead_zone": {"threshold_radps": 60.0},
}


def test_without_a_dead_zone_the_speed_is_seen_to_the_last_bit():
    assert seen_speed(0.3, 0.0, 5.0) == 0.3


@pytest.mark.parametrize("omega", np.linspace(57.0, 63.0, 25))
@pytest.mark.parametrize("change", [0.0, 0.5, 4.0])
def test_while_it_passes_the_threshold_the_mean_over_the_ticks_is_seen(omega, change):
    when = (np.arange(2000) + 0.5) / 2000 - 0.5  # of a tick, before or after
    there = np.mean(omega + when * change >= 60.0)
    assert seen_speed(omega, 60.0, change) == pytest.approx(omega * there, abs=0.1)


def test_a_launch_changes_as_little_as_the_figures_do():
    """A loop that looked at the ticks alone would jump by amperes in one row."""
    shy = car(SHY)
    trace = simulate(shy, LAUNCH).trace
    names = ("time_s", "speed_ref_mps", "speed_mps", "motor_current_a")
    problem = problem_of(Trace({n: trace[n] for n in names}, name="log"), shy)
    key = "effects.rolling_resistance.coefficient"

    def current(more):
        return problem.predict({key: 0.02 + more})["motor_current_a"]

    start = current(0.0)
    changes = [np.abs(current(k * 1e-3) - start).max() / k for k in range(1, 11)]
    assert changes == pytest.approx(np.full(10, changes[0]), rel=0.05)
