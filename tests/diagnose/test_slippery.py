"""A patch on which the tyres hold less is told where it lies; an even road has none."""

import numpy as np
import pytest

from rcc_sim.definitions.vehicle import load_vehicle
from rcc_sim.diagnose import descent
from rcc_sim.diagnose.engine import Engine
from rcc_sim.diagnose.knobs import nuisance_knobs
from rcc_sim.diagnose.posed import problem_of
from rcc_sim.diagnose.remainder import LATERAL_ENOUGH, remainder
from rcc_sim.trace import Trace

CAR = load_vehicle("tesla_model_3")
SIZES = {"yaw_rate_radps": 0.003, "accel_y_mps2": 0.08, "battery_power_w": 300.0}
PATCH = (150.0, 180.0)


def left_of(grip):
    """What is left of a drive in bends, on whose patch the front axle is so stiff."""
    rng = np.random.default_rng(8)
    t = np.arange(0.0, 300.0, 0.1)
    given = {
        "time_s": t,
        "speed_mps": 14 + 3 * np.sin(t / 9),
        "steer_cmd_rad": 0.03 * np.sin(t / 3.1),
    }
    known = problem_of(Trace(given), CAR)
    slips = CAR.changed(settings={"effects.front_cornering_stiffness.scale": grip})
    seen, slid = known.run(CAR), known.run(slips)
    there = (t >= PATCH[0]) & (t <= PATCH[1])
    noisy = {
        c: np.where(there, slid[c], seen[c]) + size * rng.normal(size=len(t))
        for c, size in SIZES.items()
    }
    problem = problem_of(Trace(given | noisy), CAR)
    engine = Engine([problem])
    return remainder(engine, descent.fit(engine, {}, nuisance_knobs([problem])))


@pytest.mark.slow
def test_a_patch_is_told_by_the_grip_and_where_it_lies():
    left = left_of(0.6)
    assert left.is_real
    assert (left.acts_as, left.follows) == ("grip", "time_s")
    spans = np.array([(w["start_s"], w["end_s"]) for w in left.windows])
    assert spans.min() > PATCH[0] - 8 and spans.max() < PATCH[1] + 8
    assert np.ptp(spans, axis=1).sum() > 0.5 * np.ptp(PATCH)


@pytest.mark.slow
def test_an_even_road_leaves_no_grip_that_changes():
    left = left_of(1.0)
    assert not left.is_real
    (grip,) = (r for r in left.rivals if r.acts_as == "grip")
    assert grip.evidence < 0.3 * LATERAL_ENOUGH
