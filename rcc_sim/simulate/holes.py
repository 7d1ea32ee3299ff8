"""Holes in a channel: where nothing is known between two readings."""

from __future__ import annotations

from math import inf

import numpy as np
from numpy.typing import NDArray

from rcc_sim.channel import interval_of
from rcc_sim.simulate.smooth import HOLE

Array = NDArray[np.float64]


def in_holes(
    time: Array, known: NDArray[np.bool_], least: float = 0.0
) -> NDArray[np.bool_] | None:
    """Return the rows that lie in long holes between readings; None where none does.

    Parameters
    ----------
    time : ndarray, shape (n,)
        Of the rows. [s]
    known : ndarray of bool, shape (n,)
        Whether there is a reading.
    least : float
        How long a hole is that counts, at least. [s]
    """
    rows = np.flatnonzero(known)
    if len(rows) < 2:
        return None
    after = np.searchsorted(rows, np.arange(len(time)))
    before = np.pad(time[rows], (1, 0), constant_values=-inf)[after]
    next_one = np.pad(time[rows], (0, 1), constant_values=inf)[after]
    long = max(HOLE * interval_of(time[rows]), least)
    hole = ~known & (next_one - before > long)
    return hole if hole.any() else None


def bridged_but_holes(time: Array, values: Array) -> Array:
    """Return a column with its rows between readings filled in, but for long holes."""
    known = np.isfinite(values)
    if known.sum() < 2:
        return values
    hole = in_holes(time, known)
    whole = np.interp(time, time[known], values[known])
    return whole if hole is None else np.where(hole, np.nan, whole)
