"""Short drives at a crawl, whose place a lidar told a few times a second."""

import numpy as np
import pytest

from rcc_sim.analyse.gap import gap
from rcc_sim.analyse.gap_regimes import SLOW
from rcc_sim.analyse.logged import Logged
from rcc_sim.diagnose.fitting.engine import Engine
from rcc_sim.diagnose.residuals.posed import problem_of
from rcc_sim.diagnose.run import diagnose
from rcc_sim.errors import InputError
from rcc_sim.physics.step import SLIP_BLEND
from rcc_sim.simulate.drive import drive_of
from rcc_sim.simulate.replay import replay
from rcc_sim.trace import Trace
from tests.cars import car

RATE = 7.4  # Hz, of a lidar's odometry
TRIM = -0.07  # rad


def crawl(true, speed=0.4, seconds=13.0, seed=3):
    """A drive straight on by the command; from 5 s to 11.5 s the car moves."""
    t = np.arange(0, seconds, 1 / RATE)
    v = np.interp(t, [5, 5.5, 11, 11.5], [0, speed, speed, 0])
    asked = {"time_s": t, "speed_mps": v, "steer_cmd_rad": np.zeros(len(t))}
    out = replay(true, drive_of(Trace(asked), true))
    rng = np.random.default_rng(seed)
    # a lidar finds its place anew at each row: what its turn rate errs by changes sign
    errs = np.where(v > 0, 0.02, 0.0005) * rng.normal(size=len(t))
    heading = out["yaw_rad"] + errs
    return Logged(Trace({**asked, "yaw_rad": heading}, name="crawl"), (), None)


def test_a_trim_shows_in_a_short_slow_drive():
    trim = {"steering_offset": {"angle_rad": TRIM}}
    found = diagnose([crawl(car(trim))], car())
    (one,) = found.asserted
    assert one.cause.effect == "steering_offset"
    figure = one.figures["angle_rad"]
    assert figure.low < TRIM < figure.high
    assert figure.value == pytest.approx(TRIM, rel=0.15)


@pytest.mark.parametrize("seed", range(4))
def test_such_a_drive_without_a_trim_names_none(seed):
    found = diagnose([crawl(car(), seed=seed)], car())
    assert found.document()["status"] == "no_gap"


def test_a_level_is_no_noise_of_a_heading():
    """A heading that is measured does not wander off at a rate that stays."""
    crawled = crawl(car({"steering_offset": {"angle_rad": TRIM}}))
    engine = Engine([problem_of(crawled.log, car())])
    (noise,) = engine.learn_noise(engine.residuals({}))
    assert noise.memory.sum() < 0.5


def test_the_gap_of_a_log_without_a_gyro_is_that_of_its_heading():
    """v tan(delta) / l, at a crawl, is what a trim makes of the yaw rate."""
    found = gap(crawl(car({"steering_offset": {"angle_rad": TRIM}})), car())
    (one,) = found.channels
    assert one.channel == "yaw_rate_radps"
    expected = 0.4 * np.tan(TRIM) / car().wheelbase
    assert one.bias == pytest.approx(expected, rel=0.15)
    assert any("no gyro" in note for note in found.notes)


def test_a_heading_without_a_steering_to_judge_is_no_gap_of_a_car_that_goes_straight():
    """The model drives straight on where no one says how it was steered."""
    columns = dict(crawl(car(), speed=2.0).log.columns)
    del columns["steer_cmd_rad"]
    t = columns["time_s"]
    columns["yaw_rad"] = 0.2 * t**2 / 10
    columns["accel_y_mps2"] = 0.3 * np.sin(t)
    columns["accel_x_mps2"] = np.gradient(columns["speed_mps"], t)
    found = gap(Logged(Trace(columns, name="log"), (), None), car())
    assert [c.channel for c in found.channels] == ["accel_x_mps2"]


def test_cornering_is_judged_where_the_fade_of_slip_matters_little():
    problem = problem_of(crawl(car()).log, car())
    assert problem.slow < 0.4
    assert 1 - 1 / np.hypot(1, SLIP_BLEND / (SLOW * SLIP_BLEND)) < 0.02


def test_a_drive_that_is_too_slow_to_be_judged_is_refused():
    crawled = crawl(car(), speed=0.1)
    with pytest.raises(InputError, match="no channel by which") as refused:
        diagnose([crawled], car())
    slow = problem_of(crawled.log, car()).slow
    assert f"{slow:.2g} m/s or more" in refused.value.hint


def test_a_car_that_turns_otherwise_than_asked_is_not_without_a_gap():
    """Its queue of commands ends early: it turns on while the log asks for none."""
    true = crawl(car())
    t = true.log["time_s"]
    late = np.where(t < 8.2, 0.3, 0.0)
    turned = -np.where(true.log["speed_mps"] > 0, 0.15, 0.0)
    rng = np.random.default_rng(2)
    rate = turned + 0.04 * rng.normal(size=len(t))
    columns = {"time_s": t, "speed_mps": true.log["speed_mps"]}
    log = Trace({**columns, "steer_cmd_rad": late, "yaw_rate_radps": rate}, name="log")
    found = diagnose([Logged(log, (), None)], car())
    assert found.document()["status"] in ("unexplained", "partly_explained")


def test_logs_that_are_too_short_alone_do_together():
    trim = {"steering_offset": {"angle_rad": TRIM}}
    parts = []
    for seed in range(3):
        log = crawl(car(trim), seed=seed).log
        rows = (log["time_s"] > 6.0) & (log["time_s"] < 10.3)
        part = {c: x[rows] for c, x in log.columns.items()}
        parts.append(Logged(Trace(part, name=f"part {seed}"), (), None))
    with pytest.raises(InputError, match="too short"):
        diagnose(parts[:1], car())
    (one,) = diagnose(parts, car()).asserted
    assert one.cause.effect == "steering_offset"
    assert one.figures["angle_rad"].value == pytest.approx(TRIM, rel=0.15)
