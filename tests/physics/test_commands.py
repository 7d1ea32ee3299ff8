"""A command that leaps comes with its row, whatever the last digit of its stamp."""

from dataclasses import replace

import numpy as np
import pytest

from rcc_sim.physics.tables import BEFORE, LINE, SINCE, command_at
from rcc_sim.simulate.drive import drive_of
from rcc_sim.simulate.replay import replay
from rcc_sim.trace import Trace
from tests import one_loop
from tests.cars import car

XS, YS = np.array([0.0, 1.0, 2.0, 3.0]), np.array([5.0, 6.0, 8.0, 7.0])
NEAR = 1e-3


@pytest.mark.parametrize("off", [-1e-15, 0.0, 1e-15])
@pytest.mark.parametrize("how", [LINE, SINCE, BEFORE])
def test_at_a_row_it_is_the_rows_own_or_the_next_where_that_acts_until_its_row(
    how, off
):
    due = [*YS[1:], YS[-1]] if how == BEFORE else YS
    for k, y in enumerate(due):
        value, i = command_at(XS[k] + off, XS, YS, 0, how, NEAR)
        assert value == pytest.approx(y, abs=1e-12)
        assert i <= len(XS) - 2


@pytest.mark.parametrize(("how", "due"), [(LINE, 7.0), (SINCE, 6.0), (BEFORE, 8.0)])
def test_between_rows_it_is_the_last_the_next_or_in_between(how, due):
    assert command_at(1.5, XS, YS, 0, how, NEAR) == (due, 1)


@pytest.mark.parametrize("how", [LINE, SINCE, BEFORE])
def test_beyond_the_ends_they_hold(how):
    assert command_at(-1.0, XS, YS, 0, how, NEAR)[0] == 5.0
    assert command_at(9.0, XS, YS, 0, how, NEAR)[0] == 7.0


@pytest.mark.parametrize("how", [SINCE, BEFORE])
def test_stamps_that_were_summed_command_as_those_that_were_counted(how):
    """A tick later in every other row, a stiff loop's current would be amperes off."""
    vehicle = car().changed(settings=one_loop.STIFF)
    n = 500
    counted = 0.02 * np.arange(n)
    summed = np.cumsum(np.r_[0.0, np.full(n - 1, 0.02)])
    assert 0 < np.abs(counted - summed).max() < 1e-12
    flows = []
    for time in (counted, summed):
        log = Trace({"time_s": time, "speed_ref_mps": one_loop.wanted(counted)})
        drive = replace(drive_of(log, vehicle, np.inf), held=(how, LINE))
        flows.append(replay(vehicle, drive)["motor_current_a"])
    assert np.ptp(flows[0]) > 5.0
    np.testing.assert_allclose(flows[1], flows[0], atol=1e-6)
