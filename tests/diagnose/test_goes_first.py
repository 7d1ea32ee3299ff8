"""A drag goes before a hill that has taken it in, if both then explain more."""

from types import SimpleNamespace

import numpy as np
import pytest

from rcc_sim.diagnose.causes.cause import Cause
from rcc_sim.diagnose.search import taken

SLOPE = {0: SimpleNamespace(weighed=False)}
HILL = Cause("road_grade", (), 600.0, profiles=SLOPE, shares=np.array([0.5, 0.5]))
DRAG = Cause("drivetrain_damping", (), 480.0, shares=np.array([0.6, 0.4]))


def asked(monkeypatch, rest, one=DRAG, scored=480.0):
    """Ask with a drag that scores so much more, and a rest of the hill beside it."""
    fits = SimpleNamespace(values={}, knobs=(), noise=None, score=scored)
    engine = SimpleNamespace(judged=lambda fit, noise: fit)
    hill = Cause("road_grade", (), rest) if rest else None
    monkeypatch.setattr(taken, "fitted", lambda *args: fits)
    monkeypatch.setattr(taken, "profile_cause", lambda *args: (hill, set()))
    before = SimpleNamespace(noise=None, score=0.0)
    best = SimpleNamespace(fit=fits)
    return taken.before_profile(engine, before, best, one, HILL) is fits


@pytest.mark.parametrize(("rest", "first"), [(260.0, True), (150.0, False), (0, False)])
def test_both_together_must_gain_what_any_further_cause_must(monkeypatch, rest, first):
    """600 nats of a hill ask for 60 of what acts beside it in the same tracks."""
    assert asked(monkeypatch, rest) is first


def test_the_same_effect_as_a_constant_never_does(monkeypatch):
    constant = Cause("road_grade", (), 480.0, shares=HILL.shares)
    assert not asked(monkeypatch, 500.0, one=constant)


def test_one_that_gains_less_than_a_further_cause_must_is_not_tried(monkeypatch):
    weak = Cause("drivetrain_damping", (), 30.0, shares=HILL.shares)
    assert not asked(monkeypatch, 900.0, one=weak)
