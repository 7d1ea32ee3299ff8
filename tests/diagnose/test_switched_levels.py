"""Where the levels of something that switches begin, against trying every way.

Some of them may be straight lines; those are numpy's, not our sums.
"""

from __future__ import annotations

from itertools import combinations, pairwise

import numpy as np
import pytest

from rcc_sim.diagnose.profiles.partition import segments


def misfits(value, told, a, b):
    """Misfit of a stretch's weighted mean, and of its straight line."""
    x = np.arange(a, b)
    for degree in (0, 1):
        line = np.polyval(
            np.polyfit(x, value[a:b], min(degree, b - a - 1), w=told[a:b] ** 0.5), x
        )
        yield 0.5 * float((told[a:b] * (value[a:b] - line) ** 2).sum())


def cost(value, told, edges, nats, tilt=np.inf):
    """Misfit of the stretches, each a level or a line, and what those cost."""
    total = nats * (len(edges) - 1)
    for a, b in pairwise(edges):
        level, line = misfits(value, told, a, b)
        total += min(level, line + tilt)
    return total


def every_way(least):
    """Twelve values in five stretches at most, none of fewer than the least."""
    return [
        (0, *inner, 12)
        for k in range(5)
        for inner in combinations(range(1, 12), k)
        if min(np.diff((0, *inner, 12))) >= least
    ]


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("least", [1, 2, 3])
def test_no_other_levels_are_likelier(seed, least):
    rng = np.random.default_rng(seed)
    value = np.repeat(rng.normal(0, 3, 4), 3) + rng.normal(0, 1, 12)
    told = rng.uniform(0.5, 2, 12)
    best = min(every_way(least), key=lambda edges: cost(value, told, edges, 4.0))
    found = segments(value, told, least, 4.0)
    assert found.edges == best
    assert not any(found.slope)


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("least", [1, 2, 3])
def test_nor_any_other_levels_and_slopes(seed, least):
    rng = np.random.default_rng(seed)
    wanes = np.concatenate([9.0 - 2.0 * np.arange(4), np.zeros(3), -1.5 * np.arange(5)])
    value, told = wanes + rng.normal(0, 0.5, 12), rng.uniform(0.5, 2, 12)
    best = min(every_way(least), key=lambda edges: cost(value, told, edges, 2.0, 1.0))
    found = segments(value, told, least, 2.0, 1.0)
    assert found.edges == best
    for (a, b), slopes in zip(pairwise(best), found.slope, strict=True):
        level, line = misfits(value, told, a, b)
        assert slopes == (level > line + 1.0)
    assert any(found.slope)


def test_levels_begin_where_a_load_switches():
    rng = np.random.default_rng(1)
    on = np.repeat([1.0, 0, 1, 0], [120, 60, 30, 90])
    value = 4.0 * on + rng.normal(0, 1.2, len(on))
    edges = segments(value, np.full(len(on), 1 / 1.2**2), 10, 10.0).edges
    assert len(edges) == 5
    assert np.abs(np.array(edges) - [0, 120, 180, 210, 300]).max() <= 1


def test_noise_has_one_level():
    value = np.random.default_rng(2).normal(0, 1, 400)
    assert segments(value, np.ones(400), 5, 10.0).edges == (0, 400)
    assert segments(value, np.ones(400), 5, 10.0, 5.0) == ((0, 400), (False,))


def test_fewer_values_than_a_level_holds_are_one():
    assert segments(np.arange(3.0), np.ones(3), 5, 1.0).edges == (0, 3)
