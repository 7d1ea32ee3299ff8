"""How far out a grid of strengths is tried."""

from math import inf
from types import SimpleNamespace

import numpy as np
import pytest

from rcc_sim.diagnose.causes.sought import Search
from rcc_sim.diagnose.search.screen import Screen

ALONG, ACROSS = np.eye(2) * 10.0


class Lines(Screen):
    """A neighbourhood in which a figure's signal grows in proportion to it."""

    def __init__(self, left, signal, prior=0.0):
        self.left, self.one, self.tried = left, signal, []
        self.promised, self.base = {}, SimpleNamespace(prior=prior)

    def signal(self, values):
        (x,) = values.values()
        self.tried.append(x)
        return x * self.one


def grid(*strengths, neutral=0.0):
    return Search("effects.any.figure", neutral, -inf, inf, 1.0, grid=strengths)


def test_clear_signals_that_promise_nothing_are_followed_no_further():
    screen = Lines(ALONG, ACROSS)
    assert screen.scan(grid(1.0, 2.0, 3.0), {}) == (0.0, 0.0)
    assert screen.tried == [1.0, 2.0]


def test_all_are_tried_where_figures_of_the_file_were_pulled_far():
    screen = Lines(ALONG, ACROSS, prior=-38.0)  # they may stand in for stronger ones
    screen.scan(grid(1.0, 2.0, 3.0), {})
    assert screen.tried == [1.0, 2.0, 3.0]


def test_each_side_of_what_the_file_states_begins_next_to_it():
    screen = Lines(ALONG, ACROSS)
    screen.scan(grid(-3.0, -2.0, -1.0, 1.0, 2.0, 3.0), {})
    assert screen.tried == [-1.0, -2.0, 1.0, 2.0]
    limit = Lines(ALONG, ACROSS)
    limit.scan(grid(1.0, 2.0, 3.0, neutral=inf), {})
    assert limit.tried == [3.0, 2.0]


class Late(Lines):
    """A figure that does something else within a row than beyond it."""

    def signal(self, values):
        (x,) = values.values()
        self.tried.append(x)
        return x * self.one if x > 1 else ACROSS


def test_one_strength_that_promises_nothing_hides_no_other():
    screen = Late(-3.0 * ALONG, ALONG)
    gain, strength = screen.scan(grid(1.0, 2.0, 3.0), {})
    assert strength == 3.0
    assert gain == pytest.approx(0.5 * 30.0**2)
    assert screen.tried == [1.0, 2.0, 3.0]


@pytest.mark.parametrize("strengths", [(1.0, 2.0, 3.0, 4.0), (4.0, 3.0, 2.0, 1.0)])
def test_what_promises_is_followed_to_the_best(strengths):
    screen = Lines(-3.0 * ALONG, ALONG)
    gain, strength = screen.scan(grid(*strengths), {})
    assert strength == 3.0
    assert gain == pytest.approx(0.5 * 30.0**2)
    assert screen.tried == [1.0, 2.0, 3.0, 4.0]


def test_a_faint_signal_tells_nothing_of_stronger_ones():
    screen = Lines(ALONG, 0.5 * ACROSS)  # 12.5 nats, then 50
    screen.scan(grid(1.0, 2.0, 3.0, 4.0), {})
    assert screen.tried == [1.0, 2.0, 3.0]
