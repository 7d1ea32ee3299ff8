"""What kind of driving shades a page, however long the drive is."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from rcc_sim.report.findings import spans_of

NAMES = ("standstill", "cruise", "speed unknown")


def seconds(spans):
    """Return how long each kind is shaded."""
    return {n: sum(s.end_s - s.start_s for s in spans if s.name == n) for n in NAMES}


@pytest.mark.parametrize("repeats", [10, 100, 3000])
def test_shares_of_the_shading_are_those_of_the_drive(repeats):
    rng = np.random.default_rng(1)
    lengths = np.round(rng.uniform(5, 40, 2 * repeats), 1)
    kinds = np.repeat(np.arange(2 * repeats) % 2, (10 * lengths).astype(int))
    time = np.arange(len(kinds) + 1) * 0.1
    spans = spans_of(time, kinds, NAMES)
    assert spans[0].start_s == 0 and spans[-1].end_s == pytest.approx(time[-1])
    assert all(a.end_s == b.start_s for a, b in pairwise(spans))
    shaded, true = seconds(spans), 0.1 * np.bincount(kinds)
    off = 0.03 * time[-1] if repeats == 3000 else 1e-6
    assert shaded["standstill"] == pytest.approx(true[0], abs=off)
    assert shaded["cruise"] == pytest.approx(true[1], abs=off)


def test_a_pause_of_the_log_is_shaded_as_the_row_before_it():
    time = np.concatenate([np.arange(0, 100, 0.1), np.arange(200, 300, 0.1)])
    kinds = np.ones(len(time) - 1, dtype=int)
    kinds[5] = 0
    assert [s.name for s in spans_of(time, kinds, NAMES)] == ["cruise"]


def test_what_is_not_known_is_the_last_kind_and_short_stretches_are_shaded():
    time = np.arange(1001) * 0.1
    kinds = np.zeros(1000, dtype=int)
    kinds[500:505], kinds[700:705] = 1, -1
    spans = spans_of(time, kinds, ("standstill", "cruise", "speed unknown"))
    assert [s.name for s in spans] == [
        *("standstill", "cruise", "standstill", "speed unknown", "standstill")
    ]
    assert spans_of(time[:1], kinds[:1], NAMES) == ()
