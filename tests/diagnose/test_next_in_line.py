"""What varies and does not stand leaves its place to what varies elsewhere."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np

from rcc_sim.diagnose.causes.cause import Cause
from rcc_sim.diagnose.profiles.remainder import UNKNOWN_ENOUGH, Remainder
from rcc_sim.diagnose.search import compete, taken
from rcc_sim.diagnose.search.look import Look

WIND = Cause("headwind", ("w",), 180.0, profiles={0: None})
LOAD = Cause("auxiliary_load", ("l",), 80.0, profiles={0: None})


def test_a_load_is_tried_where_a_wind_fits_better_and_does_not_stand(monkeypatch):
    asked = []

    def profile_cause(engine, fit, named, constant):
        asked.append(frozenset(named))
        return next((c for c in (WIND, LOAD) if c.effect in named), None), set()

    said = {
        "woken": lambda engine, null: null,
        "read_late": lambda *_: None,
        "looked": lambda engine, fit, *_: Look(fit, [], [], None, None),
        "coupled": lambda *_: [],
        "profile_cause": profile_cause,
        "is_clear": lambda *_: True,
        "remainder": lambda *_: Remainder(0.0, "", "", []),
        "stands_out": lambda varying, left: varying.effect == LOAD.effect,
        "acting": lambda engine, fit, causes, one: (engine, fit, [*causes, one]),
        "may_blow": lambda one: True,
        "is_another": lambda fit: False,
        "outweighed": lambda *_: False,
        "without_outdone": lambda *same: same,
        "without_idle": lambda engine, causes, fit: (engine, causes, fit),
        "hills_beside_all": lambda engine, fit, causes: (engine, fit, causes),
        "one_alone": lambda engine, causes, fit, close: (causes, fit),
    }
    for name, do in said.items():
        there = taken if hasattr(taken, name) else compete
        monkeypatch.setattr(there, name, do)
    able = [
        SimpleNamespace(
            effect=c.effect, several=False, searches=[SimpleNamespace(key=c)]
        )
        for c in (WIND, LOAD)
    ]
    found = compete.compete(SimpleNamespace(problems=[]), able, null=object())
    assert found.causes == (LOAD,)
    assert [WIND.effect in names for names in asked] == [True, False, False]


def test_a_loads_own_coming_and_going_does_not_speak_against_it():
    def left(acts):
        return Remainder(UNKNOWN_ENOUGH + 1, acts, "time_s", [], shares=np.ones(1))

    rivals = tuple(map(left, ("auxiliary_load", "power")))
    own = replace(left("power"), rivals=rivals)
    assert own.against("auxiliary_load", np.ones(1)) == 0.0
    assert own.against("payload", np.ones(1)) > UNKNOWN_ENOUGH


def test_another_causes_own_coming_and_going_speaks_against_it():
    """As it does not vary; an efficiency does not, where the cause stands beside it."""

    def left(acts, nats):
        return Remainder(UNKNOWN_ENOUGH + nats, acts, "time_s", [], shares=np.ones(1))

    rivals = (left("rolling_resistance", 2), left("efficiency", 3))
    own = replace(rivals[1], rivals=rivals)
    against = own.against("rolling_resistance", np.ones(1))
    assert against == UNKNOWN_ENOUGH + 3
    beside = replace(own, apart=frozenset({"rolling_resistance"}))
    assert beside.against("rolling_resistance", np.ones(1)) == UNKNOWN_ENOUGH + 2
