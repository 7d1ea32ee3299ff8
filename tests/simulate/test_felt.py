"""An accelerometer whose rows are means is as good a witness as one of samples."""

import numpy as np
import pytest

from rcc_sim.simulate.smooth import felt_as, smoothed

ROW, NOISE, FELT = 0.2, 0.03, 0.05
TIME = np.arange(0.0, 400.0, ROW)
CORNERS = np.arange(0.0, 401.0, 4.1)


def speed(t):
    rng = np.random.default_rng(5)
    return np.interp(t, CORNERS, 15 + np.cumsum(rng.normal(0, 1.5, len(CORNERS))))


def mean_accel(t, over):
    """Mean acceleration over a time before t, in closed form. [m/s²]"""
    return (speed(t) - speed(t - over)) / over


@pytest.fixture(scope="module")
def seen():
    return speed(TIME) + np.random.default_rng(6).normal(0, NOISE, len(TIME))


def felt(over):
    rng = np.random.default_rng(7)
    return mean_accel(TIME, over) + 0.1 + rng.normal(0, FELT, len(TIME))


@pytest.mark.parametrize("likely", [True, False])
@pytest.mark.parametrize(("over", "means"), [(ROW, True), (1e-3, False)])
def test_means_and_samples_are_told_whatever_is_likely(seen, over, means, likely):
    found = felt_as(TIME, seen, felt(over), noise=NOISE, means=likely)
    assert found.means == means


def test_what_says_nothing_is_as_the_other_rows(seen):
    noise = np.random.default_rng(8).normal(0, 5.0, len(TIME))
    for likely in (True, False):
        assert felt_as(TIME, seen, noise, noise=NOISE, means=likely).means == likely


def test_close_rows_are_not_asked(seen):
    near = felt_as(TIME / 10, seen, felt(ROW), noise=NOISE, means=True)
    assert not near.means


@pytest.mark.parametrize("over", [ROW, 1e-3])
def test_an_accelerometer_makes_the_motion_better_known(seen, over):
    calm = smoothed(TIME, seen, felt(over), means=over == ROW)
    bare = smoothed(TIME, seen)
    true = mean_accel(TIME, ROW)
    off, without = (
        np.std((np.diff(x.speed) / ROW - true[1:])[50:-50]) for x in (calm, bare)
    )
    assert off < 0.9 * without
    assert np.std(calm.speed - speed(TIME)) < np.std(bare.speed - speed(TIME))


def test_a_row_on_the_heels_of_another_bends_nothing(seen):
    """Two rows 20 µs apart, as a logger's clock makes them, had no finite solution."""
    time = TIME.copy()
    time[100] = time[99] + 2e-5
    calm = smoothed(time, seen)
    alone = smoothed(TIME, seen)
    assert np.abs(calm.speed - alone.speed)[200:].max() < 0.05 * NOISE
    assert np.isfinite(calm.speed).all()
