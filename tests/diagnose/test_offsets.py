"""A sensor's offset is a tolerance, unless it was withheld to be found."""

import numpy as np
import pytest

from rcc_sim.analyse.logged import open_log
from rcc_sim.definitions.vehicle import load_vehicle
from rcc_sim.diagnose.knobs import bias_key, bias_knobs
from rcc_sim.diagnose.problem import Problem
from rcc_sim.diagnose.run import diagnose
from rcc_sim.simulate.drive import drive_of
from rcc_sim.simulate.replay import replay
from rcc_sim.trace import Trace

OFFSET = -0.4  # m/s²; less than the noise, so that it would pass as one


@pytest.fixture(scope="module")
def drive():
    rng = np.random.default_rng(8)
    t = np.arange(0, 40, 0.02)
    throttle = np.where(t % 5 < 2.0, 0.26, 0.0)
    blank = np.zeros(len(t))
    car = load_vehicle("dart_jetracer").changed(without=("accelerometer_bias",))
    columns = {"time_s": t, "throttle": throttle, "steer_cmd_rad": blank}
    out = replay(car, drive_of(Trace(columns | {"speed_mps": blank}), car))
    columns["speed_mps"] = np.round(
        out["speed_mps"] + 0.01 * rng.normal(size=len(t)), 3
    )
    columns["accel_x_mps2"] = out["accel_x_mps2"] + OFFSET + rng.normal(size=len(t))
    return car, Trace(columns, name="drive")


def test_the_offset_of_a_sensor_may_move_unless_it_is_to_be_found(drive):
    car, log = drive
    free = Problem(car, log, drive_of(log, car))
    kept = Problem(car, log, drive_of(log, car), unzeroed=("accel_x_mps2",))
    key = bias_key(0, "accel_x_mps2")
    assert key in {k.key for k in bias_knobs(free)}
    assert key not in {k.key for k in bias_knobs(kept)}


@pytest.mark.slow
def test_a_withheld_offset_is_named_and_passes_as_a_tolerance_otherwise(
    drive, tmp_path
):
    car, log = drive
    path = tmp_path / "drive.csv"
    rows = np.column_stack(list(log.columns.values()))
    np.savetxt(path, rows, delimiter=",", header=",".join(log.columns), comments="")
    opened = open_log(path, car)
    assert diagnose([opened], car).asserted == ()
    found = diagnose([opened], car, withheld=["accelerometer_bias"])
    (one,) = found.asserted
    assert one.cause.effect == "accelerometer_bias"
    assert one.figures["x_mps2"].value == pytest.approx(OFFSET, abs=0.08)
