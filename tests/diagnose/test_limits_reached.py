"""No limit lies below a current, or a torque, that a log shows to have flowed."""

from dataclasses import replace

import numpy as np
import pytest

from rcc_sim.definitions.vehicle import load_vehicle
from rcc_sim.diagnose.causes.sought import search_of
from rcc_sim.diagnose.residuals.posed import problem_of
from rcc_sim.diagnose.residuals.sizes import LIMITED, reached
from rcc_sim.physics.effects.current_limit import EFFECT as LIMIT
from rcc_sim.physics.effects.headwind import EFFECT as WIND
from rcc_sim.physics.effects.regeneration_limit import EFFECT as BRAKING
from rcc_sim.trace import Trace
from tests import one_loop

CAR = load_vehicle("rcc")


def problem(car, change=lambda i: i):
    columns = one_loop.rows(car, 0.02, 0.0, 40.0, seed=2)
    columns["motor_current_a"] = change(columns["motor_current_a"])
    return problem_of(Trace(columns, name="log"), CAR)


@pytest.mark.parametrize("limit", [3.0, 5.0])
def test_a_limit_that_acts_is_not_below_what_was_reached(limit):
    limited = CAR.changed(effects={"current_limit": {"max_current_a": limit}})
    most = reached(problem(limited), "motor_current")
    assert 0.7 * limit < most < limit


def test_a_few_rows_that_stand_out_reach_nothing():
    def spiked(current):
        current = current.copy()
        current[200:1800:200] = 100.0
        return current

    plain, odd = (
        reached(problem(CAR, how), "motor_current") for how in (lambda i: i, spiked)
    )
    assert odd == pytest.approx(plain, rel=0.02)


def test_no_lesser_limit_is_sought():
    one = problem(CAR)
    search = search_of(one, LIMIT, LIMIT.params[0])
    most = reached(one, "motor_current")
    assert 0.0 < most == search.low
    assert search.grid and min(search.grid) >= most


def test_what_is_no_limit_is_sought_below_nil_as_well():
    search = search_of(problem(CAR), WIND, WIND.params[0])
    assert search.low < 0.0 < search.high


def test_where_nothing_flowed_none_at_all_is_tried():
    """A scaled car may give nothing back where its file lets it: nil is to be tried."""
    free = CAR.changed(settings={"effects.regeneration_limit.max_current_a": 50.0})
    one = replace(problem(CAR, lambda i: np.maximum(i, 0.0)), vehicle=free)
    assert reached(one, "braking_current") == 0.0
    assert 0.0 in search_of(one, BRAKING, BRAKING.params[0]).grid


@pytest.mark.parametrize("of", LIMITED)
def test_a_log_without_the_channel_tells_of_none(of):
    one = problem(CAR)
    kept = {c: x for c, x in one.log.columns.items() if "motor" not in c}
    bare = replace(one, log=Trace(kept, name="log"))
    assert reached(bare, of) == 0.0
