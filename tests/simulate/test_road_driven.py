"""A log's road lies along the distance that its speeds make; a true one is farther."""

import numpy as np
import pytest

from rcc_sim.definitions.vehicle import load_vehicle
from rcc_sim.simulate.drive import drive_of
from rcc_sim.simulate.replay import replay
from rcc_sim.simulate.road import surveyed_slope
from rcc_sim.trace import Trace
from rcc_sim.units import G

LOW = 0.96  # 1; logged speed over the true one
HILL, LONG = 12.0, 900.0  # m


def hills(distance):
    return HILL * np.sin(2 * np.pi * distance / LONG)


def logs():
    """Return what was driven, and what was logged by a wheel that is too small."""
    t = np.arange(0.0, 400.0, 0.1)
    v = np.interp(t, [0, 10, 60, 200, 260, 390, 400], [0, 0, 18, 22, 12, 20, 0])
    x = np.concatenate([[0.0], np.cumsum(0.05 * (v[1:] + v[:-1]))])
    true = {"time_s": t, "speed_mps": v, "elevation_m": hills(x)}
    return Trace(true, name="true"), Trace({**true, "speed_mps": LOW * v}, name="log")


@pytest.mark.parametrize(
    "settings",
    [
        {"effects.wheel_radius.scale": 1 / LOW},
        {"effects.speed_sensor_scale.scale": LOW},
    ],
)
def test_the_hills_stay_where_the_car_climbed_them(settings):
    car = load_vehicle("r1t_epa")
    true, logged = logs()
    needed = replay(car, drive_of(true, car, 0.1))["battery_power_w"]
    mended = car.changed(settings=settings)
    found = replay(mended, drive_of(logged, mended, 0.1))["battery_power_w"]
    # a bigger wheel's motor turns slower: as much as the map's efficiency follows it
    off = np.sqrt(np.mean((found - needed) ** 2)) / np.sqrt(np.mean(needed**2))
    assert off < 0.01


def test_the_first_climb_costs_its_height_whatever_the_speeds_say():
    """m g dz at the shaft, but for what the gears and the rolling make of it."""
    car = load_vehicle("r1t_epa")
    true, logged = logs()
    flat = Trace({k: logged[k] for k in ("time_s", "speed_mps")}, name="flat")
    mended = car.changed(settings={"effects.wheel_radius.scale": 1 / LOW})
    hilly, level = (
        replay(mended, drive_of(log, mended, 0.1)) for log in (logged, flat)
    )
    power = hilly["motor_torque_nm"] - level["motor_torque_nm"]
    work = np.cumsum(power * hilly["motor_speed_radps"]) * 0.1
    top = int(np.argmax(true["elevation_m"][:600]))
    weight = car.body.mass_kg.value * G
    assert work[top] == pytest.approx(weight * true["elevation_m"][top], rel=0.01)


@pytest.mark.parametrize("waits", [0.0, 60.0])
def test_a_car_that_waits_on_a_slope_surveys_it_where_it_stands(waits):
    """All its rows there are one place, not the middle of a stretch of road."""
    s = np.linspace(0.0, 3000.0, 3000)
    rows = 1 + int(waits) * 10 * ((s == 0) | (np.arange(3000) % 1000 == 500))
    at = np.repeat(s, rows)
    where, slope = surveyed_slope(at, hills(at))
    true = HILL * 2 * np.pi / LONG * np.cos(2 * np.pi * where / LONG)
    assert np.abs(slope - true).max() < 2.5e-3
