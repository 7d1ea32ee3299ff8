"""A cause that two tolerances stand in for is found from what the file states."""

import numpy as np
import pytest

from rcc_sim.analyse.logged import open_log
from rcc_sim.definitions.cycle import parse_cycle
from rcc_sim.definitions.vehicle import load_vehicle
from rcc_sim.diagnose.run import diagnose
from rcc_sim.similitude.cycles import scale_cycle
from rcc_sim.simulate.run import LaneChanges, simulate

PAYLOAD = "effects.payload.mass_kg"
TRUE = 1.5
NOISE = {
    "time_s": 0.0,
    "speed_ref_mps": 0.0,
    "steer_cmd_rad": 0.0,
    "speed_mps": 0.02,
    "yaw_rate_radps": 0.01,
    "accel_x_mps2": 0.1,
    "accel_y_mps2": 0.1,
    "motor_current_a": 0.3,
    "battery_voltage_v": 0.02,
    "battery_current_a": 0.05,
}


@pytest.fixture(scope="module")
def loaded():
    """A scaled car's drive with a load of two fifths of its mass."""
    car = load_vehicle("f1tenth")
    cycle = scale_cycle(parse_cycle("udds[20:125]"), of=load_vehicle("r1t"), to=car)
    true = car.changed(settings={PAYLOAD: {"value": TRUE}})
    return car, simulate(true, cycle.cycle, lanes=LaneChanges(10.0)).trace


@pytest.mark.slow
@pytest.mark.parametrize("seed", list(range(1, 13)))
def test_mass_and_inertia_that_were_pulled_hide_no_payload(loaded, seed, tmp_path):
    car, run = loaded
    rng = np.random.default_rng(seed)
    log = [run[c] + sd * rng.standard_normal(len(run)) for c, sd in NOISE.items()]
    path = tmp_path / "log.csv"
    head = {"delimiter": ",", "header": ",".join(NOISE), "comments": ""}
    np.savetxt(path, np.column_stack(log), **head)
    cause, *more = diagnose([open_log(path, car)], car).document()["causes"]
    assert not more
    assert cause["effect"] == "payload"
    figure = cause["parameters"]["mass_kg"]
    assert figure["low"] < TRUE < figure["high"]
