"""A gyro's noise while a car stands: it turns on the spot in no drive."""

import numpy as np
import pytest

from rcc_sim.definitions.kernel import answering_time
from rcc_sim.definitions.vehicle import load_vehicle
from rcc_sim.simulate.drive import calm, drive_of
from rcc_sim.simulate.replay import replay
from rcc_sim.trace import Trace

CAR = load_vehicle("r1t_epa")
TIME = np.arange(0.0, 60.0, 0.1)
SPEED = np.interp(TIME, [0, 10, 20, 30, 40, 60], [0, 0, 12, 12, 0, 0])


def turned(yaw_rate):
    return Trace({"time_s": TIME, "speed_mps": SPEED, "yaw_rate_radps": yaw_rate})


def power(yaw_rate):
    return replay(CAR, drive_of(turned(yaw_rate), CAR))


def test_the_noise_of_a_gyro_asks_no_torque_of_a_car_that_stands():
    noise = np.random.default_rng(1).normal(0.0, 0.01, len(TIME))
    with_it, without = power(noise), power(np.zeros(len(TIME)))
    for name in ("motor_torque_nm", "battery_power_w"):
        off = np.abs(with_it[name] - without[name])
        assert off.max() < 0.1 * np.abs(without[name]).max()


def test_a_bend_is_driven_as_it_was():
    bend = np.where(SPEED > 5, 0.2, 0.0)
    out = replay(CAR, drive_of(turned(bend), CAR))
    yaw = np.diff(out["yaw_rad"][[0, -1]])[0]
    steps = 0.5 * (bend[1:] + bend[:-1]) * 0.1
    np.testing.assert_allclose(yaw, steps.sum(), rtol=1e-3)


def test_a_straight_stretch_is_a_bend_that_is_next_to_none():
    """Before and after a bend: its wheels stand straight, and no tyre has a force."""
    car = CAR.changed(effects={"steering_drag": {"force_n_per_rad": 500.0}})
    bend = np.where((TIME > 20) & (TIME < 25), 0.3, 0.0)
    straight, hardly = (
        replay(car, drive_of(turned(rate), car))
        for rate in (bend, np.maximum(bend, 1e-9))
    )
    power = straight["battery_power_w"]
    np.testing.assert_allclose(power, hardly["battery_power_w"], rtol=0, atol=1e-3)
    assert not straight["accel_y_mps2"][TIME < 20].any()


@pytest.mark.parametrize(("rate", "left"), [(10, 1.001), (100, 0.4), (1000, 0.13)])
def test_no_turning_within_the_cars_own_time_is_read_from_a_gyro(rate, left):
    """White noise of close rows goes, by the root of their number; a turn stays."""
    time = np.arange(0.0, 60.0, 1 / rate)
    noise = np.random.default_rng(2).normal(0.0, 0.01, len(time))
    turn = 0.3 * np.sin(2 * np.pi * time / (10 * answering_time(CAR)))
    even = calm(time, turn, answering_time(CAR))
    assert np.abs(even - turn)[rate:-rate].max() < 0.005 * 0.3
    rest = calm(time, turn + noise, answering_time(CAR)) - even
    assert np.std(rest) <= left * np.std(noise)
