"""A grid of strengths is tried to its end, whatever the weak ones show."""

from dataclasses import replace
from math import inf

import numpy as np
import pytest

from rcc_sim.diagnose.causes.sought import Search
from rcc_sim.diagnose.search.screen import Screen

ALONG, ACROSS = np.eye(2) * 10.0


class Lines(Screen):
    """A neighbourhood in which a figure's signal grows in proportion to it."""

    def __init__(self, left, signal):
        self.left, self.one, self.tried = left, signal, []
        self.promised = {}

    def signal(self, values):
        (x,) = values.values()
        self.tried.append(x)
        return x * self.one


class Turns(Lines):
    """One of which little does something else, and shows it clearly, than much.

    A reading that holds for some rows looks like nothing that is late by a part of
    them; tyres that take long to make their force let a car weave, others do not.
    """

    def signal(self, values):
        (x,) = values.values()
        self.tried.append(x)
        return x * (self.one if x > 2.5 else ACROSS)


def grid(*strengths, neutral=0.0):
    return Search("effects.any.figure", neutral, -inf, inf, 1.0, grid=strengths)


@pytest.mark.parametrize("strengths", [(1.0, 2.0, 3.0), (3.0, 2.0, 1.0)])
def test_weak_ones_that_show_and_gain_nothing_hide_no_strong_one(strengths):
    screen = Turns(-3.0 * ALONG, ALONG)
    gain, strength = screen.scan(grid(*strengths), {})
    assert strength == 3.0
    assert gain == pytest.approx(0.5 * 30.0**2)
    assert {1.0, 2.0, 3.0} <= {*screen.tried}


def test_what_no_strength_gains_is_none():
    screen = Lines(ALONG, ACROSS)
    assert screen.scan(grid(-2.0, -1.0, 1.0, 2.0), {}) == (0.0, 0.0)
    assert screen.tried == [-2.0, -1.0, 1.0, 2.0]


@pytest.mark.parametrize("strengths", [(1.0, 2.0, 3.0, 4.0), (4.0, 3.0, 2.0, 1.0)])
def test_the_best_of_those_that_gain_is_taken(strengths):
    screen = Lines(-3.0 * ALONG, ALONG)
    gain, strength = screen.scan(grid(*strengths), {})
    assert strength == 3.0
    assert gain == pytest.approx(0.5 * 30.0**2)
    promised = screen.promised["effects.any.figure"]
    assert promised.nats == pytest.approx(gain)  # each is as promising as the best


class Hollows(Lines):
    """One in which every strength looks unlike any that is not near it.

    So does a delay beside commands that jump: a car that answered in between gains
    nothing by a delay that is a little less wrong.
    """

    def signal(self, values):
        (x,) = values.values()
        self.tried.append(x)
        return self.one if abs(x - 3.0) < 0.1 else 0.3 * self.one


def test_a_strength_between_those_of_a_grid_is_found():
    screen = Hollows(-ALONG, ALONG)
    gain, strength = screen.scan(grid(0.6, 1.2, 2.4), {})
    assert abs(strength - 3.0) < 0.1
    assert gain == pytest.approx(0.5 * 10.0**2)


def test_clocks_are_tried_until_one_changes_twice_what_is_left():
    screen = Lines(-3.0 * ALONG, ALONG)
    clocks = replace(grid(*map(float, range(1, 11))), acts="clock")
    gain, strength = screen.scan(clocks, {})
    assert max(screen.tried) == 7.0
    assert strength == pytest.approx(3.0)
    untried = [screen.gain(x * ALONG) for x in (8.0, 9.0, 10.0)]
    assert max(untried) < 0 < gain
