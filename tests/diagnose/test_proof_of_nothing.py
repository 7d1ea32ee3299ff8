"""A proof can fail: a fit without the cause that acts closes nothing."""

from dataclasses import replace

import numpy as np
import pytest

from rcc_sim.definitions.vehicle import load_vehicle
from rcc_sim.diagnose.causes.candidates import candidates_for
from rcc_sim.diagnose.fitting.engine import Engine
from rcc_sim.diagnose.proof.folds import halves
from rcc_sim.diagnose.proof.shrink import Shrink, hold_out
from rcc_sim.diagnose.residuals.posed import problem_of
from rcc_sim.diagnose.search.compete import compete
from tests import scaled_drive

CAR = load_vehicle("rcc")
LOAD = "effects.auxiliary_load.power_w"


@pytest.fixture(scope="module")
def competed(tmp_path_factory):
    """A drive with 2 W more than the file has, and what the competition made of it."""
    true = CAR.changed(effects={"auxiliary_load": {"power_w": 6.0}})
    folder = tmp_path_factory.mktemp("drive")
    log = scaled_drive.logged(scaled_drive.drive(true, None), CAR, 3, folder).log
    engine = Engine([problem_of(log, CAR)])
    able = candidates_for(engine.problems, ("auxiliary_load",))
    return engine, compete(engine, able)


def shrink(engine, fit, null):
    return hold_out(engine, engine, fit, *halves((engine, fit), (engine, null)))


def test_stated_figures_alone_close_nothing(competed):
    engine, found = competed
    none = shrink(engine, found.null, found.null)
    assert none.explained < 0.3
    assert none.nats == 0.0 and none.may_be_none
    mended = shrink(engine, found.fit, found.null)
    assert mended.explained > 0.9
    assert mended.nats > 100 and not mended.may_be_none


def test_a_cause_of_the_wrong_size_is_told(competed):
    """Three times as much as acts leaves four times the squares."""
    engine, found = competed
    stated = engine.stated(LOAD)
    wrong = stated + 3 * (found.fit.values[LOAD] - stated)
    fit = engine.evaluate(
        {**found.fit.values, LOAD: wrong}, found.fit.knobs, found.fit.noise
    )
    fit = replace(fit, signals=found.fit.signals, information=found.fit.information)
    (none,) = halves((engine, found.null))
    told = hold_out(engine, engine, fit, [(fit, rows) for _, rows in none], none)
    assert told.explained == -1.0 and told.after > 2 * told.before
    assert np.isfinite(told.nats) and told.nats < 0


@pytest.mark.parametrize(
    ("low", "high", "nats", "nil"),
    [
        (0.3, 0.9, 40.0, False),
        (-0.2, 0.3, 40.0, True),  # hardly anything is gone
        (-1.0, 1.0, 40.0, False),  # too little is beyond noise to tell
        (0.3, 0.9, -1.0, True),
    ],
)
def test_a_cause_that_may_do_nothing_on_rows_held_out_is_told(low, high, nats, nil):
    assert Shrink(0.1, 0.05, 0.5, low, high, nats).may_be_none is nil
