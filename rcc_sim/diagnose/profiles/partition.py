"""The levels of a sequence that jumps: optimal partitioning.

By dynamic programming over where each level begins. [1]_

References
----------
.. [1] B. Jackson et al., "An algorithm for optimal partitioning of data on an
   interval," IEEE Signal Processing Letters 12 (2005) 105.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rcc_sim.jit import compiled, over_arrays

Array = NDArray[np.float64]


def segments(value: Array, told: Array, least: int, nats: float) -> tuple[int, ...]:
    """Return where the levels of a sequence begin, and its end.

    Those that minimise ``sum told (value - level)^2 / 2 + nats`` per level, of which
    none holds fewer than ``least`` values.

    Parameters
    ----------
    value, told : ndarray, shape (n,)
        Each value, and its inverse variance.
    least : int
        Fewest values in a level.
    nats : float
        What a level costs.
    """
    n = len(value)
    weight = np.concatenate([[0.0], np.cumsum(told)])
    total = np.concatenate([[0.0], np.cumsum(told * value)])
    start = np.zeros(n + 1, dtype=np.intp)
    compiled(begin_last)(weight, total, min(least, n), nats, start)
    edges = [n]
    while edges[-1] > 0:
        edges.append(int(start[edges[-1]]))
    return tuple(edges[::-1])


@over_arrays
def begin_last(weight, total, least, nats, start):
    """Write where the last level begins of the best up to each value.

    ``weight`` and ``total`` (n + 1,) are the sums, up to there, of how much the values
    tell and of that times the value.
    """
    n = len(start) - 1
    best = np.full(n + 1, -np.inf)
    best[0] = 0.0
    for end in range(least, n + 1):
        for begin in range(max(end - least, 0) + 1):
            own = max(weight[end] - weight[begin], 1e-300)
            gain = best[begin] + 0.5 * (total[end] - total[begin]) ** 2 / own - nats
            if begin == 0 or gain > best[end]:
                best[end], start[end] = gain, begin
