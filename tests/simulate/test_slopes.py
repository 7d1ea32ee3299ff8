"""The acceleration at a row of a speed that is seldom logged and not smoothed."""

import numpy as np
import pytest

from rcc_sim.simulate.smooth import slope_at

TIME = np.arange(0.0, 60.0)


@pytest.mark.parametrize("corner", [20.0, 20.01, 20.3, 20.5, 20.99])
def test_ramps_keep_their_slopes_wherever_their_corners_are(corner):
    """Central differences are off by half the change of slope at either row."""
    speed = 5.0 + 1.2 * np.minimum(TIME, corner) - 0.7 * np.maximum(TIME - corner, 0)
    true = np.where(corner > TIME, 1.2, -0.7)
    away = corner != TIME  # at a corner it has both
    assert slope_at(TIME, speed)[away] == pytest.approx(true[away], abs=1e-6)
    assert slope_at(TIME, speed)[~away] == pytest.approx(0.25)


def test_a_steady_bend_has_the_slope_halfway():
    slope = slope_at(TIME, 3.0 + 0.02 * TIME**2)
    assert slope[2:-2] == pytest.approx(0.04 * TIME[2:-2])


def test_rows_need_not_be_evenly_apart():
    time = np.cumsum(np.random.default_rng(1).uniform(0.8, 1.2, 60))
    assert slope_at(time, 4.0 + 0.5 * time) == pytest.approx(0.5)


def test_noise_does_not_choose_the_side():
    """Between two rows' noise the mean is best: no slope is far noisier than that."""
    rng = np.random.default_rng(3)
    speed = 20.0 + rng.normal(0, 0.05, 4000)
    time = np.arange(4000.0)
    ours, central = slope_at(time, speed), np.gradient(speed, time)
    assert np.std(ours) < 1.2 * np.std(central)
