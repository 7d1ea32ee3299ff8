"""What acts in bends alone is no friction: it changes with the steering."""

import numpy as np
import pytest

from rcc_sim.definitions.vehicle import load_vehicle
from rcc_sim.diagnose.fitting import descent
from rcc_sim.diagnose.fitting.engine import Engine
from rcc_sim.diagnose.fitting.knobs import Knob, nuisance_knobs
from rcc_sim.diagnose.profiles.remainder import (
    EXACT,
    UNKNOWN_ENOUGH,
    inexactness,
    remainder,
)
from rcc_sim.diagnose.residuals.posed import problem_of
from rcc_sim.trace import Trace
from tests.winding import seen_of, winding

CAR = load_vehicle("r1t")
FRICTION = "effects.drivetrain_friction.torque_nm"
SIZES = {"battery_power_w": 300.0, "motor_torque_nm": 2.0}
TORQUE, RUBS_FROM = 6.0, 0.015


def fitted(acts_at):
    """A drive in bends with friction where it acts, and a fit that takes it as even."""
    rng = np.random.default_rng(3)
    given = winding()
    free = problem_of(Trace(given), CAR)
    seen = free.driven({})
    slowed = free.driven({FRICTION: TORQUE})
    acts = acts_at(given["steer_cmd_rad"])
    noisy = seen_of(seen, slowed, acts, SIZES, rng)
    problem = problem_of(Trace(given | noisy), CAR)
    engine = Engine([problem])
    knobs = [*nuisance_knobs([problem]), Knob(FRICTION, 0.0, low=0.0, high=50.0)]
    return engine, descent.fit(engine, {FRICTION: 0.5 * TORQUE}, knobs)


@pytest.mark.slow
def test_a_friction_that_rubs_in_bends_changes_with_the_steering():
    engine, fit = fitted(lambda steer: np.abs(steer) > RUBS_FROM)
    left = remainder(engine, fit, {"drivetrain_friction": (FRICTION,)})
    assert left.change_of("drivetrain_friction") > UNKNOWN_ENOUGH
    followed = {r.follows for r in left.rivals if r.acts_as == "drivetrain_friction"}
    assert "steer_cmd_rad" in followed


@pytest.mark.slow
def test_a_friction_that_acts_everywhere_changes_with_nothing():
    engine, fit = fitted(lambda steer: np.ones(len(steer), dtype=bool))
    assert fit.values[FRICTION] == pytest.approx(TORQUE, rel=0.1)
    left = remainder(engine, fit, {"drivetrain_friction": (FRICTION,)})
    assert not left.is_real
    assert left.change_of("drivetrain_friction") < 0.25 * UNKNOWN_ENOUGH


def test_what_a_model_may_leave_grows_with_the_log():
    """White noise of size 300 W, and its closed form."""
    rng = np.random.default_rng(1)

    def of(seconds):
        t = np.arange(0.0, seconds, 0.1)
        given = {"time_s": t, "speed_mps": 14 + 3 * np.sin(t / 9)}
        power = problem_of(Trace(given), CAR).driven({})["battery_power_w"]
        noisy = power + 300.0 * rng.normal(size=len(t))
        engine = Engine([problem_of(Trace(given | {"battery_power_w": noisy}), CAR)])
        fit = descent.fit(engine, {}, nuisance_knobs(engine.problems))
        return float(inexactness(engine, fit)[0]), power

    short, _ = of(200.0)
    long, power = of(800.0)
    closed = 0.5 * EXACT**2 * len(power) * power.var() / 300.0**2
    assert closed < long < 1.5 * closed  # the t-distribution's scale is the smaller one
    assert long == pytest.approx(4 * short, rel=0.2)
