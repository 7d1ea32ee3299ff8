"""A speed that is of no use gives way to that which the motor's speed makes."""

import numpy as np
import pytest

from rcc_sim.analyse.logged import open_log
from rcc_sim.definitions.vehicle import load_vehicle
from rcc_sim.trace import Trace, read_trace
from tests import scaled_drive

CAR = load_vehicle("rcc")
KMH = 3.6
NOISE = scaled_drive.NOISE | {"motor_speed_radps": 2.5}


@pytest.fixture(scope="module")
def run():
    return scaled_drive.drive(CAR, None)


def opened(run, folder, noise=NOISE, **wrong):
    """Open the log of a run, some columns of which read so many times too much."""
    columns = {c: x * wrong.get(c, 1.0) for c, x in run.columns.items()}
    return scaled_drive.logged(Trace(columns, name="run"), CAR, 2, folder, noise=noise)


def kinds(found):
    return {finding.kind for finding in found.findings}


def test_a_speed_in_another_unit_gives_way_to_the_motors(run, tmp_path):
    found = opened(run, tmp_path, speed_mps=KMH)
    assert {"unit", "rolled"} <= kinds(found)
    lever = CAR.drivetrain.gear_ratio.value / CAR.tyres.radius_m.value
    sd = NOISE["motor_speed_radps"] / lever
    left = found.log["speed_mps"] - run["speed_mps"]
    assert np.std(left) == pytest.approx(sd, rel=0.1)


def test_with_its_commands_wrong_as_well_it_does_not(run, tmp_path):
    found = opened(run, tmp_path, speed_mps=KMH, speed_ref_mps=KMH)
    assert not {"speed_mps", "speed_ref_mps"} & set(found.log.columns)


def test_a_sound_speed_and_one_that_is_hidden_stay_as_they_are(run, tmp_path):
    sound = opened(run, tmp_path)
    given = read_trace(tmp_path / "log.csv")["speed_mps"]
    np.testing.assert_allclose(sound.log["speed_mps"], given, atol=1e-6)
    hidden = open_log(tmp_path / "log.csv", CAR, hide=["speed_mps"])
    assert "speed_mps" not in hidden.log
    assert "rolled" not in kinds(sound) | kinds(hidden)


def test_without_the_motors_there_is_no_speed(run, tmp_path):
    found = opened(run, tmp_path, noise=scaled_drive.NOISE, speed_mps=KMH)
    assert "speed_mps" not in found.log
