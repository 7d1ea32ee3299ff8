"""Whether the rows of a channel are samples, or means since the row before."""

from __future__ import annotations

from collections.abc import Iterable
from math import inf

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

LONG, CLOSE = 0.05, 0.015
"""Times between two rows below which half of one makes nothing, and is not asked: in a
drive that is imposed; and between commands, where a current follows within a tick what
an inverter's sample is a mean of 10 ms of. [s]"""

FLOWS = (
    *("motor_current_a", "motor_torque_nm"),
    *("battery_current_a", "battery_power_w"),
)
"""Columns of what flows, which an inverter or a meter samples or averages."""

ENOUGH = 10.0
"""Nats by which rows must be means to be taken as such; most are told by hundreds."""

FEW = 30
"""Changes below which nothing is told."""

STRETCHES = 20
"""Stretches of a log by whose scatter it is told what chance does."""

WILD = 5.0
"""Times the usual change of a channel beyond which one counts no more than so."""

APART = 2.0
"""Times the smear of a speed over which changes are taken: over less its smoothing
leaves none."""


def nats_for_means(
    seen: Array, mean: Array, half: Array, smeared: float = 0.0
) -> tuple[float, float]:
    """Nats by which a channel is the mean since the row before, and not another thing.

    Of what it should show three averages are as wide as a row: about the row's own
    time, as a sample is; since the row before; and about the row before, as a sample
    that comes a row late. Of equal width, none is smoother than the others. How the
    channel changes over some rows is laid beside how each of them does, with a gain of
    its own, so that neither a gap nor an offset speaks; what is left has a Laplace
    distribution, which outliers do not sway.

    Parameters
    ----------
    seen : ndarray, shape (n,)
        The channel, NaN where it is not known. [any unit]
    mean, half : ndarray, shape (n,)
        What it should be on average since the row before, and over the second half of
        that time. [any unit]
    smeared : float
        Rows over which these are smeared, because they follow from a noisy speed.

    Returns
    -------
    over_sample, over_late : float
        What the mean since the row before gains on the one and on the other.
    """
    y, *shown = changes_of(seen, mean, half, smeared)
    size = float(np.mean(np.abs(y))) if len(y) >= FEW else 0.0
    if size == 0.0:
        return 0.0, 0.0
    gains = [float(x @ y) / (float(x @ x) or 1.0) for x in shown]
    left = [
        max(float(np.mean(np.abs(y - gain * x))), 1e-9 * size)
        for gain, x in zip(gains, shown, strict=True)
    ]
    sample, since, late = len(y) * np.log(left)
    return float(sample - since), float(late - since)


def middle_of(
    channels: Iterable[tuple[Array, Array, Array]], smeared: float = 0.0
) -> tuple[float, float]:
    """Rows from the middle of a mean since the row before to what a log goes with most.

    And one standard deviation of that, by what it is without each stretch of the log.
    It is where the covariance of the changes of a channel and of the same three
    averages would be largest, if that is a parabola over time: neither an offset nor a
    gain shifts it, nor the noise of a speed that the averages follow from, as it does
    what is left between the two. Of several channels the covariances are added up.

    Parameters
    ----------
    channels : iterable of (seen, mean, half)
    smeared : float
        As for :func:`nats_for_means`.
    """
    gained = [g for c in channels if (g := _gained(*c, smeared)) is not None]
    if not gained:
        return 0.0, inf
    each = np.sum(gained, axis=0)
    total = each.sum(axis=1)
    without = _off(total[:, None] - each)
    return float(_off(total)), float(np.sqrt((STRETCHES - 1) * np.var(without)))


def changes_of(seen: Array, mean: Array, half: Array, smeared: float) -> Array:
    """How a channel changes over some rows, and the three averages; shape (4, rows)."""
    first = mean - 0.5 * half  # of the same time, halved as the other is
    about = 0.5 * half + np.roll(first, -1)
    apart = max(round(APART * smeared), 1)
    spans = [seen, about, mean, np.roll(about, 1)]
    changes = np.array([x[1:-1][apart:] - x[1:-1][:-apart] for x in spans])
    known: Array = changes[:, np.all(np.isfinite(changes), axis=0)]
    return known


def _off(gained: Array) -> Array:
    over_sample, over_late = gained
    return np.asarray(0.25 * (over_late - over_sample) / (over_sample + over_late))


def _gained(seen: Array, mean: Array, half: Array, smeared: float) -> Array | None:
    """Covariance with the average since the row before, beyond that with the others.

    By stretch, in units of their scatter; shape (2, STRETCHES).
    """
    y, sample, since, late = changes_of(seen, mean, half, smeared)
    if len(y) < max(FEW, STRETCHES):
        return None
    most = WILD * float(np.mean(np.abs(y)))
    y = np.clip(y, -most, most) * np.sign(y @ since)
    products = y * np.array([since - sample, since - late])
    parts = np.array_split(products, STRETCHES, axis=1)
    found = np.array([part.sum(axis=1) for part in parts]).T
    scatter = float(np.sqrt(found.var(axis=1).sum()))
    return found / scatter if scatter > 0 else None
