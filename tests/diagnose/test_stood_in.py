"""A cause that two tolerances stand in for is found from what the file states."""

import numpy as np
import pytest

from rcc_sim.analyse.logged import Logged
from rcc_sim.definitions.cycle import Cycle, parse_cycle
from rcc_sim.definitions.vehicle import load_vehicle
from rcc_sim.diagnose.run import diagnose
from rcc_sim.simulate.run import LaneChanges, simulate
from rcc_sim.trace import Trace
from tests.scaled_drive import drive, logged

TRUE = 1.5
"""A load of two fifths of its mass. [kg]"""


ASKED = ("time_s", "speed_ref_mps", "steer_cmd_rad")
NOISE = {"motor_current_a": 0.3, "accel_x_mps2": 0.1, "battery_current_a": 0.05}


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
def test_a_damping_that_was_pulled_hides_no_drag_of_another_course():
    """A log without a speed: beside the damping, a rolling resistance promises nothing.

    A slope and an accelerometer's bias were named together.
    """
    car, town = load_vehicle("rcc"), parse_cycle("udds[20:125]")
    cycle = Cycle("c", 0.2256 * town.time_s, 0.416 * town.speed_mps)
    true = car.changed(effects={"rolling_resistance": {"coefficient": 0.015}})
    run = simulate(true, cycle, output_rate=100.0).trace
    rng = np.random.default_rng(4)
    seen = {c: run[c] + rng.normal(0, sd, len(run)) for c, sd in NOISE.items()}
    log = Trace({c: run[c] for c in ASKED} | seen, name="drive")
    (cause,) = diagnose([Logged(log, (), None)], car).asserted
    assert "rolling_resistance" in {cause.cause.effect, *cause.cause.tied}
    rolls = {cause.cause.effect: cause.figures, **cause.instead}["rolling_resistance"]
    assert rolls["coefficient"].low < 0.015 < rolls["coefficient"].high
