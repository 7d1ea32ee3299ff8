"""By how much battery or speed comes late, as the course of both says."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from rcc_sim.channel import moving_mean, rows_in
from rcc_sim.diagnose.residuals.terminals import BEYOND_SHAFT

if TYPE_CHECKING:
    from rcc_sim.diagnose.residuals.problem import Problem

Array = NDArray[np.float64]

NEIGHBOURS = (-2, -1, 1, 2)
"""Rows beside its own that a reading may be a mean of."""

FLOWS_OF = "flows_{:+d}"
"""Name of what readings are of the row that is so many later."""

SLOW = 10.0
"""Time over which what a channel does is left out: loads and hills. [s]"""

MOST, STEP = 2.0, 0.01
"""Longest delay, and least step from one that is tried to the next; a quarter of a row
where that is more. [s]"""

ROWS = 2.0
"""Rows of delay that are no clear one: a mean since the row before, or two clocks."""

CLEARLY = 0.7
"""Share of what parts two courses that must stay at most for one to be late."""


def battery_channel(problem: Problem) -> str:
    """Return the channel by which the battery is compared; empty if there is none."""
    compared = (c for c in reversed(problem.channels) if c in BEYOND_SHAFT)
    return next(compared, "")


def clear_delay(problem: Problem) -> float:
    """Delay [s] of the battery's readings beside an imposed drive; 0 if none is clear.

    Negative where it is the speed that comes late. In such a drive nothing but their
    meters makes them late. What a noise model that remembers takes for noise at any
    other delay, the course of both shows at once.
    """
    delay, left = problem.delay
    return delay if left <= CLEARLY**2 and abs(delay) >= ROWS * problem.row else 0.0


def as_late(off: Mapping[str, float], row: float) -> float:
    """Delay [s] of readings that are in part of the rows beside their own.

    d = -T Σ k c_k, T being the time between rows and c_k the share of the row that is k
    later, of what is ``off`` in a log by name (``FLOWS_OF``).
    """
    return -row * sum(k * off.get(FLOWS_OF.format(k), 0.0) for k in NEIGHBOURS)


def without_slow(time: Array, x: Array) -> Array:
    """Return a channel without what it does over ``SLOW``."""
    return x - moving_mean(x, rows_in(time, SLOW))


def likeliest_delay(problem: Problem) -> tuple[float, float]:
    """Delay [s] at which battery and drive go together best, and what is left there.

    It is that of the least Σ (y(t) - x(t - d))², y being what was logged and x what the
    model predicts, both without what is slow; a parabola through the three about it. It
    is negative where the speed comes later. What is left is a share of that without a
    delay. 0 and 1 in a drive that is not imposed, or without a battery.
    """
    channel = battery_channel(problem)
    if not (channel and problem.drive.imposed) or problem.charge is not None:
        return 0.0, 1.0
    time, row = problem.log["time_s"], problem.row
    known = problem.judged[problem.channels.index(channel)]
    logged = without_slow(time, problem.log[channel])
    model = without_slow(time, np.nan_to_num(problem.nominal[channel]))
    step = max(row / 4, STEP)
    most = int(MOST / step)
    delays = step * np.arange(-most, most + 1)
    known = known & (time - time[0] > MOST) & (time[-1] - time > MOST)
    if not known.any() or most < 1:
        return 0.0, 1.0

    def apart(delay: float) -> float:
        there = np.interp(time - delay, time, model)
        return float(np.mean((logged - there)[known] ** 2))

    left = np.array([apart(d) for d in delays])
    k = int(np.clip(left.argmin(), 1, len(delays) - 2))
    bend = left[k - 1] - 2 * left[k] + left[k + 1]
    aside = 0.5 * (left[k - 1] - left[k + 1]) / bend if bend > 0 else 0.0
    aside = min(max(aside, -1.0), 1.0)
    return float(delays[k] + step * aside), float(left[k] / (left[most] or 1.0))
