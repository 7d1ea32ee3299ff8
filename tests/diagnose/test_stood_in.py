"""A cause that two tolerances stand in for is found from what the file states."""

import pytest

from rcc_sim.definitions.vehicle import load_vehicle
from rcc_sim.diagnose.run import diagnose
from rcc_sim.simulate.run import LaneChanges
from tests.scaled_drive import drive, logged

TRUE = 1.5


@pytest.fixture(scope="module")
def loaded():
    """A scaled car's drive with a load of two fifths of its mass."""
    car = load_vehicle("f1tenth")
    true = car.changed(settings={"effects.payload.mass_kg": {"value": TRUE}})
    return car, drive(true, LaneChanges(10.0))


@pytest.mark.slow
@pytest.mark.parametrize("seed", [3, 12])
def test_mass_and_inertia_that_were_pulled_hide_no_payload(loaded, seed, tmp_path):
    """Two drives of twelve in which the rotor was named, from the pulled figures on."""
    car, run = loaded
    log = logged(run, car, seed, tmp_path)
    (cause,) = diagnose([log], car).document()["causes"]
    assert cause["effect"] == "payload"
    figure = cause["parameters"]["mass_kg"]
    assert figure["low"] < TRUE < figure["high"]
