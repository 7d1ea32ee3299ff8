"""What repeats of a drive do not share: its noise, whatever the model may miss."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from rcc_sim.diagnose.residuals.problem import Problem

Array = NDArray[np.float64]

NEAR = 0.6
"""Share of a row by which two rows are of one time."""


def not_shared(problem: Problem, repeats: Sequence[Problem]) -> dict[str, Array]:
    """Return channel -> how its residual differs from that of repeats of the drive.

    (e - mean of e_k) / sqrt(1 + 1/n) at equal times from the starts of the logs, e
    being measured less predicted and n the repeats that have the row: what acts in all
    of them alike cancels, and independent noise keeps its size. About a mean of nil,
    for an offset is none; NaN where no repeat has the row.
    """
    time = problem.log["time_s"] - problem.log["time_s"][0]
    theirs = [(left_of(one), rows_at(time, one)) for one in repeats]
    found = {}
    for channel, e in left_of(problem).items():
        others = [
            np.where(at >= 0, left[channel][at], np.nan)
            for left, at in theirs
            if channel in left
        ]
        if not others:
            continue
        n = np.maximum(np.isfinite(others).sum(axis=0), 1)
        apart = (e - np.nansum(others, axis=0) / n) / np.sqrt(1 + 1 / n)
        apart[~np.isfinite(others).any(axis=0)] = np.nan
        if np.isfinite(apart).any():
            found[channel] = apart - np.nanmean(apart)
    return found


def left_of(problem: Problem) -> dict[str, Array]:
    """Return channel -> measured less predicted; NaN where it is not judged."""
    rows = zip(problem.channels, problem.judged, problem.residuals({}), strict=True)
    return {c: np.where(ok, e, np.nan) for c, ok, e in rows}


def rows_at(time: Array, other: Problem) -> NDArray[np.intp]:
    """Return the row of another log at each time since its start; -1 where none is."""
    clock = other.log["time_s"] - other.log["time_s"][0]
    after = np.clip(np.searchsorted(clock, time), 1, len(clock) - 1)
    nearest = after - (time - clock[after - 1] < clock[after] - time)
    near = np.abs(clock[nearest] - time) <= NEAR * other.row
    return np.where(near, nearest, -1)
