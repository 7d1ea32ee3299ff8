"""A patch on which the tyres hold less is told where it lies; an even road has none."""

import numpy as np
import pytest

from rcc_sim.definitions.vehicle import load_vehicle
from rcc_sim.diagnose.fitting import descent
from rcc_sim.diagnose.fitting.engine import Engine
from rcc_sim.diagnose.fitting.knobs import nuisance_knobs
from rcc_sim.diagnose.profiles.remainder import LATERAL_ENOUGH, remainder
from rcc_sim.diagnose.residuals.posed import problem_of
from rcc_sim.trace import Trace
from tests.winding import seen_of, winding

CAR = load_vehicle("tesla_model_3")
SIZES = {"yaw_rate_radps": 0.003, "accel_y_mps2": 0.08, "battery_power_w": 300.0}
PATCH = (150.0, 180.0)


def left_of(grip):
    """What is left of a drive in bends, on whose patch the front axle is so stiff."""
    rng = np.random.default_rng(8)
    given = winding()
    t = given["time_s"]
    known = problem_of(Trace(given), CAR)
    slips = {"effects.front_cornering_stiffness.scale": grip}
    seen, slid = known.driven({}), known.driven(slips)
    there = (t >= PATCH[0]) & (t <= PATCH[1])
    noisy = seen_of(seen, slid, there, SIZES, rng)
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
