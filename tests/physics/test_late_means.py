"""Readings that come late: the spline of their running integral, by another route."""

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from rcc_sim.physics.effects import sensor_delay
from rcc_sim.physics.effects.sensor_delay import late, spline


@pytest.fixture(params=["plain", "compiled"])
def way(request, monkeypatch):
    """Both ways that the kernel code may run."""
    fast = request.param == "compiled"
    monkeypatch.setattr(sensor_delay, "compiler_is_loaded", lambda: fast)


def test_it_is_scipys_spline_with_the_slopes_of_secants_at_its_ends(way):
    rng = np.random.default_rng(1)
    time = np.cumsum(rng.uniform(0.05, 0.15, 200))
    values = np.cumsum(rng.standard_normal(200))
    at = np.sort(rng.uniform(time[0], time[-1], 300))
    at[0], at[-1] = time[0], time[-1]
    ends = np.gradient(values, time)[[0, -1]]
    known = CubicSpline(time, values, bc_type=((1, ends[0]), (1, ends[1])))
    np.testing.assert_allclose(spline(at, time, values), known(at), atol=1e-12)


@pytest.mark.parametrize("rows", [2, 3, 4])
def test_a_few_rows_are_a_line_or_a_parabola(way, rows):
    time = np.linspace(0.0, 1.0, rows)
    at = np.linspace(0.0, 1.0, 11)
    np.testing.assert_allclose(spline(at, time, 1 + 2 * time), 1 + 2 * at)


def test_means_that_come_late_lose_nothing(way):
    """What was drawn until the end, a delay ago, is what the late means add up to."""
    time = np.arange(0.0, 20.0, 0.1)
    power = 100 + 50 * np.sin(time)
    seen = late(power, time, 0.25, False)
    until = CubicSpline(time, np.concatenate([[0], np.cumsum(0.1 * power[1:])]))
    before = power[1] * 0.25  # the first value holds before the start
    assert 0.1 * seen[1:].sum() == pytest.approx(before + until(time[-1] - 0.25))
