"""What the battery gives at rest is a load, however rough the road was before."""

import numpy as np
import pytest

from rcc_sim.analyse.logged import Logged
from rcc_sim.definitions.cycle import parse_cycle
from rcc_sim.definitions.vehicle import load_vehicle
from rcc_sim.diagnose.run import diagnose
from rcc_sim.simulate.drive import drive_of
from rcc_sim.simulate.replay import replay
from rcc_sim.trace import Trace

CAR = load_vehicle("tesla_model_3")
LOAD, DRAG = "effects.auxiliary_load.power_w", "effects.road_load.c_n_s2_per_m2"
STATED = CAR.figures()[LOAD].value
RESTS, ROUGH, METER = 8.0, 120.0, 150.0  # s; N; W
ROW = 0.1


def wandering(seconds, rows, rng):
    """What forgets within some seconds: an Ornstein-Uhlenbeck process of size 1."""
    fade, x = np.exp(-ROW / seconds), rng.normal(size=rows)
    for i in range(1, rows):
        x[i] = fade * x[i - 1] + np.sqrt(1 - fade**2) * x[i]
    return x


def driven(watts, drag=1.0, cycle="hwfet", wanders=0.0, meter=METER, seed=0):
    """A rough way and eight seconds at its end, with more load and drag.

    The load may wander within a minute.
    """
    way = parse_cycle(cycle)
    t = np.arange(0.0, way.time_s[-1] + RESTS, ROW)
    v = np.interp(t, way.time_s, way.speed_mps)
    air = drag * CAR.figures()[DRAG].value
    true = CAR.changed(settings={LOAD: STATED + watts, DRAG: air})
    out = replay(true, drive_of(Trace({"time_s": t, "speed_mps": v}), true))
    rng = np.random.default_rng(seed)
    force = ROUGH * wandering(1.0, len(t), rng)
    power = out["battery_power_w"] + force * v + meter * rng.normal(size=len(t))
    power += wanders * wandering(60.0, len(t), rng)
    speed = np.abs(v + 0.02 * rng.normal(size=len(t)) * (v > 0))
    columns = {"time_s": t, "speed_mps": speed, "battery_power_w": power}
    return Logged(Trace(columns, name="way"), (), ())


@pytest.mark.slow
@pytest.mark.parametrize("drag", [1.0, 1.25])
def test_a_load_that_shows_at_rest_is_named_beside_a_rough_road(drag):
    """By noise that remembers the road none is named, or one with other drags."""
    (one,) = diagnose([driven(1000.0, drag)], CAR).asserted
    assert (one.cause.effect, one.cause.tied) == ("auxiliary_load", ())
    assert one.probability > 0.9
    power = one.figures["power_w"]
    assert power.low < STATED + 1000 < power.high
    assert power.high - power.low < 400.0


@pytest.mark.slow
def test_a_load_as_stated_is_none():
    assert diagnose([driven(0.0)], CAR).asserted == ()


@pytest.mark.slow
@pytest.mark.parametrize("wanders", [60.0, 150.0])
def test_a_load_that_wanders_about_what_is_stated_is_none(wanders):
    """At each stop it is another, and by a quiet meter that is beyond doubt."""
    log = driven(0.0, cycle="udds[0:600]", wanders=wanders, meter=20.0)
    found = diagnose([log], CAR)
    assert (found.status, found.asserted) == ("no_gap", ())
