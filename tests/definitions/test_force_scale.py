"""The force map times a factor: a battery that no log holds."""

import re
from pathlib import Path

import numpy as np
import pytest

from rcc_sim.definitions.faults import vehicle_faults
from rcc_sim.definitions.kernel import force_table
from rcc_sim.definitions.vehicle import load_vehicle
from rcc_sim.diagnose.fitting.knobs import tolerance_knobs
from rcc_sim.diagnose.residuals.posed import problem_of
from rcc_sim.simulate.drive import drive_of
from rcc_sim.simulate.replay import replay
from rcc_sim.trace import Trace


def pushed(car, seconds=1.0):
    t = np.arange(0.0, seconds, 0.02)
    log = {"time_s": t, "throttle": np.full(len(t), 0.4)}
    return Trace(log | {"steer_cmd_rad": 0 * t, "speed_mps": np.nan * t}, name="push")


def test_force_goes_with_the_factor():
    """From standstill, without friction and lag, v is F t / m at first."""
    late = ("road_load", "motor_lag", "sensor_delay")
    car = load_vehicle("dart_jetracer").changed(without=late)
    weak = car.changed(settings={"controller.force_scale": 0.8})
    assert force_table(weak)[2] == pytest.approx(0.8 * force_table(car)[2])
    log = pushed(car)
    fast, slow = (replay(c, drive_of(log, c))["speed_mps"][5] for c in (car, weak))
    assert slow / fast == pytest.approx(0.8, abs=0.02)


def test_its_doubt_is_one_of_the_tolerances():
    car = load_vehicle("dart_jetracer")
    log = pushed(car, 10.0)
    speed = np.minimum(log["time_s"], 2.0)
    columns = {n: log[n] for n in ("time_s", "throttle", "steer_cmd_rad")}
    known = Trace({**columns, "speed_mps": speed}, name="push")
    knobs = {k.key: k for k in tolerance_knobs([problem_of(known, car)])}
    assert knobs["controller.force_scale"].sd == pytest.approx(0.05)


@pytest.mark.parametrize(
    ("force", "problem"),
    [
        ("", "force_n: missing"),
        ("force_n = [[0.0, 0.0]]", "force_n: should have 2 rows of 2"),
        ("force_n = [[0.0, 0.0], [25.0, 0.0]]", None),
    ],
)
def test_a_throttle_without_its_force_is_not_sound(tmp_path, force, problem):
    """Loading says nothing of it: a run would."""
    text = Path(load_vehicle("dart_jetracer").path).read_text()
    path = tmp_path / "car.toml"
    path.write_text(re.sub(r"(?m)^force_n = .*$", force, text))
    faults = [str(fault) for fault in vehicle_faults(path)]
    assert [problem in fault for fault in faults] == [True] * bool(problem)
