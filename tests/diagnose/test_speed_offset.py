"""A speed that reads a little too much throughout is a tolerance where it is stated."""

import numpy as np
import pytest

from rcc_sim.definitions.vehicle import load_vehicle
from rcc_sim.diagnose.fitting.knobs import nuisance_knobs
from rcc_sim.diagnose.residuals.posed import problem_of
from rcc_sim.diagnose.run import diagnose
from rcc_sim.simulate.run import LaneChanges
from rcc_sim.trace import Trace
from tests import scaled_drive

OFF = 0.01  # m/s, twice the sensor's noise
CAR = load_vehicle("rcc")
STATED = CAR.changed(settings={"sensors.speed_mps.bias_sd": 0.005})


@pytest.fixture(scope="module")
def run():
    return scaled_drive.drive(CAR, LaneChanges(10.0))


@pytest.mark.parametrize("imposed", [False, True])
def test_the_drive_is_that_of_the_speed_as_it_was(run, imposed):
    names = ("time_s", "speed_mps", "steer_cmd_rad", "battery_power_w")
    names += () if imposed else ("speed_ref_mps",)
    right = Trace({c: run[c] for c in names})
    moves = run["speed_mps"] != 0.0  # a counter reads nil while it stands
    read = right["speed_mps"] + OFF * moves
    wrong = problem_of(Trace({**right.columns, "speed_mps": read}), STATED)
    (told,) = [k for k in nuisance_knobs([wrong]) if k.key == "own.0.speed_offset"]
    assert told.sd == 0.005 and told.value == 0.0
    there = wrong.predict({"speed_offset": OFF})
    true = problem_of(right, STATED).predict({})
    power, speed = "battery_power_w", "speed_mps"
    assert there[power] == pytest.approx(true[power], rel=1e-6, abs=1e-6)
    assert there[speed] == pytest.approx(true[speed] + OFF, rel=1e-6, abs=1e-6)
    unmoved = wrong.predict({})
    assert not np.allclose(unmoved[power], true[power], rtol=1e-4)


def test_it_is_no_gap_where_it_is_stated(run, tmp_path):
    read = {"speed_mps": run["speed_mps"] + OFF}
    noise = {**scaled_drive.NOISE, "speed_mps": 0.5 * OFF}
    log = scaled_drive.logged({**run.columns, **read}, STATED, 3, tmp_path, noise=noise)
    found = diagnose([log], STATED)
    assert found.status == "no_gap" and not found.asserted
    assert found.fit.values["own.0.speed_offset"] == pytest.approx(OFF, rel=0.05)
