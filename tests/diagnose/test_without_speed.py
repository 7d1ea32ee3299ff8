"""A log that holds no speed is judged at the speed that its commands ask for."""

import numpy as np
import pytest

from rcc_sim.analyse.logged import open_log
from rcc_sim.diagnose.problem import Problem
from rcc_sim.diagnose.run import diagnose
from rcc_sim.simulate.replay import drive_of, replay
from rcc_sim.trace import Trace
from tests.cars import car

LAG = 0.06  # s
NOISE = {"yaw_rate_radps": 0.02, "accel_y_mps2": 0.2, "motor_current_a": 0.3}


@pytest.fixture(scope="module")
def columns():
    t = np.arange(0, 40, 0.02)
    ref = np.clip(t, 0.0, 2.5)
    steer = np.where(t > 4, 0.15 * np.sign(np.sin(1.7 * t)), 0.0)
    asked = {"time_s": t, "speed_ref_mps": ref, "steer_cmd_rad": steer}
    blank = Trace(asked | {"speed_mps": np.full(len(t), np.nan)})
    true = car({"steering_lag": {"time_constant_s": LAG}})
    out = replay(true, drive_of(blank, true))
    rng = np.random.default_rng(4)
    seen = {c: out[c] + sd * rng.normal(size=len(t)) for c, sd in NOISE.items()}
    return asked | seen, out["speed_mps"]


def test_cornering_is_judged_where_the_model_rolls(columns):
    log, true = Trace(columns[0]), columns[1]
    problem = Problem(car(), log, drive_of(log, car()))
    np.testing.assert_allclose(problem.speed, true, atol=0.05)
    assert problem.distance[-1] == pytest.approx(
        np.trapezoid(true, log["time_s"]), rel=0.01
    )
    judged = dict(zip(problem.channels, problem.judged, strict=True))
    assert judged["yaw_rate_radps"][true > 2.0].all()


@pytest.mark.slow
def test_an_effect_of_cornering_is_named_without_a_speed(columns, tmp_path):
    path, log = tmp_path / "drive.csv", columns[0]
    rows = np.column_stack(list(log.values()))
    np.savetxt(path, rows, delimiter=",", header=",".join(log), comments="")
    found = diagnose([open_log(path, car())], car())
    (one,) = found.asserted
    assert one.cause.effect == "steering_lag"
    assert one.figures["time_constant_s"].value == pytest.approx(LAG, abs=0.01)
