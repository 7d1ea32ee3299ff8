"""Whether the rows of a channel are samples, or means since the row before."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

FEW = 30
"""Changes from row to row below which nothing is told."""


def nats_for_means(seen: Array, mean: Array) -> float:
    """Nats by which a channel is the mean since the row before, and no sample.

    Of what it should show three averages are as wide as a row: about the row's own
    time, as a sample is best foreseen by rows; since the row before; and about the row
    before, as of a sample that comes a row late. How a channel changes from row to row
    is laid beside how each of them does, with a gain of its own, so that neither a gap
    nor an offset speaks; what is left has a Laplace distribution, which outliers do not
    sway. Returned is what the second gains on the better of the others.

    Parameters
    ----------
    seen : ndarray, shape (n,)
        The channel, NaN where it is not known. [any unit]
    mean : ndarray, shape (n,)
        What it should be on average since the row before. [any unit]
    """
    before, after = np.roll(mean, 1), np.roll(mean, -1)
    spans = [0.5 * (mean + after), mean, 0.5 * (before + mean)]
    changes = [np.diff(x[1:-1]) for x in (seen, *spans)]
    y = changes[0]
    known = np.all(np.isfinite(changes), axis=0)
    if known.sum() < FEW or not y[known].any():
        return 0.0
    left = []
    for x in changes[1:]:
        power = float(x[known] @ x[known])
        gain = float(x[known] @ y[known]) / power if power else 0.0
        left.append(float(np.mean(np.abs(y[known] - gain * x[known]))))
    least = 1e-9 * float(np.mean(np.abs(y[known])))
    sample, since, late = (max(x, least) for x in left)
    return float(known.sum() * np.log(min(sample, late) / since))
