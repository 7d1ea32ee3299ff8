"""A log that begins where the vehicle turns already."""

import numpy as np
import pytest

from rcc_sim.simulate.drive import drive_of
from rcc_sim.simulate.replay import replay
from rcc_sim.trace import Trace
from tests.cars import car, truck

SPEED, STEER = 12.0, 0.03
TIME = np.arange(0.0, 6.0, 0.05)
DELAYED = {"steering_delay": {"delay_s": 0.2}}


def held(**more):
    """Speed and steering as they are at the start."""
    log = {"speed_mps": SPEED, "steer_cmd_rad": STEER} | more
    return Trace({"time_s": TIME} | {c: np.full(len(TIME), x) for c, x in log.items()})


def steady_yaw_rate(vehicle, speed=SPEED, steer=STEER):
    """v δ / (l + K v²), with K = m (l_R C_R - l_F C_F) / (2 l C_F C_R): a bicycle."""
    body, tyres = vehicle.body, vehicle.tyres
    l_F, l_R = body.cg_to_front_axle_m.value, body.cg_to_rear_axle_m.value
    C_F = tyres.front_cornering_stiffness_n_per_rad.value
    C_R = tyres.rear_cornering_stiffness_n_per_rad.value
    length = l_F + l_R
    more = (l_R * C_R - l_F * C_F) / (2 * length * C_F * C_R)
    return speed * steer / (length + body.mass_kg.value * more * speed**2)


@pytest.mark.parametrize(
    "effects",
    [
        {},
        {"steering_lag": {"time_constant_s": 0.2}},
        DELAYED,
        {"tyre_relaxation": {"length_m": 0.6}},
    ],
)
def test_one_that_holds_its_bend_has_turned_so_from_the_first_row(effects):
    vehicle = truck(effects)
    turns = replay(vehicle, drive_of(held(), vehicle))["yaw_rate_radps"]
    assert turns == pytest.approx(0 * turns + steady_yaw_rate(vehicle), rel=5e-3)


def test_one_by_commands_too_with_what_is_on_its_way_to_the_wheels():
    vehicle = car(DELAYED)
    log = held(speed_mps=3.0, speed_ref_mps=3.0)
    turns = replay(vehicle, drive_of(log, vehicle), (0.2, 1.0, 1.0))["yaw_rate_radps"]
    assert turns == pytest.approx(0 * turns + steady_yaw_rate(vehicle, 3.0), rel=2e-2)


def test_by_a_gyro_alone_it_is_as_it_is_once_it_has_held_its_yaw_rate_for_long():
    vehicle = truck({})
    log = held(yaw_rate_radps=0.1)
    columns = {c: log[c] for c in log.columns if c != "steer_cmd_rad"}
    drive = drive_of(Trace(columns), vehicle)
    assert drive.turns_as_measured
    out = replay(vehicle, drive)
    for column in ("accel_y_mps2", "battery_power_w"):
        assert out[column][1] == pytest.approx(out[column][-1], rel=2e-3)


def test_a_cut_of_a_drive_goes_on_as_the_whole_of_it_does():
    vehicle = truck({"steering_lag": {"time_constant_s": 0.1}})
    t = np.arange(0.0, 60.0, 0.05)
    steer = 0.03 * np.sin(0.5 * t)
    whole = Trace(
        {"time_s": t, "speed_mps": 12 + 0 * t, "steer_cmd_rad": steer}, name="x"
    )
    known = replay(vehicle, drive_of(whole, vehicle))["yaw_rate_radps"]
    first = 460  # where it turns hard
    cut = Trace({c: whole[c][first:] for c in whole.columns}, name="x")
    again = replay(vehicle, drive_of(cut, vehicle))["yaw_rate_radps"]
    assert abs(known[first]) > 0.8 * known.max()
    assert np.abs(again - known[first:]).max() < 0.05 * known.max()


def test_one_that_would_spin_begins_straight():
    """It oversteers, far above the speed up to which it holds a bend."""
    vehicle = truck({"rear_cornering_stiffness": {"scale": 0.3}})
    out = replay(vehicle, drive_of(held(speed_mps=60.0), vehicle))
    assert out["yaw_rate_radps"][0] == 0.0
