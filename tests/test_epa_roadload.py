"""Electric cars' certified consumption from certified road load."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks import epa_roadload as epa

# Guards against a step back, not targets: 7.5 % and 8.1 % were measured on the 2022
# list; one is added.
HELD_OUT_STATED = 8.5  # %
HELD_OUT_FITTED = 9.1  # %
WITH_DATA = pytest.mark.skipif(
    not epa.DEFAULT.is_file(),
    reason="the EPA's test-car list is not beside the project",
)


@pytest.fixture(scope="module")
def tests():
    return epa.read_tests(epa.DEFAULT)


@WITH_DATA
def test_most_of_the_list_can_be_predicted(tests):
    assert len(tests) > 150
    assert tests["held_out"].mean() == pytest.approx(0.5, abs=0.15)


@WITH_DATA
def test_no_model_is_in_both_halves(tests):
    assert (tests.groupby(epa.MODEL)["held_out"].nunique() == 1).all()


@WITH_DATA
def test_held_out_cars_are_predicted_with_stated_efficiencies(tests):
    found = epa.score(epa.errors(tests[tests["held_out"]]))
    assert found.mean_abs < HELD_OUT_STATED


@WITH_DATA
def test_held_out_cars_are_predicted_with_a_motor_fitted_on_the_others(tests):
    motor = epa.fitted_motor(tests[~tests["held_out"]])
    found = epa.score(epa.errors(tests[tests["held_out"]], motor))
    assert found.mean_abs < HELD_OUT_FITTED


def test_a_lossless_car_needs_its_road_load_and_no_more_at_the_wall(monkeypatch):
    """Brakes give back what the mass took, so that only A d is left."""
    for name in ("GEAR", "BATTERY", "CHARGER"):
        monkeypatch.setattr(epa, name, 1.0)
    monkeypatch.setattr(epa, "AUXILIARY", 0.0)
    row = {epa.A: 40.0, epa.B: 0.0, epa.C: 0.0, epa.WEIGHT: 4000.0}
    used = epa.wall_energy(row, epa.parse_cycle("udds"), 1.0)
    assert used == pytest.approx(40 * epa.LBF * 100 * epa.MILE / epa.KWH, rel=1e-6)


def test_an_absent_list_is_said_and_is_no_failure(tmp_path, capsys):
    epa.main([str(tmp_path / "none.csv")])
    assert "no such file" in capsys.readouterr().out


def test_the_score_knows_sign_and_size():
    found = epa.score(np.array([-2.0, 4.0]))
    assert (found.mean_abs, found.median_abs, found.bias) == (3.0, 3.0, 1.0)
