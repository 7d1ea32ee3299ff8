"""A stiff car that is told its speed ten times a second: currents come all at once."""

from dataclasses import replace
from math import inf

import numpy as np
import pytest

from rcc_sim.analyse.logged import Logged
from rcc_sim.analyse.sampled import SAMPLE
from rcc_sim.definitions.vehicle import load_vehicle
from rcc_sim.diagnose.fitting.engine import Engine
from rcc_sim.diagnose.residuals.posed import problem_of
from rcc_sim.diagnose.run import diagnose
from rcc_sim.diagnose.search.ways import kept_alike
from rcc_sim.physics.tables import LINE, SINCE
from rcc_sim.trace import Trace
from tests import one_loop

ASKED = (
    *("sensor_delay", "reference_delay", "motor_lag"),
    *("speed_loop", "copper_loss", "rolling_resistance"),
)
"""What was named, or may be."""

CAR = load_vehicle("rcc").changed(settings=one_loop.STIFF)


def found(true, jitter):
    log = Trace(one_loop.rows(true, 0.1, jitter, 30.0, seed=5), name="log")
    return diagnose([Logged(log, (), None)], CAR, candidates=ASKED)


@pytest.mark.parametrize("jitter", [pytest.param(0.0, marks=pytest.mark.thorough), 0.1])
def test_nothing_wrong_is_no_gap(jitter):
    """Beside references that run straight its currents looked like samples.

    And what it feels is none, beside them: it comes all at once and is over by the row.
    """
    told = found(CAR, jitter)
    assert told.status == "no_gap" and not told.asserted


def test_a_drag_is_found_alone():
    (cause,) = found(
        CAR.changed(settings={"effects.rolling_resistance.coefficient": 0.022}), 0.1
    ).asserted
    named = {cause.cause.effect, *cause.cause.tied}
    assert "rolling_resistance" in named and cause.probability > 0.9


def test_a_log_that_was_kept_back_has_means_where_the_others_have():
    """Ten rows a second tell by themselves that currents are samples."""
    told = Trace(one_loop.rows(CAR, 0.1, 0.0, 30.0, seed=5), name="log")
    problem = problem_of(told, CAR)
    assert problem.drive.window == SAMPLE
    drive = replace(problem.drive, held=(SINCE, SINCE), window=inf)
    means = replace(problem, drive=drive)
    (kept,) = kept_alike([problem], Engine([means]))
    assert (kept.drive.held, kept.drive.window) == ((SINCE, SINCE), inf)
    (as_it_is,) = kept_alike([problem], Engine([problem]))
    assert as_it_is.drive.window == SAMPLE


def test_accelerometers_may_be_samples_beside_currents_that_are_means():
    told = Trace(one_loop.rows(CAR, 0.1, 0.1, 30.0, seed=5), name="log")
    problem = problem_of(told, CAR)

    def seen(window, felt=inf):
        drive = replace(problem.drive, held=(SINCE, LINE), window=window, felt=felt)
        return replace(problem, drive=drive).driven({})

    both, means, samples = seen(inf, SAMPLE), seen(inf), seen(SAMPLE)
    for flow in ("motor_current_a", "battery_power_w", "battery_voltage_v"):
        np.testing.assert_array_equal(both[flow], means[flow])
    # the tick under way at a sample's beginning is not cut
    off = np.abs(both["accel_x_mps2"] - samples["accel_x_mps2"]).max()
    assert off < 0.1 < np.abs(means["accel_x_mps2"] - samples["accel_x_mps2"]).max()
