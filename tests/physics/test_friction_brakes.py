"""Friction brakes that take a share of all braking, or what is left at low speed."""

import numpy as np
import pytest

from rcc_sim.definitions.cycle import Cycle
from rcc_sim.simulate.run import simulate
from tests.cars import car, truck

STOP = Cycle("stop", np.array([0.0, 8.0, 12.0, 22.0, 24.0]),
             np.array([0.0, 16.0, 16.0, 0.0, 0.0]))  # fmt: skip
DRAG = {"aerodynamic_drag": {"drag_area_m2": 1.0}}


def without_and_with(effects, *, imposed):
    """A stop without and with some effects, and the motor's torque in each."""
    how = {"imposed": imposed, "output_rate": 50.0}
    runs = [simulate(truck(DRAG | more), STOP, **how) for more in ({}, effects)]
    return *runs, *(run.trace["motor_torque_nm"] for run in runs)


@pytest.mark.parametrize("imposed", [True, False])
def test_a_share_of_each_braking_torque_is_not_the_motors(imposed):
    share = 0.3
    brake = {"friction_brake": {"share": share}}
    alone, run, before, after = without_and_with(brake, imposed=imposed)
    brakes = (before < -1.0) & (alone.trace["speed_mps"] > 1.0)
    assert brakes.sum() > 100
    assert after[brakes] == pytest.approx((1 - share) * before[brakes], rel=2e-3)
    assert np.array_equal(after[before > 1.0], before[before > 1.0]) or not imposed
    omega = alone.trace["motor_speed_radps"]
    taken = -share * np.trapezoid(np.minimum(before, 0) * omega, alone.trace["time_s"])
    lost = run.ledger["brakes"] - alone.ledger.get("brakes", 0.0)
    assert lost == pytest.approx(taken, rel=5e-3)
    assert abs(run.residual) < 1e-9


@pytest.mark.parametrize("imposed", [True, False])
def test_braking_by_the_motor_fades_from_a_speed_to_a_third_of_it(imposed):
    fade = 6.0
    fades = {"regeneration_fade": {"fade_speed_mps": fade}}
    alone, run, before, after = without_and_with(fades, imposed=imposed)
    v = alone.trace["speed_mps"]
    v = 0.5 * (v + np.roll(v, 1))  # a row's torque is its mean since the row before
    brakes = (before < -50.0) & (alone.trace["time_s"] > 12.5) & (v > 0.5)
    ramp = np.interp(v[brakes], [fade / 3, fade], [0.0, 1.0])
    assert (ramp == 0.0).any() and (ramp == 1.0).any()
    assert after[brakes] / before[brakes] == pytest.approx(ramp, abs=0.01)
    assert abs(run.residual) < 1e-9


def test_a_small_car_of_a_speed_loop_stops_alike_by_both():
    """What its motor may not brake of the loop's torque, its brakes do."""
    brakes = {"friction_brake": {"share": 0.4}}
    drag = {"rolling_resistance": {"coefficient": 0.02}}
    slow = Cycle("stop", STOP.time_s, 0.2 * STOP.speed_mps)
    alone, run = (simulate(car(drag | more), slow) for more in ({}, brakes))
    v, u = alone.trace["speed_mps"], run.trace["speed_mps"]
    assert u == pytest.approx(v, abs=1e-6)
    before = alone.trace["motor_current_a"]
    hard = before < -0.5
    assert hard.sum() > 50
    lighter = run.trace["motor_current_a"][hard] / before[hard]
    assert lighter == pytest.approx(0.6, abs=1e-3)
