"""The search for a strength begins beside what is stated, whatever that is."""

from math import isfinite

import pytest

from rcc_sim.definitions.vehicle import load_vehicle
from rcc_sim.diagnose.causes.sought import search_of
from rcc_sim.diagnose.residuals.posed import problem_of
from rcc_sim.physics.effects import EFFECTS
from tests import scaled_drive

CAR = load_vehicle("rcc")


@pytest.fixture(scope="module")
def problem(tmp_path_factory):
    folder = tmp_path_factory.mktemp("drive")
    log = scaled_drive.logged(scaled_drive.drive(CAR, None), CAR, 3, folder).log
    return problem_of(log, CAR)


SCALES = [
    (effect.id, param.name)
    for effect in EFFECTS.values()
    for param in effect.params
    if param.neutral == 1.0
]


@pytest.mark.parametrize(
    ("effect", "param"), SCALES, ids=lambda x: getattr(x, "name", x)
)
def test_a_factor_stated_as_what_is_tried_first_is_tried_elsewhere(
    problem, effect, param
):
    """Stated as 0.8 an efficiency of 0.7 was never found, stated as 0.81 it was."""
    known = EFFECTS[effect]
    plain = search_of(problem, known, known.param(param))
    others = {p.name: p.neutral for p in known.params if isfinite(p.neutral)}
    car = CAR.changed(effects={effect: others | {param: plain.first}})
    assert car.figures()[f"effects.{effect}.{param}"].value == plain.first
    search = search_of(problem_of(problem.log, car), known, known.param(param))
    assert search.neutral == plain.first
    assert abs(search.first - search.neutral) > 0.02
    assert search.low <= search.first <= search.high


def test_nothing_is_measured_late_in_a_drive_by_commands(problem):
    """A figure that may be less than nil was tried at nil alone, before all else."""
    every = [search_of(problem, e, p) for e in EFFECTS.values() for p in e.params]
    assert not [s.key for s in every if s.measured]
    assert any(s.low < 0 for s in every)
