"""Stated figures that a log moved are named on the screen, in their sds."""

from math import inf
from types import SimpleNamespace

from rcc_sim.diagnose.knobs import Knob
from rcc_sim.report.screen import _moved

STATED = {"body.mass_kg": 3.0, "tyres.radius_m": 0.05, "body.yaw_inertia_kgm2": 0.04}


def test_the_farthest_come_first_and_those_within_an_sd_are_silent():
    knobs = [Knob(k, v, 0.01 * v) for k, v in STATED.items()]
    knobs += [Knob("effects.payload.mass_kg", 0.0, inf), Knob("bias.0.x", 0.0, 1.0)]
    moved = {"body.mass_kg": 3.045, "tyres.radius_m": 0.049, "bias.0.x": 5.0}
    values = {k.key: k.value for k in knobs} | moved | {"effects.payload.mass_kg": 1.0}
    fit = SimpleNamespace(knobs=knobs, values=values)
    vehicle = SimpleNamespace(figures=lambda: STATED)
    told = list(_moved(SimpleNamespace(fit=fit, vehicle=vehicle)))
    assert told == [("MOVED", "tyres.radius_m -2.0 sd, body.mass_kg +1.5 sd")]


def test_where_none_moved_nothing_is_said():
    knobs = [Knob(k, v, 0.01 * v) for k, v in STATED.items()]
    fit = SimpleNamespace(knobs=knobs, values=STATED)
    vehicle = SimpleNamespace(figures=lambda: STATED)
    assert list(_moved(SimpleNamespace(fit=fit, vehicle=vehicle))) == []
