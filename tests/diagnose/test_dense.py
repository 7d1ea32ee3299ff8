"""A log of a thousand rows a second is judged by two hundred of them."""

import numpy as np
import pytest

from rcc_sim.analyse.logged import Logged
from rcc_sim.definitions.cycle import parse_cycle
from rcc_sim.definitions.vehicle import load_vehicle
from rcc_sim.diagnose.residuals.dense import rows_to_one, thinned, with_fewer_rows
from rcc_sim.diagnose.run import diagnose
from rcc_sim.similitude.cycles import scale_cycle
from rcc_sim.simulate.run import LaneChanges, simulate
from rcc_sim.trace import Trace


def log_of(rate, seconds=10.0, **columns):
    time = 3.0 + np.arange(round(seconds * rate)) / rate
    return Trace({"time_s": time, **{c: f(time) for c, f in columns.items()}}, name="x")


@pytest.mark.parametrize(
    ("rate", "many"),
    [(1.0, 1), (100.0, 1), (250.0, 1), (300.0, 3), (500.0, 3), (600.0, 3), (1000.0, 5),
     (2000.0, 11), (10_000.0, 51)],
)  # fmt: skip
def test_rows_are_made_one_beyond_250_a_second(rate, many):
    log = log_of(rate, speed_mps=np.sin)
    assert rows_to_one(log) == many
    fewer = thinned(Logged(log, (), None))
    assert len(fewer.log) == len(log) // many
    assert len(fewer.findings) == (many > 1)


def test_sensors_are_means_and_commands_are_as_in_the_middle():
    def leap(t):
        return np.where(t < 7.0, 0.1, 0.9)

    log = log_of(1000.0, speed_mps=lambda t: 2 * t, throttle=leap, yaw_rad=np.cos)
    gone = log["speed_mps"].copy()
    gone[1001:1004] = np.nan  # of five rows the first and the last are left
    gone[2000:2005] = np.nan
    log = Trace({**log.columns, "speed_mps": gone}, name="x")
    fewer = with_fewer_rows(log, 5)
    time = fewer["time_s"]
    assert np.allclose(time, log["time_s"][2::5])
    known = np.delete(np.arange(2000), 400)
    assert np.allclose(fewer["speed_mps"][known], 2 * time[known])
    assert np.isnan(fewer["speed_mps"][400])
    assert set(fewer["throttle"]) == {0.1, 0.9}
    assert np.array_equal(fewer["yaw_rad"], np.cos(time))


def test_rows_across_a_hole_are_no_mean():
    log = log_of(1000.0, speed_mps=np.sin)
    kept = np.r_[0:1002, 5003:10_000]
    log = Trace({c: x[kept] for c, x in log.columns.items()}, name="x")
    fewer = with_fewer_rows(log, 5)
    assert np.abs(fewer["speed_mps"] - np.sin(fewer["time_s"])).max() < 1e-5


def test_a_delay_is_found_at_a_thousand_rows_a_second():
    car = load_vehicle("rcc")
    cycle = scale_cycle(parse_cycle("udds[20:90]"), to=car, of=load_vehicle("r1t"))
    late = car.changed(settings={"effects.steering_delay.delay_s": 0.06})
    run = simulate(late, cycle.cycle, lanes=LaneChanges(2.0), output_rate=1000.0).trace
    rng = np.random.default_rng(1)
    noise = {"speed_mps": 0.01, "yaw_rate_radps": 0.02, "motor_current_a": 0.3}
    seen = {c: run[c] + rng.normal(0, sd, len(run)) for c, sd in noise.items()}
    same = ("time_s", "speed_ref_mps", "steer_cmd_rad")
    log = Trace({**{c: run[c] for c in same}, **seen}, name="fast")
    rivals = ("steering_delay", "steering_lag", "steering_gain", "sensor_delay")
    found = diagnose([Logged(log, (), None)], car, candidates=rivals)
    (one,) = found.asserted
    assert one.cause.effect == "steering_delay"
    (delay,) = one.figures.values()
    assert delay.value == pytest.approx(0.06, abs=0.003)
    assert any(f["kind"] == "dense" for f in found.document()["findings"])
