"""One cause stands in the place of several where it does as well alone."""

from types import SimpleNamespace

import numpy as np
import pytest

from rcc_sim.diagnose.causes.cause import ENOUGH, Cause
from rcc_sim.diagnose.fitting import descent
from rcc_sim.diagnose.fitting.knobs import Knob
from rcc_sim.diagnose.search.leave_out import one_alone
from rcc_sim.diagnose.search.refine import Refined

DRAG = Cause("aerodynamic_drag", ("effects.aerodynamic_drag.drag_area_m2",), 186.0)
FRICTION = Cause("drivetrain_friction", ("effects.drivetrain_friction.torque_nm",), 15)
DAMPING = "effects.drivetrain_damping.damping_nms_per_rad"


def fitted(score):
    return SimpleNamespace(
        score=score,
        values={DAMPING: 0.02},
        knobs=(Knob(DAMPING, 0.02),),
        noise=[lambda e: e],
        signals=[[np.ones(9)]],
        residuals=[np.zeros(9)],
    )


def twin(score):
    candidate = SimpleNamespace(effect="drivetrain_damping")
    screened = SimpleNamespace(candidate=candidate, values={DAMPING: 0.02})
    return Refined(screened, fitted(score), 185.0, 185.0)


@pytest.mark.parametrize(("less", "names"), [(15.0, 1), (ENOUGH + 1, 2)])
def test_a_twin_of_the_first_takes_the_place_of_both(monkeypatch, less, names):
    monkeypatch.setattr(descent, "fit", lambda *_: fitted(1000.0 - less))
    both, fit = [DRAG, FRICTION], fitted(1000.0)
    engine = SimpleNamespace(residuals=lambda _: [np.ones(9)])
    causes, now = one_alone(engine, both, fit, [twin(985.0)])
    assert len(causes) == names
    assert (now is fit) == (names == 2)
    if names == 1:
        assert causes[0].effect == "drivetrain_damping"


def test_one_cause_stays_as_it_is():
    fit = fitted(1000.0)
    assert one_alone(None, [DRAG], fit, [twin(999.0)]) == ([DRAG], fit)
