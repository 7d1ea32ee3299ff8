"""What does not shrink on rows that no fit saw is explained in part alone."""

import pytest

from rcc_sim.diagnose.cause import Cause
from rcc_sim.diagnose.remainder import UNKNOWN_ENOUGH, Remainder
from rcc_sim.diagnose.verdict import status_of

CAUSE = Cause("payload", ("effects.payload.mass_kg",), 50.0)
NOTHING = Remainder(0.0, "drag", "", [])
SOMETHING = Remainder(UNKNOWN_ENOUGH + 1, "drag", "", [])


@pytest.mark.parametrize(
    ("before", "after", "status"),
    [
        (69.6, 27.0, "partly_explained"),
        (69.6, -27.0, "partly_explained"),
        (69.6, 20.0, "explained"),
        (1.2, 1.4, "explained"),
        (-40.0, 3.0, "explained"),
        (None, None, "explained"),
    ],
)
def test_the_energy_gap_has_to_shrink_to_a_third(before, after, status):
    assert status_of([CAUSE], NOTHING, before, after) == status


def test_what_is_left_decides_where_nothing_is_named():
    assert status_of([], NOTHING, 50.0, 50.0) == "no_gap"
    assert status_of([], SOMETHING) == "unexplained"
    assert status_of([CAUSE], SOMETHING, 50.0, 1.0) == "partly_explained"
