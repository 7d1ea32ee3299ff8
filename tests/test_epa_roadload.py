"""Electric cars' certified consumption from certified road load."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

from benchmarks import epa_fastsim, epa_tests
from benchmarks import epa_roadload as epa

BAR = 8.0  # %; mean absolute error that issue and README promise
WITH_DATA = pytest.mark.skipif(
    not epa.DEFAULT.is_file(),
    reason="the EPA's test-car list is not beside the project",
)
ROW = {epa.A: 40.0, epa.B: 0.2, epa.C: 0.02, epa.WEIGHT: 4000.0, epa.POWER: 200.0}


@pytest.fixture(scope="module")
def tests():
    return epa.read_tests(epa.DEFAULT)


@pytest.fixture(scope="module")
def battery(tests):
    return epa.predicted(tests)


def mean_error(tests, battery, charger):
    return epa_tests.score(epa.errors(tests, battery, charger)).mean_abs


@WITH_DATA
def test_most_of_the_list_can_be_predicted(tests):
    assert len(tests) > 150
    assert tests["held_out"].mean() == pytest.approx(0.5, abs=0.15)


@WITH_DATA
def test_every_model_of_the_list_has_a_family_and_a_family_one_half(tests):
    assert set(tests["family"]) <= set(epa_tests.FAMILIES.values())
    assert (tests.groupby("family")["held_out"].nunique() == 1).all()


@WITH_DATA
def test_cars_are_predicted_with_stated_efficiencies(tests, battery):
    assert mean_error(tests, battery, epa.CHARGER) < BAR


@WITH_DATA
@pytest.mark.parametrize("second", [True, False])
def test_a_half_is_predicted_with_a_charger_fitted_on_the_other(tests, battery, second):
    held = tests["held_out"].to_numpy() == second
    charger = epa.fitted_charger(tests[~held], battery[~held])
    assert mean_error(tests[held], battery[held], charger) < BAR


@WITH_DATA
def test_the_stated_figures_predict_better_than_fastsims(tests, battery):
    pytest.importorskip("fastsim", minversion="3.1", reason="needs FASTSim 3")
    some = np.arange(len(tests)) % 4 == 0  # theirs takes long; the benchmark has all
    theirs = epa_fastsim.battery_energies(tests[some])
    ours = mean_error(tests[some], battery[some], epa.CHARGER)
    assert ours < mean_error(tests[some], theirs, epa_fastsim.CHARGER)


def test_a_lossless_car_needs_its_road_load_and_no_more(monkeypatch):
    """Brakes give back what the mass took, so that only A d is left."""
    for name in ("GEAR", "BATTERY"):
        monkeypatch.setattr(epa, name, 1.0)
    monkeypatch.setattr(epa, "MOTOR", (1.0,) * len(epa.MOTOR))
    row = pd.DataFrame([ROW | {epa.B: 0.0, epa.C: 0.0, "cycle": "udds"}])
    used = epa.predicted(row, auxiliary=0.0)[0]
    assert used == pytest.approx(40 * epa.LBF * 100 * epa.MILE / epa.KWH, rel=1e-6)


def test_the_written_map_is_the_curve_over_load(tmp_path):
    file = tmp_path / "map.csv"
    epa.write_map(file, m=2000.0, power=2e5)
    rows = pd.read_csv(file)
    load = rows["torque_nm"] * rows["speed_radps"] / 2e5
    at = {0.0: 0.84, 0.05: 0.89, 0.1: 0.92, 0.5: 0.95}
    for share, eta in at.items():
        near = (load - share).abs() < 0.004
        assert rows["efficiency"][near].to_numpy() == pytest.approx(eta, abs=0.006)


def test_the_best_charger_leaves_less_error_than_any_other():
    draw = np.random.default_rng(1)
    listed = draw.uniform(15.0, 40.0, 31)
    battery = 0.9 * listed * draw.uniform(0.8, 1.2, 31)
    rows = pd.DataFrame({"listed": listed})
    best = mean_error(rows, battery, epa.fitted_charger(rows, battery))
    others = [mean_error(rows, battery, c) for c in np.linspace(0.6, 1.2, 601)]
    assert best <= min(others)


def test_fastsims_drag_holds_a_road_load_without_a_linear_term():
    fastsim = pytest.importorskip("fastsim", minversion="3.1", reason="FASTSim 3")
    drag, rolling = epa_fastsim.drag(pd.Series(ROW | {epa.B: 0.0}))
    m = 4000.0 * epa.LB
    assert rolling * m * epa_fastsim.G == pytest.approx(40.0 * epa.LBF)
    force = 0.5 * fastsim.Air.get_density() * epa_fastsim.AREA * drag * 20.0**2
    assert force == pytest.approx(0.02 * (20.0 / epa.MPH) ** 2 * epa.LBF)


def test_an_absent_list_is_said_and_is_no_failure(tmp_path, capsys):
    epa.main([str(tmp_path / "none.csv")])
    assert "no such file" in capsys.readouterr().out


def test_the_score_knows_sign_and_size():
    found = epa_tests.score(np.array([-2.0, 4.0]))
    assert (found.mean_abs, found.median_abs, found.bias) == (3.0, 3.0, 1.0)
