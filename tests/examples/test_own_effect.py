"""The example of an own effect does what its docstring says."""

import pytest

from rcc_sim.definitions.cycle import parse_cycle
from rcc_sim.definitions.own_effects import own_effect
from rcc_sim.definitions.vehicle import load_vehicle
from rcc_sim.simulate.run import simulate
from tests.simulate.test_own_effects import TRAILER


def test_the_trailer_costs_its_rolling_resistance_over_a_drive_from_rest_to_rest():
    own = own_effect(str(TRAILER))
    assert own.kind == "force"
    with_it = {"trailer": {"mass_kg": 0.5, "coefficient": 0.03}}
    made = load_vehicle("rcc").changed(files=(str(TRAILER),), effects=with_it)
    run = simulate(made, parse_cycle("udds[0:125]"), imposed=True, engine="interpreted")
    rolling = 0.03 * 0.5 * 9.80665 * run.trace["distance_m"][-1]
    assert run.ledger["trailer"] == pytest.approx(rolling, rel=0.01)
