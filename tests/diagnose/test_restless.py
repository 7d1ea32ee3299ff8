"""A cause is doubtful where what it leaves of its own channels still comes and goes."""

from types import SimpleNamespace

import numpy as np
import pytest
from scipy.signal import lfilter

from rcc_sim.diagnose.causes.cause import Cause
from rcc_sim.diagnose.judge.restless import (
    coming_and_going,
    is_doubtful,
    restless,
    unaccounted,
)

ROW, ROWS = 0.01, 7500
TIME = ROW * np.arange(ROWS)
NOISE = np.random.default_rng(7).normal(size=ROWS)
STICKS = np.sign(np.sin(np.pi * TIME / 4))  # on for 4 s, off for 4 s


def filtered(lag):
    """The noise behind a first-order filter, of unit size."""
    kept = np.exp(-ROW / lag)
    return lfilter([np.sqrt(1 - kept**2)], [1, -kept], NOISE)


def engine_of(*channels, row=ROW, rows=ROWS, imposed=False):
    """Channels of one log, of which all rows count."""
    drive = SimpleNamespace(imposed=imposed)
    return SimpleNamespace(
        tracks=[(0, c) for c in channels],
        valid=[np.ones(rows, bool) for _ in channels],
        least=[0.1 for _ in channels],
        problems=[SimpleNamespace(row=row, drive=drive)],
    )


def wanders(left, before):
    engine = engine_of("speed_mps", rows=len(left))
    fit, null = (SimpleNamespace(residuals=[e]) for e in (left, before))
    return bool(restless(engine, fit, null)[0])


@pytest.mark.parametrize(
    ("left", "told"),
    [
        (NOISE, False),
        (filtered(0.05), False),  # 3.3 times its scatter, and gone half a second later
        (filtered(0.2), False),
        (NOISE + 1.0 * STICKS, False),  # 1.4 times its scatter
        (NOISE + 2.5 * STICKS, True),
        (filtered(4.0), True),
    ],
)
def test_what_comes_and_goes_is_told_from_noise_that_a_sensor_filters(left, told):
    assert wanders(left, left + 1.0) is told


@pytest.mark.parametrize(("taken_out", "told"), [(2.0, True), (50.0, False)])
def test_an_error_small_beside_what_a_cause_explains_is_none(taken_out, told):
    left = NOISE + 2.5 * STICKS
    assert wanders(left, left + taken_out) is told


def test_what_is_less_than_the_least_noise_is_none():
    """As a simulated log leaves of figures that are a little otherwise."""
    assert not wanders(0.05 * STICKS, 0.05 * STICKS)
    assert wanders(0.5 * STICKS, 0.5 * STICKS)


def test_rows_that_do_not_count_are_not_asked():
    left = NOISE.copy()
    left[2000:4000] = np.nan
    engine = engine_of("speed_mps")
    engine.valid[0][2000:4000] = False
    fit = SimpleNamespace(residuals=[left])
    assert not restless(engine, fit, fit).any()
    fit.residuals[0] = left + 3 * STICKS
    assert restless(engine, fit, fit).all()


def test_a_cause_is_doubtful_that_shows_in_such_channels_above_all():
    loose = np.array([True, False, True])
    friction = Cause(
        "drivetrain_friction", ("x",), 90.0, shares=np.array([0.1, 0.3, 0.6])
    )
    lag = Cause("steering_lag", ("y",), 90.0, shares=np.array([0.2, 0.8, 0.0]))
    assert is_doubtful(friction, loose)
    assert not is_doubtful(lag, loose)
    assert not is_doubtful(Cause("payload", ("z",), 90.0), loose)
    engine = engine_of("speed_mps", "yaw_rate_radps", "motor_current_a")
    (said,) = coming_and_going(engine, [friction, lag], loose, 0)
    assert said.channel == "speed_mps"
    assert "beside drivetrain_friction, " in said.what
    assert said.what.endswith("so does motor_current_a")
    assert not coming_and_going(engine, [lag], loose, 0)
    assert not coming_and_going(engine, [friction], loose, 1)


def test_without_a_cause_it_counts_as_well():
    loose = np.array([True, False])
    assert unaccounted([], loose).tolist() == [True, False]
    (said,) = coming_and_going(engine_of("speed_mps", "yaw_rate_radps"), [], loose, 0)
    assert said.what.startswith("comes and goes, more than")


def test_a_vehicle_that_is_driven_by_its_motion_shows_the_road():
    fit = SimpleNamespace(residuals=[NOISE + 3 * STICKS])
    for imposed in (False, True):
        engine = engine_of("battery_power_w", imposed=imposed)
        assert restless(engine, fit, fit).tolist() == [not imposed]
