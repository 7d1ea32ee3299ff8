"""A log that holds the wind: it blows as the log says, beside the file's own."""

import numpy as np
import pytest

from rcc_sim.definitions.vehicle import load_vehicle
from rcc_sim.diagnose.causes.profile import Profile, acted_on
from rcc_sim.diagnose.residuals.problem import Problem
from rcc_sim.readers.suggest import meaning_of
from rcc_sim.simulate.drive import drive_of
from rcc_sim.simulate.replay import replay
from rcc_sim.trace import Trace
from rcc_sim.units import RHO_AIR

AREA, SPEED, FILE = 1.2, 20.0, 1.5  # m², m/s, m/s
KEY = "effects.headwind.speed_mps"


def car(wind=0.0):
    free = load_vehicle("r1t_epa").changed(without=("road_load",))
    free = free.changed(without=tuple(free.effects))
    drag = {"effects.aerodynamic_drag.drag_area_m2": AREA}
    return free.changed(settings=drag | {"effects.headwind.speed_mps": wind})


def log(wind=None, **more):
    t = np.arange(0.0, 60.0, 0.1)
    columns = {"time_s": t, "speed_mps": np.full(len(t), SPEED)}
    if wind is not None:
        columns["headwind_mps"] = np.broadcast_to(np.asarray(wind, float), len(t))
    return Trace(columns | more, name="log.csv")


def force(vehicle, trace):
    """Return the force at the wheels at the rows. [N]"""
    out = replay(vehicle, drive_of(trace, vehicle, 0.1))
    lever = vehicle.tyres.radius_m.value / vehicle.drivetrain.gear_ratio.value
    return out["motor_torque_nm"][1:] / lever


def test_the_drag_is_that_of_the_air_that_comes():
    """F = k (v + w_log + w_file) |v + w_log + w_file|, from behind as from ahead."""
    t = log()["time_s"]
    wind = 30.0 * np.sin(0.2 * t)
    air = SPEED + FILE + wind
    between = 0.5 * (air[1:] * np.abs(air[1:]) + air[:-1] * np.abs(air[:-1]))
    by_hand = 0.5 * RHO_AIR * AREA * between  # a mean over the row before
    got = force(car(FILE), log(wind))
    assert np.allclose(got, by_hand, atol=0.02 * np.abs(by_hand).max())
    assert got.min() < 0 < got.max()


def test_a_steady_one_is_the_file_s_own():
    assert np.array_equal(force(car(), log(4.0)), force(car(4.0), log()))
    assert np.array_equal(force(car(4.0), log(0.0)), force(car(4.0), log()))


def test_on_the_way_back_it_blows_as_it_was_measured():
    back = {"direction": np.full(600, -1.0)}
    assert force(car(), log(4.0, **back))[30] == force(car(), log(4.0))[30]


def test_without_a_reading_it_is_between_its_neighbours():
    wind = np.linspace(0.0, 6.0, 600)
    holed = np.where(np.arange(600) % 7 == 3, np.nan, wind)
    assert force(car(), log(holed)) == pytest.approx(force(car(), log(wind)), rel=1e-9)


def test_a_profile_of_wind_acts_as_the_logged_one():
    t = log()["time_s"]
    knots = np.linspace(0.0, t[-1], 9)
    value = 5.0 * np.cos(knots)
    found = Profile(KEY, "time_s", knots, value, 0 * knots, 90.0)
    still = drive_of(log(), car(), 0.1)
    acting = acted_on(Problem(car(), log(), still), found).drive
    blown = drive_of(log(np.interp(t, knots, value)), car(), 0.1)
    assert np.array_equal(acting.commands.wind, blown.commands.wind)


@pytest.mark.parametrize(
    ("name", "column"),
    [("Headwind [m/s]", "headwind_mps"), ("Wind speed (km/h)", None)],
)
def test_a_wind_is_no_speed_of_the_car(name, column):
    meaning = meaning_of(name)
    assert (meaning and meaning.column) == column


@pytest.mark.parametrize("along", ["distance_m", "time_s"])
def test_on_the_way_back_slope_and_wind_are_those_of_the_way_out(along):
    """A profile acts as its constant does, which the other way turns its sign."""
    key = {"distance_m": "effects.road_grade.slope", "time_s": KEY}[along]
    out, back = log(), log(direction=np.full(600, -1.0))
    value = np.full(3, 0.02 if along == "distance_m" else 4.0)
    found = Profile(key, along, np.array([0.0, 5.0, 2e3]), value, value, 90.0)
    for trace in (out, back):
        problem = Problem(car(), trace, drive_of(trace, car(), 0.1))
        acting = acted_on(problem, found).predict({})["motor_torque_nm"]
        steady = problem.predict({key: value[0]})["motor_torque_nm"]
        assert acting == pytest.approx(steady, rel=1e-9)
