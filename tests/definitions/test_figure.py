"""How far a figure may be off, however its file says so."""

from types import SimpleNamespace

import pytest
from scipy.stats import norm

from rcc_sim.definitions.figure import Figure
from rcc_sim.diagnose.residuals.terminals import knows_voltage


@pytest.mark.parametrize(
    ("raw", "sd"),
    [
        (57.6, 0.0),
        ({"value": 57.6, "sd": 0.4}, 0.4),
        ({"value": 57.6, "sd": 0.4, "low": 50.0, "high": 60.0}, 0.4),
    ],
)
def test_a_tolerance_is_the_sd_where_one_is_stated(raw, sd):
    assert Figure.parse(raw).tolerance == sd


def test_nine_in_ten_lie_within_a_range():
    figure = Figure.parse([56.0, 59.0])
    within = norm(figure.value, figure.tolerance)
    assert within.cdf(59.0) - within.cdf(56.0) == pytest.approx(0.9)


@pytest.mark.parametrize(
    ("stated", "known"),
    [(57.6, True), ({"value": 57.6, "sd": 0.4}, False), ([56.0, 59.0], False)],
)
def test_a_voltage_with_a_range_is_known_no_better_than_one_with_an_sd(stated, known):
    battery = SimpleNamespace(open_circuit_voltage_v=Figure.parse(stated))
    assert knows_voltage(SimpleNamespace(battery=battery)) is known
