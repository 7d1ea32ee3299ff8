"""What acts for a while after braking, or after a stop, is told by that."""

from types import SimpleNamespace

import numpy as np
import pytest

from rcc_sim.definitions.vehicle import load_vehicle
from rcc_sim.diagnose.fitting import descent
from rcc_sim.diagnose.fitting.engine import Engine
from rcc_sim.diagnose.fitting.knobs import nuisance_knobs
from rcc_sim.diagnose.profiles.remainder import remainder
from rcc_sim.diagnose.residuals.posed import problem_of
from rcc_sim.diagnose.residuals.problem import SINCE_BRAKING, SINCE_STANDING, Problem
from rcc_sim.trace import Trace

CAR = load_vehicle("tesla_model_3")
SIZES = {"battery_power_w": 300.0, "motor_torque_nm": 2.0}
STICKS = 20.0


def driven(event):
    """A drive with stops; a brake drags for a while after them, or after braking."""
    rng = np.random.default_rng(4)
    t = np.arange(0.0, 600.0, 0.1)
    v = np.clip(9 + 9 * np.sin(t / 11) + 5 * np.sin(t / 29), 0.0, None)
    free = problem_of(Trace({"time_s": t, "speed_mps": v}), CAR)
    more = CAR.figures()["effects.road_load.a_n"].value + 150.0
    seen, slowed = free.driven({}), free.driven({"effects.road_load.a_n": more})
    acts = free.since(getattr(free, event)) < np.log1p(STICKS)
    noisy = {
        c: np.where(acts, slowed[c], seen[c]) + size * rng.normal(size=len(t))
        for c, size in SIZES.items()
    }
    return problem_of(Trace({"time_s": t, "speed_mps": v} | noisy), CAR), acts


@pytest.mark.slow
@pytest.mark.parametrize(
    ("event", "follows"), [("standing", SINCE_STANDING), ("braking", SINCE_BRAKING)]
)
def test_a_brake_that_sticks_is_told_by_what_it_follows(event, follows):
    problem, acts = driven(event)
    engine = Engine([problem])
    left = remainder(engine, descent.fit(engine, {}, nuisance_knobs([problem])))
    assert left.is_real
    assert (left.acts_as, left.follows) == ("drag", follows)
    told = np.zeros(len(acts), dtype=bool)
    for window in left.windows:
        t = problem.log["time_s"]
        told |= (t >= window["start_s"]) & (t <= window["end_s"])
    assert (told & acts).sum() > 0.6 * (told | acts).sum()


def test_time_since_an_event_is_long_before_the_first_and_nil_while_it_lasts():
    event = np.array([False, True, True, False, False])
    one = SimpleNamespace(log={"time_s": np.array([0.0, 1.0, 2.0, 3.0, 7.0])})
    since = np.expm1(Problem.since(one, event))
    assert since == pytest.approx([7.0, 0.0, 0.0, 1.0, 5.0])


def test_a_drive_that_begins_at_rest_has_not_stopped_yet():
    speed = np.array([0.0, 0.0, 5.0, 9.0, 0.05, 0.0, 4.0])
    standing = Problem.standing.func(SimpleNamespace(speed=speed))
    assert standing.tolist() == [False] * 4 + [True, True, False]
