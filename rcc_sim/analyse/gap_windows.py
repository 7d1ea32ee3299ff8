"""Stretches of a drive where a channel is beyond its noise."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rcc_sim.analyse.logcheck.finding import runs
from rcc_sim.channel import moving_mean

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

EXTENT = 1.5
"""Mean difference, in units of noise and tolerance, to which a window reaches whose
peak is beyond the limit. [1]"""

MOST = 12
"""Windows that are told."""


@dataclass(frozen=True)
class Window:
    """A stretch where one channel is beyond noise and tolerance.

    ``share`` is its part of the square of all channels' differences, in noise units.
    """

    start_s: float
    end_s: float
    channel: str
    share: float


def windows(
    time: Array,
    differences: dict[str, Array],
    sizes: dict[str, Array],
    rows: int,
    limit: float,
) -> list[Window]:
    """Return the stretches that matter most, in the order of time.

    Parameters
    ----------
    time : ndarray, shape (n,)
        Of the rows. [s]
    differences, sizes : dict of ndarray
        Per channel measured less simulated, NaN where not judged, and one standard
        deviation of it by noise and tolerance.
    rows : int
        Rows over which a difference is averaged.
    limit : float
        Mean difference, in units of noise and tolerance, that a window's peak must
        exceed, from :func:`rcc_sim.analyse.gap_alarm.alarm_limit`.
    """
    found: list[Window] = []
    total = 0.0
    for name, e in differences.items():
        judged = np.isfinite(e)
        size = np.where(sizes[name] > 0, sizes[name], np.inf)
        z = np.where(judged, e / size, 0.0)
        squares = z * z
        total += float(squares.sum())
        mean = np.abs(moving_mean(z, rows))
        if float(mean.max()) <= limit:
            continue
        beyond = _closed(mean > EXTENT, rows)
        along = np.concatenate([[0.0], np.cumsum(squares)])
        found += [
            Window(float(time[a]), float(time[b - 1]), name, float(along[b] - along[a]))
            for a, b in zip(*runs(beyond), strict=True)
            if b - a > rows // 2 and float(mean[a:b].max()) > limit
        ]
    found.sort(key=lambda w: -w.share)
    kept = sorted(found[:MOST], key=lambda w: (w.start_s, w.channel))
    return [
        Window(w.start_s, w.end_s, w.channel, w.share / total) for w in kept if total
    ]


def _closed(mask: Mask, rows: int) -> Mask:
    """Join stretches that are less than some rows apart."""
    if not mask.any():
        return mask
    out = mask.copy()
    starts, ends = runs(mask)
    near = np.flatnonzero(starts[1:] - ends[:-1] < rows)
    for k in near:
        out[ends[k] : starts[k + 1]] = True
    return out
