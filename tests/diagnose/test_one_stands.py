"""Several logs of a car at once, in one of which it does not move."""

import numpy as np
import pytest

from rcc_sim.definitions.vehicle import load_vehicle
from rcc_sim.diagnose.run import diagnose
from rcc_sim.simulate.drive import drive_of
from rcc_sim.simulate.replay import replay
from rcc_sim.trace import Trace
from tests.diagnose.test_standstill import opened

CAR = load_vehicle("dart_jetracer")
FRICTION = {"a_n": 1.266, "b_n_s_per_m": 0.7393, "c_n_s2_per_m2": -0.1123}
SPEED_NOISE, ACCEL_NOISE = 0.02, 0.3


def step(throttle, seed, folder):
    """Open a log of a step of the throttle and the coasting after it."""
    t = np.arange(0.0, 8.0, 0.1)
    asked = throttle * ((t > 1) & (t < 5))
    commands = {"time_s": t, "throttle": asked, "steer_cmd_rad": np.zeros(len(t))}
    out = replay(CAR, drive_of(Trace(commands), CAR))
    rng = np.random.default_rng(seed)
    moves = np.ptp(out["speed_mps"]) > 0
    noises = {"speed_mps": SPEED_NOISE * moves, "accel_x_mps2": ACCEL_NOISE * moves}
    seen = {
        c: out[c] + max(size, 0.002) * rng.standard_normal(len(t))
        for c, size in noises.items()
    }
    return opened(Trace(commands | seen), folder / f"{throttle}.csv", CAR)


@pytest.mark.slow
def test_a_friction_is_found_in_logs_one_of_which_stands(tmp_path):
    logs = [step(x, i, tmp_path) for i, x in enumerate((0.1, 0.3, 0.35, 0.4))]
    assert np.ptp(logs[0].log["speed_mps"]) < 0.05  # below the dead zone
    bare, rivals = CAR.changed(without=("road_load",)), ("payload", "motor_lag")
    names = ("road_load", *rivals)
    found = diagnose(logs, bare, withheld=["road_load"], candidates=names)
    (first,) = found.asserted
    assert first.cause.effect == "road_load"
    a, b, c = (first.figures[k].value for k in FRICTION)
    for v in (0.5, 1.0, 2.0):
        true = FRICTION["a_n"] + FRICTION["b_n_s_per_m"] * v
        true += FRICTION["c_n_s2_per_m2"] * v**2
        assert a + b * v + c * v**2 == pytest.approx(true, rel=0.1)
