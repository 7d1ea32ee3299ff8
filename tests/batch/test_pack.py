"""Records written all at once against the vehicle built anew for each run."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from rcc_sim.batch.pack import FORMULAS, Packing
from rcc_sim.definitions.kernel import kernel_params
from rcc_sim.definitions.vehicle import load_vehicle
from rcc_sim.errors import InputError
from rcc_sim.physics import record
from rcc_sim.simulate.own import own_terms
from rcc_sim.simulate.run import LaneChanges
from tests.cars import car, truck

VEHICLES = sorted(Path(__file__).parents[2].glob("vehicles/*.toml"))


def packed(vehicle, keys, values, *, commanded, lanes=None):
    """Return a packing of some rows."""
    values = np.asarray(values, dtype=float)
    low, high = values.min(axis=0), values.max(axis=0)
    return Packing(vehicle, commanded, tuple(keys), low, high, lanes), values


def one_by_one(vehicle, keys, values, *, commanded, lanes=None):
    """Return the records as `simulate` would fill them."""
    P = record.array(own_terms(vehicle).params, len(values))
    for i, row in enumerate(values):
        at = dict(zip(keys, row.tolist(), strict=True))
        changed = vehicle.changed(settings=at)
        filled = kernel_params(changed, commanded=commanded)
        if lanes is not None:
            filled["lanes"] = lanes.params(changed)
        record.fill(P[i:], filled)
    return P


def near(vehicle, rng, rows=6):
    """Return every key that states a figure, and values about what it states."""
    figures = {
        key: figure
        for key, figure in vehicle.figures().items()
        if figure.value != 0 and not key.startswith("controller.force")
    }
    stated = np.array([figure.value for figure in figures.values()])
    # smaller only: efficiencies of 1 have no more to give
    return list(figures), stated * (1 - 0.02 * rng.random((rows, len(figures))))


@pytest.mark.parametrize("commanded", [False, True], ids=["imposed", "commanded"])
@pytest.mark.parametrize("path", VEHICLES, ids=lambda path: path.stem)
def test_all_figures_of_a_vehicle_at_once_give_the_records_of_one_by_one(
    path, commanded
):
    vehicle = load_vehicle(path)
    if commanded and vehicle.controller is None:
        pytest.skip("no controller")
    keys, values = near(vehicle, np.random.default_rng(1))
    packing, values = packed(vehicle, keys, values, commanded=commanded)
    assert packing.straight
    P, errors = packing.records(values)
    assert errors == [None] * len(values)
    assert (
        P.tobytes() == one_by_one(vehicle, keys, values, commanded=commanded).tobytes()
    )


@pytest.mark.parametrize("place", FORMULAS, ids=".".join)
def test_a_formula_gives_what_the_vehicle_gives_for_each_of_its_keys(place):
    electrical = {"controller__max_electrical_speed_radps": 6000.0}
    small = car(motor__max_speed_radps=3500.0, **electrical)
    slow = truck(controller__driver_time_constant_s=0.7)
    for vehicle in (small, truck(), slow):
        figures = vehicle.figures()
        keys = [key for key in FORMULAS[place].keys if key in figures]
        stated = np.array([figures[key].value for key in keys])
        rng = np.random.default_rng(2)
        values = stated * rng.uniform(0.7, 1.4, (9, len(keys)))
        if not keys:
            continue
        packing, values = packed(vehicle, keys, values, commanded=True)
        P, _ = packing.records(values)
        expected = one_by_one(vehicle, keys, values, commanded=True)
        assert P.tobytes() == expected.tobytes()


def test_the_speed_limit_is_the_lower_one_wherever_the_sweep_goes():
    keys = ("motor.max_speed_radps", "controller.max_electrical_speed_radps")
    vehicle = car(
        motor__max_speed_radps=100.0, controller__max_electrical_speed_radps=300.0
    )
    values = [[a, b] for a in (100.0, 200.0) for b in (300.0, 800.0)]
    packing, values = packed(vehicle, keys, values, commanded=True)
    P, _ = packing.records(values)
    assert P["motor"]["omega_max"].tolist() == [100.0, 100.0, 150.0, 200.0]


def test_a_whole_number_of_the_file_is_swept_one_by_one():
    packing, values = packed(car(), ["motor.poles"], [[4], [8]], commanded=True)
    P, errors = packing.records(values)
    assert not packing.straight
    assert errors == [None, None]
    assert P["motor"]["K_t"][1] == 2 * P["motor"]["K_t"][0]


def test_a_run_that_no_vehicle_can_be_is_an_error_and_the_others_stand():
    keys = ["body.mass_kg", "body.yaw_inertia_kgm2"]
    values = [[3.0, 0.04], [3.0, 4.0], [-1.0, 0.04], [4.0, 0.05]]
    packing, values = packed(car(), keys, values, commanded=False)
    P, errors = packing.records(values)
    assert [error is None for error in errors] == [True, False, False, True]
    assert "body.yaw_inertia_kgm2" in errors[1]
    assert "body.mass_kg" in errors[2]
    good = [0, 3]
    expected = one_by_one(car(), keys, values[good], commanded=False)
    assert P[good].tobytes() == expected.tobytes()


@pytest.mark.parametrize("lanes", [LaneChanges(20.0), LaneChanges(4.0, 0.5)])
def test_lanes_follow_the_wheelbase_of_each_run(lanes):
    keys = ["body.cg_to_front_axle_m"]
    values = [[0.15], [0.16], [0.17]]
    packing, values = packed(car(), keys, values, commanded=False, lanes=lanes)
    P, errors = packing.records(values)
    assert errors == [None] * 3
    expected = one_by_one(car(), keys, values, commanded=False, lanes=lanes)
    assert P.tobytes() == expected.tobytes()


def test_lanes_that_cannot_be_are_errors_in_the_words_of_a_single_run():
    keys = ["lanes.every", "lanes.length"]
    values = [[20.0, 5.0], [20.0, 30.0], [-5.0, 1.0], [np.inf, 5.0]]
    packing, values = packed(car(), keys, values, commanded=False)
    P, errors = packing.records(values)
    for row in (1, 2):
        with pytest.raises(InputError) as raised:
            LaneChanges(values[row][0], None, values[row][1]).params(car())
        assert errors[row] == str(raised.value)
    assert (errors[0], errors[3]) == (None, None)
    assert P["lanes"]["steer"][3] == 0
