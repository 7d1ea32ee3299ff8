"""Channels that came seldom and were held in between: known where they change alone."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from rcc_sim.analyse.logcheck.finding import MEASURED, Finding, Mask
from rcc_sim.trace import Trace

SHORTEST = 3
"""Rows of one value from which a speed counts as held."""

LEAPS = 2.0
"""Times by which the change after a hold exceeds one between rows that all differ: a
speed that was kept while the vehicle went on leaps, one that was constant does not."""

OFTEN = 0.1
"""Share of the moving rows that are held, below which a log stays as it is."""

FEWEST = 20
"""Rows of a speed, held ones and such as change, below which no habit is told."""

EVERY_OTHER = 0.55
"""Share of all rows at which a clock strikes at most, some early."""

TOGETHER = 0.9
"""Share of a channel's changes on a clock's rows from which it goes by that clock."""


def between_updates(
    trace: Trace, slow: Iterable[str]
) -> tuple[Trace, tuple[Finding, ...]]:
    """Return a log whose slow channels are blank where they only repeat a value.

    Channels that one message brought change together, so that a value which came twice
    counts twice where another channel of the message tells; one that holds for longer
    came as often as the others did. Commands hold as they are.

    Parameters
    ----------
    trace : Trace
        A log.
    slow : iterable of str
        Channels that change every few rows only.
    """
    given = trace.columns
    moves = {
        name: np.concatenate([[True], np.diff(given[name]) != 0])
        for name in MEASURED
        if name in given and np.isfinite(given[name]).any()
    }
    seldom = [name for name in slow if name in moves]
    columns = dict(given)
    held: dict[str, int] = {}
    for name, changes in moves.items():
        clock = np.zeros(len(trace), dtype=bool)
        for other in seldom:
            if other == name or _share(changes, moves[other]) >= TOGETHER:
                clock |= moves[other]
        if clock.mean() <= EVERY_OTHER and _share(changes, clock) >= TOGETHER:
            came = clock | changes
            every = round(float(np.median(np.diff(np.flatnonzero(came)))))
            columns[name] = np.where(_again(came, every), given[name], np.nan)
            held[name] = every
    if not held:
        return trace, ()
    found = Finding(
        "held",
        ", ".join(held),
        f"came every {min(held.values())} rows or so, and hold in between",
        action="taken as known where they came",
    )
    return Trace(columns, name=trace.name), (found,)


def _again(came: Mask, every: int) -> Mask:
    """Return the rows at which a value came, and those at which it came once more."""
    rows = np.arange(len(came))
    since = rows - np.maximum.accumulate(np.where(came, rows, 0))
    return np.asarray(since % every == 0)


def _share(changes: Mask, clock: Mask) -> float:
    """Return how many of a channel's changes fall on the rows of a clock."""
    return float(clock[changes].mean())


def refreshed(trace: Trace) -> tuple[Trace, tuple[Finding, ...]]:
    """Return a log with its speed left out where it only repeats the last one.

    A speed of zero is a speed. A log whose holds do not end in leaps stays as it is.
    """
    speed = trace.columns.get("speed_mps")
    if speed is None or len(speed) < FEWEST:
        return trace, ()
    again = held_rows(speed)
    share = float(again.sum()) / max(int((np.nan_to_num(speed) != 0).sum()), 1)
    if share < OFTEN:
        return trace, ()
    columns = {**trace.columns, "speed_mps": np.where(again, np.nan, speed)}
    time = trace["time_s"]
    found = Finding(
        "held",
        "speed_mps",
        f"repeats its last value in {100 * share:.0f} % of the moving rows and leaps "
        "on from there",
        action="taken as known where it changes, and straight in between",
        severity="warning",
        start_s=float(time[again][0]),
        end_s=float(time[again][-1]),
    )
    return Trace(columns, name=trace.name), (found,)


def held_rows(speed: NDArray[np.float64]) -> Mask:
    """Tell the rows that repeat a speed from which it then leaps, if that is usual."""
    change = np.flatnonzero(np.diff(speed) != 0) + 1
    first, end = np.concatenate([[0], change]), np.concatenate([change, [len(speed)]])
    inner = slice(0, len(first) - 1)
    rows, moving = (end - first)[inner], speed[first][inner] != 0
    leap = np.abs(speed[end[inner]] - speed[first[inner]])
    none = np.zeros(len(speed), dtype=bool)
    held, live = moving & (rows >= SHORTEST), moving & (rows == 1)
    if min(held.sum(), live.sum()) < FEWEST:
        return none
    if np.nanmedian(leap[held]) < LEAPS * np.nanmedian(leap[live]):
        return none
    none[1:] = (np.diff(speed) == 0) & (speed[1:] != 0)
    return none
