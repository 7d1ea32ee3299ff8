"""A log of a thousand rows a second is judged by two hundred of them."""

import numpy as np
import pytest

from rcc_sim.analyse.logged import Logged
from rcc_sim.channel import sensor_noise
from rcc_sim.definitions.cycle import parse_cycle
from rcc_sim.definitions.vehicle import load_vehicle
from rcc_sim.diagnose.residuals.dense import rows_to_one, thinned, with_fewer_rows
from rcc_sim.diagnose.residuals.posed import problem_of
from rcc_sim.diagnose.run import diagnose
from rcc_sim.similitude.cycles import scale_cycle
from rcc_sim.simulate.run import LaneChanges, simulate
from rcc_sim.trace import Trace
from tests.scaled_drive import NOISE


def log_of(rate, seconds=10.0, **columns):
    time = 3.0 + np.arange(round(seconds * rate)) / rate
    return Trace({"time_s": time, **{c: f(time) for c, f in columns.items()}}, name="x")


def fast(car, every):
    """Return a scaled drive at 1 kHz, with a lane change every so many metres."""
    cycle = scale_cycle(parse_cycle("udds[20:60]"), to=car, of=load_vehicle("r1t"))
    lanes = LaneChanges(every)
    return simulate(car, cycle.cycle, lanes=lanes, output_rate=1000.0).trace


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


def test_sensors_are_means_and_commands_leap_where_they_did():
    def leap(t):
        return np.where(t < 7.0, 0.1, 0.9)

    log = log_of(1000.0, speed_mps=lambda t: 2 * t, throttle=leap, yaw_rad=np.cos)
    gone = log["speed_mps"].copy()
    gone[1004:1007] = np.nan  # of five rows the first and the last are left
    gone[2003:2008] = np.nan
    log = Trace({**log.columns, "speed_mps": gone}, name="x")
    fewer = with_fewer_rows(log, 5)
    time = fewer["time_s"]
    assert np.allclose(time, log["time_s"][5::5][: len(time)])  # 7.0 is one of them
    known = np.delete(np.arange(len(time)), 400)
    assert np.allclose(fewer["speed_mps"][known], 2 * time[known])
    assert np.isnan(fewer["speed_mps"][400])
    assert np.array_equal(fewer["throttle"], leap(time))
    assert np.array_equal(fewer["yaw_rad"], np.cos(time))


def test_a_command_that_leaps_anywhere_is_neither_early_nor_late():
    rng = np.random.default_rng(5)
    leaps = np.sort(rng.choice(30_000, 1500, replace=False)) / 1000
    log = log_of(1000.0, 30.0, throttle=lambda t: 0.01 * np.searchsorted(leaps + 3, t))
    fewer = with_fewer_rows(log, 5)
    time = log["time_s"][5:-5]
    holding = np.searchsorted(fewer["time_s"], time + 1e-9) - 1
    rest = np.mean(log["throttle"][5:-5] - fewer["throttle"][holding])
    per_second = 0.01 * len(leaps) / 30.0
    assert abs(rest / per_second) < 0.3e-3  # 2 ms late, as in the middle row


def test_flows_are_means_since_the_row_before_and_samples_are_about_it():
    log = log_of(1000.0, speed_mps=lambda t: t, motor_current_a=lambda t: t)
    fewer = with_fewer_rows(log, 5)
    time = fewer["time_s"]
    np.testing.assert_allclose(fewer["speed_mps"], time)
    # each row of the log is itself a mean over the millisecond before
    np.testing.assert_allclose(fewer["motor_current_a"][1:], time[1:] - 0.002)


def test_rows_across_a_hole_are_no_mean():
    log = log_of(1000.0, speed_mps=np.sin)
    kept = np.r_[0:1002, 5003:10_000]
    log = Trace({c: x[kept] for c, x in log.columns.items()}, name="x")
    fewer = with_fewer_rows(log, 5)
    assert np.abs(fewer["speed_mps"] - np.sin(fewer["time_s"])).max() < 1e-5


def test_a_delay_is_found_at_a_thousand_rows_a_second():
    car = load_vehicle("rcc")
    run = fast(car.changed(settings={"effects.steering_delay.delay_s": 0.06}), 2.0)
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


def test_a_reference_that_holds_for_ten_milliseconds_is_followed_to_the_tick():
    """A payload, told as a current sensor that reads too much and a slope: at 99 %."""
    car = load_vehicle("rcc")
    true = car.changed(settings={"effects.payload.mass_kg": 0.5})
    run = fast(true, 10.0)
    rng = np.random.default_rng(2)
    sds = NOISE | {"motor_current_a": 0.15, "speed_mps": 0.01}
    log = {c: run[c] + sd * rng.standard_normal(len(run)) for c, sd in sds.items()}
    late = run["time_s"] - run["time_s"] % 0.01
    log["speed_ref_mps"] = np.interp(late, run["time_s"], run["speed_ref_mps"])
    fewer = thinned(Logged(Trace(log, name="fast"), (), None)).log
    problem = problem_of(fewer, true)
    for channel in ("speed_mps", "motor_current_a"):
        left = fewer[channel] - problem.driven({})[channel]
        assert np.nanstd(left) < 1.2 * sensor_noise(left), channel


def test_a_command_that_lost_a_row_leaps_where_it_did():
    def stairs(t):
        return np.floor(10 * t) / 10 + 0.1

    log = log_of(1000.0, speed_mps=np.sin, speed_ref_mps=stairs)
    whole = with_fewer_rows(log, 5)
    lost = log["speed_ref_mps"].copy()
    lost[333] = np.nan
    fewer = with_fewer_rows(Trace({**log.columns, "speed_ref_mps": lost}, name="x"), 5)
    assert np.array_equal(fewer["time_s"], whole["time_s"])
    assert np.array_equal(fewer["speed_ref_mps"], whole["speed_ref_mps"])
