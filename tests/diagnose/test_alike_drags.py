"""Drags that no drive on the level tells apart are named together, by any noise."""

import numpy as np
import pytest

from rcc_sim.definitions.vehicle import load_vehicle
from rcc_sim.diagnose.causes.candidates import Candidate
from rcc_sim.diagnose.run import diagnose
from rcc_sim.diagnose.search.screen import Screened, Slope, shared
from rcc_sim.simulate.run import LaneChanges
from tests.scaled_drive import NOISE, drive, logged

FINE = NOISE | {
    "speed_mps": 0.01,
    "motor_current_a": 0.05,
    "battery_voltage_v": 0.01,
    "battery_current_a": 0.02,
}
CONSTANT = {"drivetrain_friction", "rolling_resistance", "iron_loss"}
"""Drags that no speed changes; the hysteresis of a motor's iron is one."""


@pytest.fixture(scope="module")
def rolling():
    """A scaled car that rolls harder than its file says."""
    car = load_vehicle("rcc")
    tyres = {"effects.rolling_resistance.coefficient": {"value": 0.02}}
    return car, drive(car.changed(settings=tyres), LaneChanges(10.0))


@pytest.mark.slow
@pytest.mark.parametrize("seed", [pytest.param(2, marks=pytest.mark.thorough), 9])
def test_a_threshold_at_a_launch_parts_no_tie(rolling, seed, tmp_path):
    """Two of ten in which a dead zone that was taken along hid one, or both."""
    car, run = rolling
    log = logged(run, car, seed, tmp_path, noise=FINE)
    rivals = (*CONSTANT, "speed_dead_zone", "drivetrain_damping", "payload")
    (cause,) = diagnose([log], car, candidates=rivals).document()["causes"]
    assert {cause["effect"], *cause["indistinguishable_from"]} == CONSTANT


def test_what_an_effect_shares_with_another_is_the_square_of_a_cosine():
    def one(effect, **slopes):
        found = {k: Slope(np.array(d), 0.0, 1.0) for k, d in slopes.items()}
        return Screened(Candidate(effect, ()), 0.0, slopes=found)

    found = [
        one("mine", a=[2.0, 0.0]),
        one("other", b=[0.0, 1.0], c=[-3.0, 4.0]),
        one("threshold"),
    ]
    assert shared(found, "mine") == pytest.approx({"mine": 1.0, "other": 0.36})
    assert shared(found, "threshold") == {}
