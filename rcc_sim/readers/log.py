"""A log as it was read: its trace, and what became of every source column."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from rcc_sim.trace import Trace

Array = NDArray[np.float64]

HELD = (
    "speed_ref_mps",
    "throttle",
    "steer_cmd_rad",
    "steering",
    "motor_speed_ref_erpm",
)
"""Commands: each holds until the next one."""


GAP = 5.0
"""Usual steps, of the slower clock, beyond which a channel is not interpolated."""


class Mapped(NamedTuple):
    """One column of the trace, and where it came from.

    Attributes
    ----------
    column : str
        Our name, the unit as its last part.
    source : str
        Column, channel or topic and field of the file.
    factor, offset : float
        ours = factor · theirs + offset
    """

    column: str
    source: str
    factor: float = 1.0
    offset: float = 0.0

    @property
    def is_as_it_was(self) -> bool:
        """Whether name and values are the file's own."""
        return self == Mapped(self.source, self.source)

    def line(self) -> str:
        """Return it in words."""
        times = "" if self.factor == 1 else f" × {self.factor:.9g}"
        plus = "" if self.offset == 0 else f" {self.offset:+.9g}"
        return f"{self.column} from {self.source}{times}{plus}"


class Flaw(NamedTuple):
    """What is wrong with a file itself, or with a channel that was left out of it.

    Attributes
    ----------
    kind : str
        Slug, such as ``dead``, ``cut_short``, ``unreadable``.
    channel : str
        As the file calls it; empty where it is the whole file.
    what, action : str
        In words, and what was done about it.
    severe : bool
        Whether rows are missing by it, which a note is not enough for.
    """

    kind: str
    channel: str
    what: str
    action: str
    severe: bool = False

    def line(self) -> str:
        """Return it in words."""
        head = f"{self.channel}: " if self.channel else ""
        return f"{head}{self.what}: {self.action}"


@dataclass(frozen=True)
class Log:
    """A log in rccsim's own columns, as measured: nothing is mended.

    Parameters
    ----------
    trace : Trace
        All rows, also those whose time stands still, jumps or is blank; NaN where a
        channel has no value.
    reader : str
        Which reader read it.
    mapped : tuple of Mapped
        Where each column came from.
    dropped : tuple of str
        What the file holds and the trace does not.
    guessed : tuple of str
        What the reader assumed and the file does not say.
    notes : tuple of str
        What else a person should know.
    flaws : tuple of Flaw
        What is wrong with the file, as far as reading it shows.
    start_s : float
        What its own stamps are at ``time_s`` 0; since 1970 where they are dates. [s]
    """

    trace: Trace
    reader: str
    mapped: tuple[Mapped, ...] = ()
    dropped: tuple[str, ...] = ()
    guessed: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()
    flaws: tuple[Flaw, ...] = ()
    start_s: float = 0.0


class Group(NamedTuple):
    """Columns that share a clock.

    Attributes
    ----------
    time : ndarray or None, shape (n,)
        None where the clock is one of the columns. [s]
    columns : dict of ndarray, each of shape (n,)
        By the name that the file gives them.
    """

    time: Array | None
    columns: dict[str, Array]


def merged(groups: Sequence[Group]) -> dict[str, Array]:
    """Rows of several clocks in one table: every stamp once, blank where no value is.

    No value is moved, held or interpolated. A stamp that one clock gives twice stays
    twice.

    Parameters
    ----------
    groups : sequence of Group
        Each with its clock.

    Returns
    -------
    columns : dict of ndarray
        ``time_s`` first.
    """
    clocks = [np.zeros(0) if g.time is None else g.time for g in groups]
    if len(groups) == 1:
        return {"time_s": clocks[0], **groups[0].columns}
    keys = [np.stack([t, _repeats(t)], axis=1) for t in clocks]
    rows, place = np.unique(np.concatenate(keys), axis=0, return_inverse=True)
    columns = {"time_s": rows[:, 0].copy()}
    start = 0
    for group, clock in zip(groups, clocks, strict=True):
        at = place.ravel()[start : start + len(clock)]
        start += len(clock)
        for name, values in group.columns.items():
            columns[name] = np.full(len(rows), np.nan)
            columns[name][at] = values
    return columns


def on_one_clock(trace: Trace, column: str = "speed_mps") -> Trace:
    """Rows at which one column has a value; the others held or interpolated there.

    For a trace whose channels were logged at different rates. Commands hold until the
    next one; what was measured is interpolated linearly between its neighbours. Before
    a channel's first value and, if it was measured, after its last and where some of
    its rows were lost, it stays blank.

    Parameters
    ----------
    trace : Trace
        As read; stamps that are blank or do not increase are left out.
    column : str
        The channel whose rows are kept.

    Returns
    -------
    trace : Trace
        No row has a blank in `column`.
    """
    time = trace["time_s"]
    keep = np.isfinite(time) & np.isfinite(trace[column])
    at = np.unique(time[keep])
    columns = {"time_s": at}
    for name, values in trace.columns.items():
        if name == "time_s":
            continue
        there = np.isfinite(values) & np.isfinite(time)
        stamps, first = np.unique(time[there], return_index=True)
        known = values[there][first]
        if len(known) == 0:
            columns[name] = np.full(len(at), np.nan)
            continue
        before = np.searchsorted(stamps, at, side="right") - 1
        if name in HELD:
            columns[name] = np.where(before >= 0, known[before], np.nan)
            continue
        smooth = np.unwrap(known) if name == "yaw_rad" else known
        found = np.interp(at, stamps, smooth, left=np.nan, right=np.nan)
        found -= (smooth - known)[before]  # whole turns
        columns[name] = np.where(_in_a_gap(at, stamps), np.nan, found)
    return Trace(columns, name=trace.name)


def _in_a_gap(at: Array, stamps: Array) -> NDArray[np.bool_]:
    """Tell which times lie between two stamps that are too far apart to join."""
    steps = np.diff(stamps)
    if len(steps) == 0 or len(at) < 2:
        return np.zeros(len(at), dtype=bool)
    widest = GAP * max(float(np.median(steps)), float(np.median(np.diff(at))))
    after = np.clip(np.searchsorted(stamps, at), 1, len(steps))
    return np.asarray((steps[after - 1] > widest) & (stamps[after] != at))


def _repeats(time: Array) -> Array:
    """How often each stamp came before, counted in the order of the rows."""
    order = np.argsort(time, kind="stable")
    ordered = time[order]
    new = np.ones(len(time), dtype=bool)
    new[1:] = ordered[1:] != ordered[:-1]
    first = np.maximum.accumulate(np.where(new, np.arange(len(time)), 0))
    count = np.empty(len(time))
    count[order] = np.arange(len(time)) - first
    return count
