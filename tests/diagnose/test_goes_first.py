"""A drag goes before a hill, or a load, that has taken it in, if both explain more."""

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


def hidden(monkeypatch, other, varying="auxiliary_load", needs=40.0):
    """Ask which constant cause a load that varies may have taken in.

    Beside the load as a constant, which gains 700 nats, another gains so many.
    """

    def refined(effect, gain):
        return SimpleNamespace(
            screened=SimpleNamespace(candidate=SimpleNamespace(effect=effect)),
            gain=gain,
            trusted=gain,
            reaches=lambda needed: gain >= needed,
        )

    both = [refined("auxiliary_load", 700.0), refined("drivetrain_damping", other)]
    monkeypatch.setattr(taken, "cause_of", lambda e, r, noise: as_cause(r))
    monkeypatch.setattr(taken, "needed_gain", lambda causes, shares: needs)
    look = SimpleNamespace(refined=both, fit=SimpleNamespace(noise=None))
    now = taken.Taken(None, None, (), print)
    course = Cause(varying, (), 800.0, profiles=SLOPE)
    _, one = now.hidden_by(course, look, both[0], as_cause(both[0]))
    return one.effect


def as_cause(refined):
    return Cause(refined.screened.candidate.effect, (), refined.gain)


def test_a_load_over_time_may_have_taken_in_a_drag_that_comes_near_it(monkeypatch):
    assert hidden(monkeypatch, 500.0) == "drivetrain_damping"


def test_not_one_that_is_far_behind_or_gains_too_little_itself(monkeypatch):
    assert hidden(monkeypatch, 300.0) == "auxiliary_load"
    assert hidden(monkeypatch, 500.0, needs=600.0) == "auxiliary_load"


def test_a_hill_may_have_taken_in_the_best_whatever_it_is(monkeypatch):
    assert hidden(monkeypatch, 500.0, varying="road_grade") == "auxiliary_load"
