"""What is read late is a sensor's delay, also where a command drives."""

import pytest

from rcc_sim.definitions.vehicle import load_vehicle
from rcc_sim.diagnose.run import diagnose
from rcc_sim.simulate.run import LaneChanges
from tests.scaled_drive import NOISE, drive, logged


@pytest.fixture(scope="module")
def driven():
    car = load_vehicle("rcc")
    return car, drive(car, LaneChanges(5.0, 0.2))


@pytest.mark.slow
@pytest.mark.parametrize("delay", [0.1, pytest.param(0.2, marks=pytest.mark.thorough)])
def test_a_late_speed_is_told_from_a_late_motor(driven, delay, tmp_path):
    """Its delay is that by which the readings were shifted."""
    car, run = driven
    log = logged(run, car, round(100 * delay), tmp_path, {"speed_mps": delay})
    (cause,) = diagnose([log], car).document()["causes"]
    assert cause["effect"] == "sensor_delay"
    ((name, figure),) = cause["parameters"].items()
    assert name == "speed_delay_s"
    assert figure["low"] < delay < figure["high"]


READ = [c for c in NOISE if c not in ("time_s", "speed_ref_mps", "steer_cmd_rad")]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "delay", "late"),
    [
        pytest.param("delay_s", 0.03, READ, marks=pytest.mark.thorough),
        ("motor_current_delay_s", 0.03, ["motor_current_a"]),
    ],
)
def test_what_all_sensors_or_the_motor_s_are_late_by_is_told(
    driven, name, delay, late, tmp_path
):
    car, run = driven
    log = logged(run, car, 4, tmp_path, dict.fromkeys(late, delay))
    (cause,) = diagnose([log], car).document()["causes"]
    assert (cause["effect"], list(cause["parameters"])) == ("sensor_delay", [name])
    assert cause["parameters"][name]["value"] == pytest.approx(delay, abs=0.003)


@pytest.mark.slow
def test_no_delay_is_told_where_nothing_is_late(driven, tmp_path):
    car, run = driven
    assert not diagnose([logged(run, car, 0, tmp_path)], car).document()["causes"]
