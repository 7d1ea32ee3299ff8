"""A small car's log of 20 or 40 rows a second: how it was averaged is no cause."""

import numpy as np
import pytest

from rcc_sim.analyse.logged import Logged
from rcc_sim.analyse.sampled import drive_as_sampled
from rcc_sim.definitions.cycle import parse_cycle
from rcc_sim.definitions.vehicle import load_vehicle
from rcc_sim.diagnose.run import diagnose
from rcc_sim.similitude.cycles import scale_cycle
from rcc_sim.simulate.run import LaneChanges, simulate
from rcc_sim.trace import Trace

CAR, TRUCK = load_vehicle("rcc"), load_vehicle("r1t")
CYCLE = scale_cycle(parse_cycle("udds[20:420]"), to=CAR, of=TRUCK, rate=40.0).cycle
NOISE = {
    "speed_mps": 0.005,
    "yaw_rate_radps": 0.01,
    "accel_x_mps2": 0.08,
    "accel_y_mps2": 0.08,
    "motor_current_a": 0.15,
    "battery_voltage_v": 0.02,
    "battery_current_a": 0.1,
}


def logged(rate, effects=None, every=1, noise=1.0):
    """What a logger kept of a drive: means since the row before, or samples of it."""
    truth = CAR.changed(effects=effects or {})
    run = simulate(
        truth, CYCLE, lanes=LaneChanges(every=15.0), output_rate=rate * every
    ).trace
    rows = slice(every - 1, None, every)
    rng = np.random.default_rng(4)
    columns = {c: run[c][rows] for c in ("time_s", "speed_ref_mps", "steer_cmd_rad")}
    for name, sd in NOISE.items():
        x = run[name][rows]
        columns[name] = x + noise * rng.normal(0, sd, len(x))
    columns["speed_mps"] = np.abs(columns["speed_mps"])
    return Logged(Trace(columns, name="made"), (), ())


@pytest.mark.parametrize("noise", [0.01, 1.0])
@pytest.mark.parametrize("rate", [20.0, 40.0])
def test_flows_of_a_loop_are_means(rate, noise):
    assert drive_as_sampled(logged(rate, noise=noise).log, CAR).window > 1 / rate


@pytest.mark.parametrize("noise", [0.01, 1.0])
def test_unless_they_look_like_samples(noise):
    few = logged(20.0, every=5, noise=noise)
    assert drive_as_sampled(few.log, CAR).window < 1 / 20.0


OTHER = pytest.param(20.0, marks=pytest.mark.thorough), 40.0


@pytest.mark.parametrize(
    "every",
    [
        pytest.param(1, id="means"),
        pytest.param(5, id="samples", marks=pytest.mark.thorough),
    ],
)
@pytest.mark.parametrize("rate", OTHER)
def test_a_drive_without_a_cause_has_none(rate, every):
    assert not diagnose([logged(rate, every=every)], CAR).asserted


@pytest.mark.parametrize(
    ("effect", "name", "value"),
    [
        ("motor_lag", "time_constant_s", 0.08),
        pytest.param(
            *("rotor_inertia", "inertia_kgm2", 8e-6), marks=pytest.mark.thorough
        ),
        pytest.param("payload", "mass_kg", 0.8, marks=pytest.mark.thorough),
    ],
)
@pytest.mark.parametrize("rate", OTHER)
def test_what_acts_on_the_motor_is_named_alone(rate, effect, name, value):
    (one,) = diagnose([logged(rate, {effect: {name: value}})], CAR).asserted
    assert one.cause.effect == effect
    assert one.figures[name].value == pytest.approx(value, rel=0.15)


def test_a_load_that_grows_is_told_with_its_course():
    columns = dict(logged(40.0).log.columns)
    time, volts = columns["time_s"], columns["battery_voltage_v"]
    load = 6.0 * time / time[-1]
    columns["battery_current_a"] = columns["battery_current_a"] + load / volts
    log = Logged(Trace(columns, name="made"), (), ())
    (one,) = diagnose([log], CAR).asserted
    assert one.cause.effect == "auxiliary_load"
    assert np.corrcoef(one.cause.profiles[0].at(time), load)[0, 1] > 0.95
    assert one.figures["power_w"].value == pytest.approx(load.mean(), rel=0.1)
