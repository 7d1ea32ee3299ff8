"""What a channel's rows are, by the average of a signal that they go with most."""

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from rcc_sim.simulate.spans import STRETCHES, middle_of

ROWS = 2000
KNOTS = np.random.default_rng(2).standard_normal(ROWS // 3)
SIGNAL = CubicSpline(np.linspace(-2.0, ROWS + 2.0, len(KNOTS)), KNOTS).antiderivative()


def mean(since, until):
    """Mean of the signal between two times about each row. [rows]"""
    at = np.arange(ROWS)
    return (SIGNAL(at + until) - SIGNAL(at + since)) / (until - since)


@pytest.mark.parametrize("noise", [0.0, 0.3])
@pytest.mark.parametrize(
    ("since", "until", "off"),
    [(-1.0, 0.0, 0.0), (-0.8, 0.2, 0.2), (-0.5, 0.5, 0.5), (-1.5, -0.5, -0.5)],
)
def test_its_middle_is_told_whatever_the_speed_errs(since, until, off, noise):
    rng = np.random.default_rng(3)
    seen = 3.0 * mean(since, until) + 0.2 + rng.normal(0.0, 0.2, ROWS)
    # a speed that errs shows as an acceleration since the row before, halves alike
    error = np.diff(rng.normal(0.0, noise, ROWS + 1))
    shown = [(seen, mean(-1.0, 0.0) + error, mean(-0.5, 0.0) + error)]
    told, sd = middle_of(shown)
    assert told == pytest.approx(off, abs=0.05 + 3 * sd)
    assert sd < (0.05 if noise else 0.02)


def test_a_wrong_sign_and_lost_rows_are_no_matter():
    seen = -mean(-1.0, 0.0)
    seen[100:300] = np.nan
    told, _ = middle_of([(seen, mean(-1.0, 0.0), mean(-0.5, 0.0))])
    assert told == pytest.approx(0.0, abs=0.02)


def test_where_nothing_changes_nothing_is_told():
    few = np.zeros(STRETCHES - 2)
    assert middle_of([(few, few, few)]) == (0.0, np.inf)
    still = np.zeros(ROWS)
    assert middle_of([(still, still, still)]) == (0.0, np.inf)
    assert middle_of([]) == (0.0, np.inf)
