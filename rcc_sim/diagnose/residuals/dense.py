"""A log of more rows than any effect needs, as one of fewer."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from math import ceil

import numpy as np
from numpy.typing import NDArray

from rcc_sim.analyse.logcheck.finding import COMMANDS, Finding
from rcc_sim.analyse.logcheck.relation import mean_of_known
from rcc_sim.analyse.logged import COMPARED, Logged
from rcc_sim.channel import interval_of
from rcc_sim.simulate.drive import holds, whole
from rcc_sim.trace import Trace

Array = NDArray[np.float64]

DENSE, ASKED = 250.0, 200.0
"""Rows per second beyond which a log is thinned, and to which at most: a time is told
to a fifth of a row, and no effect acts within a millisecond. [1/s]"""

SLACK = 1e-3
"""What a rate may be off, as clocks are. [1]"""

SAMPLED = "speed_mps", "yaw_rate_radps"
"""Columns compared that the model samples at a row; the others are means."""

WIDE = 1.5
"""Times its usual length beyond which some rows lie across a hole, and are no mean."""


def thinned(one: Logged) -> Logged:
    """Return a log with no more rows than are asked for, and say so in its findings."""
    many = rows_to_one(one.log)
    if many == 1:
        return one
    rate = 1 / interval_of(one.log["time_s"])
    said = Finding(
        "dense",
        "time_s",
        f"{rate:.4g} rows a second are more than any effect asks for",
        action=f"means over {many} rows, {rate / many:.4g} a second; commands, places "
        "and angles as in the middle one",
    )
    log = with_fewer_rows(one.log, many)
    return replace(one, log=log, findings=(*one.findings, said))


def rows_to_one(log: Trace) -> int:
    """Return how many rows are made one, an odd number; 1 where they are not many."""
    row = interval_of(log["time_s"])
    if len(log) < 2 or row <= 0 or 1 / row <= (1 + SLACK) * DENSE:
        return 1
    return int(2 * ceil((1 / (row * ASKED) - 1) / 2 - SLACK) + 1)


def with_fewer_rows(log: Trace, many: int) -> Trace:
    """Return a log with a row for so many, an odd number: their means, at the middle.

    What a sensor reads is a mean of what is known: what the model samples, of the rows
    about the middle one, and flows, which are means since the row before, of those that
    it ends. Commands, angles, which wrap, places and sums are as in the middle row, and
    so is the time. A command that holds leaps from one row to the next, and a loop is
    stiff: that it leaps neither early nor late on the whole, it is as in the last row;
    and where its leaps come evenly, most of them are at middle ones.
    """
    asked = {c: whole(log, c) for c in COMMANDS if log.has(c)}
    held = {c: x for c, x in asked.items() if holds(x)}
    first = most_leapt([*held.values()], many) if held else 0
    count = (len(log) - first) // many
    rows = first + np.arange(count * many).reshape(count, many)
    time = log["time_s"][rows]
    usual = (many - 1) * interval_of(log["time_s"])
    kept = time[:, -1] - time[:, 0] <= WIDE * usual
    rows = rows[kept]

    def fewer(name: str, x: Array) -> Array:
        if name in COMPARED:
            back = 0 if name in SAMPLED else many // 2
            return mean_of_known(x[np.maximum(rows - back, 0)])
        return held[name][rows[:, -1]] if name in held else x[rows[:, many // 2]]

    return Trace({n: fewer(n, x) for n, x in log.columns.items()}, name=log.name)


def most_leapt(commands: Sequence[Array], many: int) -> int:
    """Return the row from which on commands leap most to the middle of so many."""
    ways = [np.abs(np.diff(x, prepend=x[0])) / np.ptp(x) for x in commands]
    full = len(commands[0]) // many * many
    each = np.sum(ways, axis=0)[:full].reshape(-1, many)
    return int((np.argmax(each.sum(axis=0)) - many // 2) % many)
