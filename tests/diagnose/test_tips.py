"""How well a figure is told where the slopes of a fit say too much of it."""

from types import SimpleNamespace

import numpy as np
import pytest

from rcc_sim.diagnose.fitting.knobs import Knob
from rcc_sim.diagnose.fitting.tips import wider_by

TRUE, KNOB = 0.02, Knob("x", 5.0)


def told(sd, tip=0.0, scatter=0.0):
    """By how much wider than ``sd`` it is told, of a parabola with a tip on top."""
    rng = np.random.default_rng(3)

    def at(fit, values):
        off = values["x"] - KNOB.value
        lost = 0.5 * (off / TRUE) ** 2
        lost += tip + scatter * rng.uniform(-1, 1) if off else 0.0
        return SimpleNamespace(score=-lost)

    engine = SimpleNamespace(at=at)
    fit = SimpleNamespace(values={"x": KNOB.value}, knobs=(KNOB,), noise=[], score=0.0)
    return sd * wider_by(engine, fit, KNOB, sd)


def test_a_parabola_is_told_by_its_width():
    assert told(TRUE) == pytest.approx(TRUE)
    assert told(0.3 * TRUE) == pytest.approx(TRUE)


def test_it_is_never_told_better_than_its_slopes_say():
    assert told(3 * TRUE) == pytest.approx(3 * TRUE)


def test_slopes_that_are_a_million_times_too_steep_make_it_no_surer():
    assert told(1e-6 * TRUE) == pytest.approx(TRUE, rel=0.01)


def test_a_tip_on_top_does_not_count():
    assert told(1e-6 * TRUE, tip=30.0) == pytest.approx(TRUE, rel=0.05)


def test_nor_where_the_slopes_are_about_right():
    assert TRUE <= told(0.3 * TRUE, tip=30.0) < 5 * TRUE


def test_nor_do_jumps_tell_more_than_they_scatter():
    """Within what is lost by chance alone, half of 20 nats, no place is better."""
    found = told(1e-6 * TRUE, tip=30.0, scatter=10.0)
    assert 2 * TRUE < found < 8 * TRUE
