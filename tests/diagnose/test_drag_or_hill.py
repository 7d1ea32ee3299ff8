"""A drag that comes and goes with time may be taken for a hill: how sure is it then?"""

from types import SimpleNamespace

import numpy as np
import pytest

from rcc_sim.diagnose.cause import Cause
from rcc_sim.diagnose.compete import beside_a_drag
from rcc_sim.diagnose.remainder import Remainder
from rcc_sim.diagnose.verdict import probability
from rcc_sim.report.doubts import is_a_drag_as_well

SLOPE = {0: SimpleNamespace(weighed=False)}
NOTHING = Remainder(0.0, "", "", [])


def hill(effect="road_grade", drag=0.0, other=0.0):
    """A hill of 180 nats, and what would be in its place."""
    shares = np.array([1.0])
    rivals = (
        Remainder(drag, "drag", "time_s", [], shares=shares),
        Remainder(other, "drag", "speed_mps", [], shares=shares),
    )
    left = Remainder(drag, "drag", "time_s", [], shares=shares, rivals=rivals)
    one = Cause(effect, (), 180.0, profiles=SLOPE, shares=shares)
    return beside_a_drag(one, left)


@pytest.mark.parametrize(
    ("drag", "least", "most"), [(180.0, 0.5, 0.5), (250.0, 0.5, 0.5),
                                (167.0, 0.9, 0.97), (100.0, 0.99, 1.0)],
)  # fmt: skip
def test_it_is_as_sure_as_it_is_likelier_than_the_drag(drag, least, most):
    chance = probability(hill(drag=drag), NOTHING)
    assert least <= chance <= most
    told = SimpleNamespace(cause=hill(drag=drag), probability=chance)
    assert is_a_drag_as_well(told) == (chance < 0.9)


def test_what_follows_the_speed_and_other_causes_are_no_matter():
    assert probability(hill(other=250.0), NOTHING) > 0.99
    assert hill("auxiliary_load", drag=250.0).rival == 0.0
