"""Propagation of uncertainty, Student's quantile, correlated residuals."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import t as student

from rcc_sim.errors import InputError
from rcc_sim.identify.series import correlation_time
from rcc_sim.identify.uncertainty import mean_of_repeats, propagate, student_quantile


@given(p=st.floats(0.1, 0.999), dof=st.integers(1, 300))
def test_students_quantile_is_scipys(p, dof):
    assert student_quantile(p, dof) == pytest.approx(
        student.ppf((1 + p) / 2, dof), rel=1e-8
    )


@given(x=st.floats(-10, 10), y=st.floats(0.1, 10), s=st.floats(0.0, 1))
def test_a_linear_function_propagates_exactly(x, y, s):
    found = propagate(
        lambda x, y: 3 * x - 2 * y, {"x": x, "y": y}, {"x": s, "y": 2 * s}
    )
    assert found.sd == pytest.approx(math.hypot(3 * s, 4 * s), rel=1e-6)
    assert sum(found.budget.values()) == pytest.approx(1.0 if found.sd > 0 else 0.0)


def test_a_negative_sd_is_refused():
    with pytest.raises(InputError, match="x_sd"):
        propagate(lambda x: x, {"x": 1.0}, {"x": -0.1})


def test_intervals_of_the_mean_of_three_hold_one_sd_of_cases():
    rng = np.random.default_rng(0)
    hits = []
    for _ in range(2000):
        mean = mean_of_repeats(rng.standard_normal(3).tolist(), [0.0] * 3)
        hits.append(abs(mean.value) < mean.sd)
    assert np.mean(hits) == pytest.approx(0.683, abs=0.03)


@pytest.mark.parametrize("rho", [0.0, 0.5, 0.9])
def test_the_correlation_time_of_a_markov_process_is_the_closed_form(rho):
    rng = np.random.default_rng(1)
    noise = rng.standard_normal(20000)
    for i in range(1, noise.size):
        noise[i] += rho * noise[i - 1]
    assert correlation_time([noise]) == pytest.approx((1 + rho) / (1 - rho), rel=0.15)
