"""A load is named where it is likelier than a drag of the same course, and not else."""

from types import SimpleNamespace

import numpy as np
import pytest

from rcc_sim.diagnose.causes.cause import ENOUGH, Cause
from rcc_sim.diagnose.causes.profile import Profile
from rcc_sim.diagnose.profiles import varying

NAMED = {"auxiliary_load", "road_grade"}
FIT = SimpleNamespace(knobs=())
ENGINE = SimpleNamespace()
STEPS = Profile("key", "time_s", np.arange(2.0), np.ones(2), np.ones(2), 90.0)


def profile(effect, gain, **more):
    return Cause(effect, ("key",), gain, profiles={0: STEPS}, **more)


@pytest.fixture
def found(monkeypatch):
    """What is found where smooth profiles gain 90 and 70, and a course as it says."""

    def of(load, drag):
        smooth = {"auxiliary_load": 90.0, "road_grade": 70.0}
        monkeypatch.setattr(
            varying, "as_profile", lambda e, f, name: profile(name, smooth[name])
        )
        course = profile("auxiliary_load", 10.0, sharpened=load / 10, rival=drag)
        monkeypatch.setattr(varying, "beside_noise", lambda e, f, hidden: course)
        monkeypatch.setattr(varying, "is_stated", lambda e, c: False)
        monkeypatch.setattr(varying, "with_its_noise", lambda e, f, c: 100.0)
        return varying.profile_cause(ENGINE, FIT, NAMED)

    return of


def test_a_course_that_beats_its_drag_and_every_smooth_profile_is_taken(found):
    cause, outdone = found(200.0, 50.0)
    assert (cause.effect, cause.sharpened, cause.rival) == ("auxiliary_load", 20, 100)
    assert not outdone


def test_a_course_that_does_not_leaves_it_to_the_smooth_profiles(found):
    cause, outdone = found(200.0, 200.0)
    assert (cause.effect, cause.gain, cause.rival) == ("auxiliary_load", 90, 70)
    assert not outdone


def test_where_a_drag_of_its_course_is_likelier_no_load_is_named(found):
    cause, outdone = found(200.0, 201.0 + ENOUGH)
    assert cause.effect == "road_grade" and outdone == {"auxiliary_load"}
