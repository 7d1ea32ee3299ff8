"""Intervals of effects that surely act do not hold their absence."""

from math import inf

import numpy as np
import pytest

from rcc_sim.analyse.logged import open_log
from rcc_sim.diagnose.causes.cause import Cause
from rcc_sim.diagnose.fitting import descent
from rcc_sim.diagnose.fitting.engine import Engine
from rcc_sim.diagnose.fitting.fit import Fit
from rcc_sim.diagnose.fitting.knobs import Knob
from rcc_sim.diagnose.judge.apart_from_nil import apart_from_nil
from rcc_sim.diagnose.judge.asserted import Asserted, Estimate, may_be_nil
from rcc_sim.diagnose.residuals.posed import problem_of
from rcc_sim.physics.effects import EFFECTS
from rcc_sim.simulate.drive import drive_of
from rcc_sim.simulate.replay import replay
from rcc_sim.trace import Trace
from tests.cars import car

PLAY, ASKED = 0.2, 0.08  # rad: it takes up all that is asked
KEY = "effects.steering_backlash.width_rad"
NOISE = {"speed_mps": 0.005, "yaw_rate_radps": 0.02}


@pytest.fixture(scope="module")
def engine(tmp_path_factory):
    """A drive whose steering never comes through."""
    true = car({"steering_backlash": {"width_rad": PLAY}})
    t = np.arange(0, 40, 0.02)
    asked = {
        "time_s": t,
        "speed_ref_mps": np.clip(t, 0.0, 2.5),
        "steer_cmd_rad": ASKED * np.sin(1.3 * t),
    }
    blank = Trace(asked | {"speed_mps": np.full(len(t), np.nan)})
    out = replay(true, drive_of(blank, true))
    assert np.abs(out["yaw_rate_radps"]).max() == 0.0
    rng = np.random.default_rng(7)
    seen = {c: out[c] + sd * rng.normal(size=len(t)) for c, sd in NOISE.items()}
    path = tmp_path_factory.mktemp("play") / "log.csv"
    rows, names = np.column_stack([*asked.values(), *seen.values()]), [*asked, *seen]
    np.savetxt(path, rows, delimiter=",", header=",".join(names), comments="")
    return Engine([problem_of(open_log(path, car()).log, car())])


def told(engine, value, chance=0.99):
    """Return the width of a play that is told as anything, once it is looked at."""
    null = descent.of_tolerances(engine)
    knob = Knob(KEY, value, inf, 0.0, 0.5, 0.005)
    fit = descent.fit(engine, null.values | {KEY: value}, (*null.knobs, knob))
    any_width = Estimate(fit.values[KEY], 0.0, 0.5, 0.3)
    cause = Cause("steering_backlash", (KEY,), 100.0)
    one = Asserted(cause, chance, {"width_rad": any_width})
    (found,) = apart_from_nil(engine, fit, [one])
    return found.figures["width_rad"]


def test_a_play_that_takes_up_all_steering_has_a_least_width(engine):
    """Any play of twice what is asked, or more, does the same; none does not."""
    width = told(engine, 0.3)
    assert 1.5 * ASKED < width.low <= 2 * ASKED + 0.01
    assert width.low < width.value < width.high == 0.5


def test_what_is_no_likelier_than_not_stays_as_it_is(engine):
    assert told(engine, 0.3, 0.5).low == 0.0


@pytest.mark.parametrize(
    ("key", "value", "sd", "nil"),
    [
        ("effects.steering_offset.angle_rad", 0.001, 0.002, True),
        ("effects.steering_offset.angle_rad", 0.01, 0.002, False),
        ("effects.steering_gain.gain", 1.02, 0.05, True),
        ("effects.regeneration_limit.max_torque_nm", 0.04, 0.2, False),
    ],
)
def test_it_may_be_nil_where_the_effect_vanishes_and_a_limit_of_nil_does_all(
    key, value, sd, nil
):
    """A motor that may not brake at all has a limit of 0, and no limit is infinite."""
    knob = Knob(key, value, inf, -inf if "offset" in key else 0.0, inf)
    fit = Fit({key: value}, (knob,), 0.0, 0.0, [], [], np.array([[sd**-2]]))
    cause = Cause(key.split(".")[1], (key,), 100.0)
    assert may_be_nil(fit, cause, {}, 0.01, EFFECTS) is nil
