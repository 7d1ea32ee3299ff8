"""A log of the way back: slope and wind of the road come from the other side."""

import numpy as np
import pytest

from rcc_sim.definitions.vehicle import load_vehicle
from rcc_sim.errors import InputError
from rcc_sim.simulate.drive import drive_of
from rcc_sim.simulate.replay import replay
from rcc_sim.trace import Trace
from rcc_sim.units import RHO_AIR, G

SLOPE, WIND = 0.02, 3.0  # 1, m/s
ROAD = {"effects.road_grade.slope": SLOPE, "effects.headwind.speed_mps": WIND}


def log(direction=None):
    t = np.arange(0.0, 60.0, 0.1)
    columns = {"time_s": t, "speed_mps": np.full(len(t), 15.0)}
    if direction is not None:
        columns["direction"] = np.full(len(t), direction)
    return Trace(columns, name="log.csv")


def force(car, trace):
    """Return the force at the wheels. [N]"""
    out = replay(car, drive_of(trace, car, 0.1))
    lever = car.tyres.radius_m.value / car.drivetrain.gear_ratio.value
    return out["motor_torque_nm"][30] / lever


def test_out_and_back_part_slope_and_wind_by_their_closed_forms():
    """Half their difference is m g sin θ + 2 k v w, k (v² + w²) of drag in the mean."""
    free = load_vehicle("r1t_epa").changed(without=("road_load",))
    free = free.changed(without=tuple(free.effects))
    car = free.changed(settings={"effects.aerodynamic_drag.drag_area_m2": 1.2} | ROAD)
    out, back = force(car, log()), force(car, log(-1.0))
    k, m = 0.5 * RHO_AIR * 1.2, car.body.mass_kg.value
    turned = m * G * SLOPE / np.hypot(1.0, SLOPE) + 2 * k * 15.0 * WIND
    assert 0.5 * (out - back) == pytest.approx(turned, rel=1e-6)
    assert 0.5 * (out + back) == pytest.approx(k * (15.0**2 + WIND**2), rel=1e-6)


def test_a_way_out_is_what_no_direction_says():
    car = load_vehicle("r1t_epa")
    car = car.changed(settings={"effects.road_grade.slope": SLOPE})
    assert force(car, log(1.0)) == force(car, log())


@pytest.mark.parametrize(
    ("values", "told"),
    [(np.linspace(-1, 1, 600), "row 2: direction: "), (np.arange(600), "1, or -1")],
)
def test_a_direction_that_is_none_is_refused(values, told):
    trace = Trace({**log().columns, "direction": values}, name="log.csv")
    with pytest.raises(InputError) as error:
        drive_of(trace, load_vehicle("r1t_epa"))
    assert told in f"{error.value} {error.value.hint}"


def test_a_log_that_turns_round_is_to_be_cut_there():
    values = np.where(np.arange(600) < 300, 1.0, -1.0)
    trace = Trace({**log().columns, "direction": values}, name="log.csv")
    with pytest.raises(InputError, match="row 301: direction changes"):
        drive_of(trace, load_vehicle("r1t_epa"))


def test_a_measured_slope_is_the_drives_own_either_way():
    car = load_vehicle("r1t_epa")
    out, back = (
        Trace({**log(way).columns, "slope": np.full(600, SLOPE)}, name="log.csv")
        for way in (1.0, -1.0)
    )
    assert force(car, out) == force(car, back)
