"""A cause that two tolerances stand in for is found from what the file states."""

import pytest

from rcc_sim.definitions.vehicle import load_vehicle
from rcc_sim.diagnose.run import diagnose
from rcc_sim.simulate.run import LaneChanges
from tests.scaled_drive import NOISE, drive, logged

TRUE = 1.5
"""A load of two fifths of its mass. [kg]"""


WITHOUT_SPEED = {c: sd for c, sd in NOISE.items() if c != "speed_mps"}


@pytest.mark.slow
def test_mass_and_inertia_that_were_pulled_hide_no_payload(tmp_path):
    """One of twelve drives in which the rotor was named, from the pulled figures on."""
    car = load_vehicle("f1tenth")
    true = car.changed(settings={"effects.payload.mass_kg": {"value": TRUE}})
    log = logged(drive(true, LaneChanges(10.0)), car, 3, tmp_path)
    rivals = ("payload", "rotor_inertia", "motor_lag", "speed_loop")
    (cause,) = diagnose([log], car, candidates=rivals).document()["causes"]
    assert cause["effect"] == "payload"
    figure = cause["parameters"]["mass_kg"]
    assert figure["low"] < TRUE < figure["high"]


@pytest.mark.slow
def test_a_damping_that_was_pulled_hides_no_drag_of_another_course(tmp_path):
    """A log without a speed: beside the damping, a rolling resistance promises nothing.

    A slope and an accelerometer's bias were named together.
    """
    car = load_vehicle("rcc")
    true = car.changed(effects={"rolling_resistance": {"coefficient": 0.015}})
    log = logged(drive(true, None), car, 4, tmp_path, noise=WITHOUT_SPEED)
    (cause,) = diagnose([log], car).asserted
    assert "rolling_resistance" in {cause.cause.effect, *cause.cause.tied}
    rolls = {cause.cause.effect: cause.figures, **cause.instead}["rolling_resistance"]
    assert rolls["coefficient"].low < 0.015 < rolls["coefficient"].high
