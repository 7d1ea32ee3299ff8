"""What rest and accelerometer read directly is a doubt where a fit disagrees."""

from dataclasses import replace

import numpy as np
import pytest

from rcc_sim.definitions.cycle import parse_cycle
from rcc_sim.definitions.vehicle import load_vehicle
from rcc_sim.diagnose.causes.cause import Cause
from rcc_sim.diagnose.fitting import descent
from rcc_sim.diagnose.fitting.engine import Engine
from rcc_sim.diagnose.fitting.knobs import nuisance_knobs
from rcc_sim.diagnose.judge.direct import STRETCH, disagreeing, felt_otherwise
from rcc_sim.diagnose.residuals.posed import problem_of
from rcc_sim.simulate.drive import drive_of
from rcc_sim.simulate.replay import replay
from rcc_sim.trace import Trace, integral_of
from rcc_sim.units import G

CAR = load_vehicle("tesla_model_3")
NOISE = {"speed_mps": 0.02, "battery_power_w": 150.0, "accel_x_mps2": 0.06}
HILL = (2500.0, 3500.0, 0.02)


def told(at_rest=0.0, hill=0.0, seed=1, where=HILL):
    """What is told of a drive in a town, of which the log has no road.

    ``at_rest`` [W] is drawn at rest alone; the accelerometer feels so much of a hill
    that the battery does not.
    """
    town = parse_cycle("udds[0:500]")
    t = np.arange(0.0, 500.0, 0.1)
    v = np.interp(t, town.time_s, town.speed_mps)
    s = integral_of(t, v)
    out = replay(CAR, drive_of(Trace({"time_s": t, "speed_mps": v}), CAR))
    slope = np.where((s > where[0]) & (s < where[1]), hill * where[2], 0.0)
    true = {
        "speed_mps": v,
        "battery_power_w": out["battery_power_w"] + at_rest * (v == 0),
        "accel_x_mps2": out["accel_x_mps2"] + G * slope,
    }
    rng = np.random.default_rng(seed)
    seen = {c: x + rng.normal(0, NOISE[c], len(t)) for c, x in true.items()}
    seen["speed_mps"] = np.abs(seen["speed_mps"]) * (v > 0)
    engine = Engine([problem_of(Trace({"time_s": t} | seen, name="town"), CAR)])
    fit = descent.fit(engine, {}, nuisance_knobs(engine.problems))
    return disagreeing(engine, fit), t[s > where[0]][0], t[s < where[1]][-1]


def test_nothing_is_told_of_a_drive_that_agrees():
    assert told()[0] == ()


@pytest.mark.parametrize("watts", [2500.0, -900.0])
def test_what_is_drawn_at_rest_alone_is_told(watts):
    (one,), *_ = told(at_rest=watts)
    assert one.channel == "battery_power_w"
    size, _, way = one.what.split()[1:4]
    assert way == ("more" if watts > 0 else "less")
    # load and drag as stated, which may be off by their sds, give way by much of it
    assert 0.1 * abs(watts) < float(size) < 0.7 * abs(watts)


@pytest.mark.parametrize("where", [HILL, (1000.0, 3500.0, 0.02)])
def test_a_slope_that_was_felt_and_not_climbed_is_told_where_it_is(where):
    (one,), begins, ends = told(hill=1.0, where=where)
    assert one.channel == "accel_x_mps2" and "slope +" in one.what
    assert begins - 0.5 * STRETCH < one.start_s < one.end_s < ends + 0.5 * STRETCH
    assert one.end_s - one.start_s > min(0.7 * (ends - begins), ends - begins - STRETCH)


def test_a_hill_that_an_accelerometer_did_not_feel_is_doubtful():
    """A brake that dragged for half a drive was a hill, at 99 %."""
    (felt,), *_ = told(hill=1.0)
    slope, profiles = ("effects.road_grade.slope",), {0: None}
    hill = Cause("road_grade", slope, 900.0, profiles=profiles)
    assert felt_otherwise(hill, [felt])
    assert not felt_otherwise(hill, [replace(felt, channel="battery_power_w")])
    assert not felt_otherwise(hill, [])
    assert not felt_otherwise(replace(hill, profiles={}), [felt])
    assert not felt_otherwise(replace(hill, keys=("effects.headwind.x",)), [felt])
