"""Where a camera saw the heading: how late the gyro is, and how late the wheels."""

import numpy as np
import pytest

from rcc_sim.analyse.logged import open_log
from rcc_sim.diagnose.run import diagnose
from rcc_sim.simulate.drive import drive_of
from rcc_sim.simulate.replay import replay
from rcc_sim.trace import Trace
from tests.cars import car

STATED = {"steering_lag": {"time_constant_s": {"value": 0.1, "sd": 0.05}}}
GYRO = 0.06  # s


def drive(
    path, true, columns=("yaw_rad", "yaw_rate_radps"), seconds=40, reads=(1.0, 0.0)
):
    """A drive by steps of the steering, held for 0.1 s each; a camera, a gyro.

    The gyro reads some times the true rate, and an offset [rad/s].
    """
    t = np.arange(0, seconds, 0.01)
    held = 0.1 * np.floor(t / 0.1 + 1e-6)
    asked = {
        "time_s": t,
        "speed_ref_mps": np.clip(t, 0.0, 2.5),
        "steer_cmd_rad": np.where(held > 4, 0.15 * np.sign(np.sin(1.7 * held)), 0.0),
    }
    blank = Trace(asked | {"speed_mps": np.full(len(t), np.nan)})
    out = replay(true, drive_of(blank, true))
    rng = np.random.default_rng(7)
    out["yaw_rate_radps"] = reads[0] * out["yaw_rate_radps"] + reads[1]
    noise = {"yaw_rad": 0.001, "yaw_rate_radps": 0.03}
    seen = {c: out[c] + noise[c] * rng.normal(size=len(t)) for c in columns}
    seen["speed_mps"] = out["speed_mps"] + 0.005 * rng.normal(size=len(t))
    rows = np.column_stack([*asked.values(), *seen.values()])
    names = ",".join([*asked, *seen])
    np.savetxt(path, rows, delimiter=",", header=names, comments="")


@pytest.mark.slow
def test_the_gyro_is_late_whatever_the_steering_may_do(tmp_path):
    """The gyro alone cannot tell its delay from a lag that may be 0.1 s or 0.2 s."""
    delay = {"yaw_rate_delay_s": GYRO}
    drive(tmp_path / "seen.csv", car(STATED | {"sensor_delay": delay}))
    found = diagnose([open_log(tmp_path / "seen.csv", car(STATED))], car(STATED))
    (one,) = found.asserted
    assert one.cause.effect == "sensor_delay"
    figure = one.figures["yaw_rate_delay_s"]
    assert figure.low < GYRO < figure.high
    assert figure.value == pytest.approx(GYRO, abs=0.005)


@pytest.mark.slow
def test_a_lag_of_the_steering_is_found_without_a_gyro(tmp_path):
    true = car({"steering_lag": {"time_constant_s": 0.08}})
    drive(tmp_path / "seen.csv", true, ["yaw_rad"])
    found = diagnose([open_log(tmp_path / "seen.csv", car())], car())
    (one,) = found.asserted
    assert one.cause.effect == "steering_lag"
    assert one.figures["time_constant_s"].value == pytest.approx(0.08, rel=0.1)


@pytest.mark.slow
@pytest.mark.parametrize("reads", [(1.03, 0.0), (0.97, 0.0), (1.03, 0.05)])
def test_a_gyro_that_turns_a_little_too_far_is_no_cause_and_an_offset_is(
    tmp_path, reads
):
    drive(tmp_path / "seen.csv", car(), reads=reads)
    found = diagnose([open_log(tmp_path / "seen.csv", car())], car())
    expected = ["yaw_rate_bias"] if reads[1] else []
    assert [one.cause.effect for one in found.asserted] == expected
    for one in found.asserted:
        assert one.figures["bias_radps"].value == pytest.approx(reads[1], rel=0.1)


@pytest.mark.slow
def test_what_the_file_says_of_a_gyros_gain_counts(tmp_path):
    """A gyro said to be exact to a thousandth is not 5 % off by its gain alone."""
    exact = car().changed(settings={"sensors.yaw_rate_radps.scale_sd": 0.001})
    drive(tmp_path / "seen.csv", car(), reads=(1.05, 0.0))
    found = diagnose([open_log(tmp_path / "seen.csv", exact)], exact)
    assert found.document()["status"] != "no_gap"
