"""Draws follow the file: its sds, its ranges, and what has a meaning."""

from __future__ import annotations

import numpy as np
import pytest

from rcc_sim.batch.draws import (
    METHODS,
    at_levels,
    file_draws,
    quantiles,
    read_draws,
    uncertain_figures,
    unit_draws,
)
from rcc_sim.definitions.figure import Figure
from rcc_sim.definitions.vehicle import load_vehicle
from rcc_sim.errors import InputError
from tests.cars import car, truck

INF = float("inf")


@pytest.mark.parametrize("method", METHODS)
def test_draws_of_an_sd_have_its_mean_and_sd(method):
    figure = Figure(3.8, sd=0.1)
    u = unit_draws(4096, 2, method, seed=1)
    values = quantiles(figure, u[:, 1], (0.0, INF))
    assert values.mean() == pytest.approx(3.8, abs=4 * 0.1 / 64)
    assert values.std() == pytest.approx(0.1, rel=0.05)


@pytest.mark.parametrize("method", METHODS)
def test_draws_of_a_range_fill_it_evenly(method):
    u = unit_draws(4096, 1, method, seed=2)
    values = quantiles(Figure(5.0, low=4.0, high=6.0), u[:, 0], (0.0, INF))
    assert (values.min() >= 4.0, values.max() <= 6.0) == (True, True)
    counts, _ = np.histogram(values, bins=8, range=(4.0, 6.0))
    assert counts == pytest.approx(np.full(8, 512), rel=0.25)


def test_a_latin_hypercube_has_one_draw_in_each_row_of_each_figure():
    u = unit_draws(100, 3, "lhs", seed=3)
    assert (np.sort((u * 100).astype(int), axis=0).T == np.arange(100)).all()


def test_a_wide_sd_is_cut_where_nothing_has_a_meaning_and_to_its_range():
    u = np.linspace(0, 1, 1001)
    cut = quantiles(Figure(0.5, sd=0.5), u, (0.0, INF))
    assert cut.min() == 0.0
    assert (np.diff(cut) > 0).sum() > 990
    within = quantiles(Figure(0.36, sd=0.05, low=0.26, high=0.42), u, (0.0, INF))
    assert (within.min(), within.max()) == pytest.approx((0.26, 0.42))


def test_the_same_seed_draws_the_same_and_another_does_not():
    one, two, other = (unit_draws(8, 2, "sobol", seed) for seed in (1, 1, 2))
    assert (one == two).all()
    assert not (one == other).any()


def test_only_figures_that_are_unsure_and_act_on_the_run_are_drawn():
    rcc = load_vehicle("rcc")
    imposed = uncertain_figures(rcc, commanded=False)
    commanded = uncertain_figures(rcc, commanded=True, fixed=("body.mass_kg",))
    assert "controller.proportional_gain_as_per_rad" in set(commanded) - set(imposed)
    assert "motor.average_inductance_h" not in commanded  # acts on voltages alone
    assert "drivetrain.gear_ratio" not in commanded  # has no sd
    assert ("body.mass_kg" in imposed, "body.mass_kg" in commanded) == (True, False)


def test_a_vehicle_that_is_sure_of_everything_cannot_be_drawn():
    with pytest.raises(InputError, match="states no sd and no range"):
        file_draws(car(), 5, "lhs", 0, uncertain_figures(car(), commanded=True))


def test_an_efficiency_without_a_map_is_never_drawn_above_1():
    efficient = truck({"motor_efficiency": {"scale": {"value": 0.97, "sd": 0.05}}})
    figures = uncertain_figures(efficient, commanded=False)
    values = at_levels(efficient, figures, unit_draws(500, 1, "lhs", 0))
    assert (values > 0.96).any()
    assert values.max() <= 1.0


def test_a_file_of_draws_is_read_as_it_stands(tmp_path):
    path = tmp_path / "draws.csv"
    path.write_text("body.mass_kg, lanes.every\n3.8,20\n3.9,inf\n\n")
    keys, values = read_draws(path)
    assert keys == ("body.mass_kg", "lanes.every")
    assert values.tolist() == [[3.8, 20.0], [3.9, INF]]


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("body.mass_kg\n", "a row a draw"),
        ("body.mass_kg,body.mass_kg\n1,2\n", "names a key twice"),
        ("body.mass_kg\n1,2\n", "line 2: should have 1 figures: 2"),
        ("body.mass_kg\n3\nheavy\n", "line 3: body.mass_kg: should be a number"),
        ("body.mass_kg\ninf\n", "line 2: body.mass_kg: should be a number"),
    ],
)
def test_a_broken_file_of_draws_is_refused_with_its_line(tmp_path, text, words):
    path = tmp_path / "draws.csv"
    path.write_text(text)
    with pytest.raises(InputError, match=words):
        read_draws(path)
