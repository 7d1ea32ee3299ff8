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
RESTS, ROUGH, REMEMBERS = 8.0, 120.0, 0.9  # s; N; from row to row
METER = 150.0  # W


def driven(watts, drag=1.0, seed=0):
    """A rough highway and eight seconds at its end, with more load and drag."""
    way = parse_cycle("hwfet")
    t = np.arange(0.0, way.time_s[-1] + RESTS, 0.1)
    v = np.interp(t, way.time_s, way.speed_mps)
    air = drag * CAR.figures()[DRAG].value
    true = CAR.changed(settings={LOAD: STATED + watts, DRAG: air})
    out = replay(true, drive_of(Trace({"time_s": t, "speed_mps": v}), true))
    rng = np.random.default_rng(seed)
    force = ROUGH * rng.normal(size=len(t))
    for i in range(1, len(t)):
        force[i] = REMEMBERS * force[i - 1] + np.sqrt(1 - REMEMBERS**2) * force[i]
    power = out["battery_power_w"] + force * v + METER * rng.normal(size=len(t))
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
