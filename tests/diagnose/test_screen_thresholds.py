"""Thresholds are sought where they are most like one that gains."""

import numpy as np

from rcc_sim.diagnose.causes.sought import Search
from rcc_sim.diagnose.search.screen import Screen


class Narrow(Screen):
    """A screen in which a threshold gains around 48.9 alone, and loses elsewhere.

    What a threshold shows is like the truth within 10 of it.
    """

    def __init__(self, promising: float) -> None:
        self.promising = promising

    def signal(self, values):
        """Return the threshold itself."""
        return np.array([*values.values()])

    def gain(self, d):
        """Return 100 nats at the truth; elsewhere a low threshold loses least."""
        off = abs(d[0] - 48.9)
        return 100.0 - 30.0 * off if off < 6 else -100.0 * d[0]

    def promise(self, d):
        """Return what is promised around the truth."""
        return self.promising if abs(d[0] - 48.9) < 10 else 0.0


DEAD = Search("k", 0.0, 0.0, 100.0, 27.2, grid=(13.6, 27.2, 40.8, 61.2), acts="steps")


def test_a_threshold_between_two_that_lose_is_found_from_the_likest():
    gain, x = Narrow(promising=48.0).scan(DEAD, {})
    assert gain > 70.0
    assert abs(x - 48.9) < 1


def test_thresholds_like_none_that_gains_are_not_followed():
    assert Narrow(promising=1.0).scan(DEAD, {}) == (0.0, 0.0)
