"""What friction brakes take beside the motor is found, and told from a lossy gear.

The log is worked out by hand, not by the model.
"""

import numpy as np
import pytest

from rcc_sim.analyse.logged import Logged
from rcc_sim.diagnose.causes.sought import search_of
from rcc_sim.diagnose.residuals.posed import problem_of
from rcc_sim.diagnose.run import diagnose
from rcc_sim.physics.effects import EFFECTS
from rcc_sim.trace import Trace
from tests.by_hand import STATED, logged, shaft_torque
from tests.cars import truck


def log_of(kept, seed):
    """A drive in town; ``kept`` is the motor's share of a braking at its speeds."""
    rng = np.random.default_rng(seed)
    t = np.arange(0.0, 600.0, 0.1)
    v = 9.0 + 6.0 * np.sin(t / 9.0) + 4.5 * np.sin(t / 23.0) - 2.0 * np.cos(t / 5.0)
    v = np.where(v < 0.3, 0.0, v)
    v = np.convolve(np.pad(v, 10, mode="edge"), np.ones(21) / 21, mode="valid")
    torque = shaft_torque(t, v)
    torque = np.where(torque < 0, kept(v) * torque, torque)
    return Trace(logged(t, v, torque, rng, watts=150.0), name="town")


def named(log):
    found = diagnose([Logged(log, (), None)], truck(STATED))
    return {a.cause.effect: next(iter(a.figures.values())) for a in found.asserted}


@pytest.mark.parametrize(
    "torqued", [True, pytest.param(False, marks=pytest.mark.thorough)]
)
def test_brakes_that_take_a_share_are_named_and_no_gear(torqued):
    log = log_of(lambda v: 0.75 + 0 * v, 1)
    if not torqued:
        kept = {c: log[c] for c in log.columns if c != "motor_torque_nm"}
        log = Trace(kept, name="town")
    told = named(log)
    assert list(told) == ["friction_brake"]
    assert told["friction_brake"].value == pytest.approx(0.25, abs=0.015)


def test_regeneration_that_fades_is_named_though_it_fades_otherwise():
    """From 3 m/s on, and nil below 1.2: not at a third of where it begins."""
    told = named(log_of(lambda v: np.clip((v - 1.2) / 1.8, 0, 1), 2))
    assert list(told) == ["regeneration_fade"]
    assert 2.5 < told["regeneration_fade"].value < 3.6


def test_a_motor_that_does_all_braking_blames_no_brakes():
    assert named(log_of(lambda v: 1.0 + 0 * v, 3)) == {}


@pytest.mark.parametrize("row", [0.1, 1.0])
def test_no_fade_is_told_that_a_row_passes_at_once(row):
    t = np.arange(0.0, 450.0, row)
    v = np.clip(np.minimum(1.2 * (t % 45), 0.9 * (35 - t % 45)), 0.0, 12.0)
    log = Trace(logged(t, v, shaft_torque(t, v), np.random.default_rng(1)), name="town")
    fade = EFFECTS["regeneration_fade"]
    sought = search_of(problem_of(log, truck(STATED)), fade, fade.params[0])
    assert sought.weakest == pytest.approx(0.9 * row, abs=0.02)
