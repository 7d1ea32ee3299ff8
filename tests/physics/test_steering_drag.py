"""The scrub of turned wheels, against what it is by hand."""

from types import SimpleNamespace

import numpy as np
import pytest

from rcc_sim.definitions.cycle import Cycle
from rcc_sim.definitions.vehicle import load_vehicle
from rcc_sim.diagnose.causes.candidates import candidates_for
from rcc_sim.diagnose.diagnosis import Diagnosis
from rcc_sim.diagnose.residuals.problem import Problem
from rcc_sim.simulate.drive import drive_of
from rcc_sim.simulate.run import LaneChanges, simulate
from tests.cars import car, truck

SCRUB = {"steering_drag": {"force_n_per_rad": 4.0}}
STRAIGHT = Cycle("pull away", np.array([0.0, 2.0, 20.0]), np.array([0.0, 3.0, 3.0]))


def test_a_steady_bend_costs_the_force_times_the_speed():
    time = np.arange(0, 10, 0.01)
    circle = Cycle("circle", time, np.full(len(time), 3.0))
    bend = np.full(len(time), 2.0)
    runs = [
        simulate(car(effects), circle, imposed=True, yaw_rate=bend)
        for effects in ({}, SCRUB)
    ]
    plain, held = (run.trace["battery_power_w"][500:] for run in runs)
    angle = np.arctan(car().wheelbase * 2.0 / 3.0)
    # a wheel turns a little less against the car near standstill: 2e-4 here
    np.testing.assert_allclose(held - plain, 4.0 * angle * 3.0, rtol=5e-4)


@pytest.mark.parametrize("made", [car, truck])
def test_the_ledger_holds_what_the_steering_adds_up_to(made):
    run = simulate(made(SCRUB), STRAIGHT, lanes=LaneChanges(8.0))
    delta, v = run.trace["steer_cmd_rad"], run.trace["speed_mps"]
    by_hand = np.trapezoid(4.0 * np.abs(delta) * v, run.trace["time_s"])
    assert run.trace["energy_steering_drag_j"][-1] == pytest.approx(by_hand, rel=5e-3)
    assert abs(run.residual) < 1e-9


def test_it_is_no_cause_unless_it_is_withheld_or_asked_for():
    log = simulate(car(), STRAIGHT, lanes=LaneChanges(8.0), output_rate=100.0).trace

    def named(vehicle, **asked):
        problem = Problem(vehicle, log, drive_of(log, vehicle))
        return {c.effect for c in candidates_for([problem], **asked)}

    assert "steering_drag" not in named(car()) | named(car(SCRUB))
    assert "steering_drag" in named(car(), withheld=["steering_drag"])
    assert named(car(), only=["steering_drag"]) == {"steering_drag"}


@pytest.mark.parametrize(
    ("follows", "asked", "may_be"),
    [
        ("steer_cmd_rad", (), ("steering_drag",)),
        ("steer_cmd_rad", ("steering_drag",), ()),
        ("speed_mps", (), ()),
    ],
)
def test_a_drag_that_follows_the_steering_may_be_it(follows, asked, may_be):
    found = SimpleNamespace(
        left=SimpleNamespace(is_real=True, acts_as="drag", follows=follows),
        asked=asked,
        asserted=(),
        vehicle=load_vehicle("rcc"),
    )
    assert Diagnosis.may_be.fget(found) == may_be
