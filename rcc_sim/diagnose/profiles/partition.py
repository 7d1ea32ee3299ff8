"""The levels of a sequence that jumps, or slopes and jumps: optimal partitioning.

By dynamic programming over where each level begins. [1]_

References
----------
.. [1] B. Jackson et al., "An algorithm for optimal partitioning of data on an
   interval," IEEE Signal Processing Letters 12 (2005) 105.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from rcc_sim.jit import compiled, over_arrays

Array = NDArray[np.float64]


FLAT = 1e-12
"""Share of the spread of all places below which those of a level have none."""


class Levels(NamedTuple):
    """Where each level begins, and the end of the last; and which of them slope."""

    edges: tuple[int, ...]
    slope: tuple[bool, ...]


def segments(
    value: Array, told: Array, least: int, nats: float, tilt: float | None = None
) -> Levels:
    """Return the levels of a sequence.

    Those that minimise ``sum told (value - level)^2 / 2 + nats`` per level, of which
    none holds fewer than ``least`` values. A level may be a straight line, where that
    is likelier by ``tilt``.

    Parameters
    ----------
    value, told : ndarray, shape (n,)
        Each value, and its inverse variance.
    least : int
        Fewest values in a level.
    nats : float
        What a level costs. [nats]
    tilt : float or None
        What a slope costs besides; None where no level slopes. [nats]
    """
    n = len(value)
    x = np.zeros(n) if tilt is None else np.linspace(-1.0, 1.0, n)
    sums = np.zeros((n + 1, 5))
    parts = [told, told * value, told * x, told * x * x, told * x * value]
    np.cumsum(np.stack(parts, axis=1), axis=0, out=sums[1:])
    start = np.zeros(n + 1, dtype=np.intp)
    slope = np.zeros(n + 1, dtype=np.bool_)
    compiled(begin_last)(sums, min(least, n), nats, tilt or 0.0, start, slope)
    edges = [n]
    while edges[-1] > 0:
        edges.append(int(start[edges[-1]]))
    return Levels(tuple(edges[::-1]), tuple(bool(slope[end]) for end in edges[-2::-1]))


@over_arrays
def begin_last(sums, least, nats, tilt, start, slope):
    """Write where the last level begins of the best up to each value, and if it slopes.

    ``sums`` (n + 1, 5) are those, up to there, of how much the values tell, and of that
    times the value y, the place x, x² and x y.
    """
    n = len(start) - 1
    best = np.full(n + 1, -np.inf)
    best[0] = 0.0
    for end in range(least, n + 1):
        for begin in range(max(end - least, 0) + 1):
            w = max(sums[end, 0] - sums[begin, 0], 1e-300)
            y = sums[end, 1] - sums[begin, 1]
            x = sums[end, 2] - sums[begin, 2]
            gain = best[begin] + 0.5 * y**2 / w - nats
            spread = sums[end, 3] - sums[begin, 3] - x**2 / w
            more = -1.0
            if spread > FLAT * sums[n, 3]:
                both = sums[end, 4] - sums[begin, 4] - x * y / w
                more = 0.5 * both**2 / spread - tilt
            if begin == 0 or gain + max(more, 0.0) > best[end]:
                best[end], start[end] = gain + max(more, 0.0), begin
                slope[end] = more > 0
