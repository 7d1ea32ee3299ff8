"""Cornering that nothing explains, of a car whose front axle is driven, has a doubt."""

from dataclasses import replace

import numpy as np
import pytest

from rcc_sim.definitions.cycle import Cycle
from rcc_sim.diagnose.judge.misread import pushed_along
from rcc_sim.diagnose.profiles.remainder import UNKNOWN_ENOUGH, Remainder
from rcc_sim.diagnose.residuals.posed import problem_of
from rcc_sim.simulate.run import LaneChanges, simulate
from rcc_sim.trace import Trace
from tests.cars import car

CYCLE = Cycle("c", np.array([0, 3, 12.0]), np.array([0, 3, 3.0]))
SEEN = ("time_s", "speed_ref_mps", "steer_cmd_rad", "speed_mps", "yaw_rate_radps")


def left(acts_as, nats=UNKNOWN_ENOUGH + 1.0):
    return Remainder(nats, acts_as, "speed_mps", [])


@pytest.fixture(scope="module")
def weaves():
    """A car that is driven by all its wheels, and changes lanes."""
    every = car({})
    run = simulate(every, CYCLE, lanes=LaneChanges(3.0), output_rate=50.0).trace
    log = Trace({c: run[c] for c in SEEN}, name="weaves")
    assert every.drivetrain.driven_axle == "all"
    return problem_of(log, every)


def said(problem, what):
    return [f.kind for f in pushed_along(problem, what)]


def test_it_is_told_of_what_is_left_in_bends_alone(weaves):
    assert said(weaves, left("grip")) == said(weaves, left("steer")) == ["front_push"]
    assert not said(weaves, left("drag"))
    assert not said(weaves, left("grip", nats=0.0))  # nothing real
    assert not said(weaves, None)  # it is left in another log


def test_it_is_not_told_where_the_rear_axle_drives_or_motion_is_imposed(weaves):
    rear = weaves.vehicle.changed(settings={"drivetrain.driven_axle": "rear"})
    assert not said(replace(weaves, vehicle=rear), left("grip"))
    imposed = replace(weaves, drive=replace(weaves.drive, imposed=True))
    assert not said(imposed, left("grip"))
