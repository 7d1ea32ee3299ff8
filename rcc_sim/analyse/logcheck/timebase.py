"""The time base of a log: unit, order, gaps, jitter."""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from rcc_sim.analyse.logcheck.finding import (
    UNUSED,
    Array,
    Finding,
    Mask,
    at,
    counted,
    runs,
    spread,
    when,
)
from rcc_sim.trace import Trace

LONGEST_STEP = 3.0
"""Median step above which seconds are not believed. [s]"""

SHORTEST_STEP = 2e-5
"""Median step below which seconds are not believed. [s]"""

PAUSE, GRAVE = 60.0, 25.0
"""Step of the clock [s] from which on a logger was switched off; usual steps beyond
which a hole is worth a warning."""

EPOCH = (5e8, 5e9)  # s since 1970: 1985 to 2128

LOST = 0.05
"""Share of rows that may be lost before it is worth a warning."""

OFF, EVEN = 0.1, 0.95
"""Share of a usual step by which a step may be off a multiple of it, and share of the
steps that are not, for a clock to be an even one of which rows were lost."""

APART = 2.0
"""Times as dense as half-way to one row steps of two are where rows were lost."""

FEW_STAMPS, ALIKE = 5, 0.2
"""Fewest stamps from which it is told how many rows share one, and the share of their
number by which that may differ from stamp to stamp."""

MANY_DRIVES = 5
"""Times that a clock may start anew for its rows to be told one by one."""


class TimeBase(NamedTuple):
    """What the time column holds."""

    keep: Mask  # rows whose stamp can be used
    findings: list[Finding]
    rate: float  # rows per second, with the unit mended [Hz]
    factor: float  # seconds in the column's unit


def time_base(trace: Trace) -> TimeBase:
    """Check the time column of a trace.

    Returns
    -------
    TimeBase
        Rows to keep (finite, strictly increasing), findings, and the median rate.
    """
    time = np.asarray(trace["time_s"], dtype=float)
    keep, findings = _order(time)
    steps = np.diff(time[keep])
    if not len(steps):
        return TimeBase(keep, findings, 0.0, 1.0)
    middle = float(np.median(steps))
    unit = [] if _is_slow(trace, middle) else _unit(middle)
    findings += unit
    factor = unit[0].factor if unit and unit[0].factor else 1.0
    start = float(time[keep][0]) * factor
    if EPOCH[0] < start < EPOCH[1]:
        findings.append(
            Finding(
                "unix_time",
                "time_s",
                f"counts from 1970 (starts at {start:.0f} s)",
                action="used as it is; only differences matter",
            )
        )
    findings += _gaps(time * factor, keep, steps * factor, middle * factor)
    return TimeBase(keep, findings, 1.0 / (middle * factor), factor)


def _order(time: Array) -> tuple[Mask, list[Finding]]:
    """Return the rows to keep, and what was wrong with the others."""
    findings = []
    keep = np.isfinite(time)
    if not keep.all():
        rows = np.flatnonzero(~keep)
        findings.append(
            _dropped("missing_stamp", f"{len(rows)} rows have no time", rows)
        )
    rows = np.flatnonzero(keep)
    same = rows[1:][np.diff(time[rows]) == 0]
    if len(same):
        keep[same] = False
        what = f"{len(same)} rows repeat the stamp of the row before"
        mend = ""
        if len(same) > LOST * len(time):
            what += ": the stamps are too coarse, or rows stand twice"
            mend = _counted_evenly(time[rows])
        findings.append(_dropped("duplicate_stamps", what, same, mend))
        rows = np.flatnonzero(keep)
    steps = np.diff(time[rows])
    if (steps < 0).any():
        rising = rows[_longest_rise(time[rows])]
        out = np.setdiff1d(rows, rising, assume_unique=True)
        keep[out] = False
        findings.append(_backwards(time, rows, out))
    return keep, findings


def _counted_evenly(time: Array) -> str:
    """Return how to keep rows of which about as many each have the same stamp.

    As of a clock of whole seconds at 10 Hz; an empty text where they do not.
    """
    new = np.flatnonzero(np.diff(time) != 0) + 1
    each, step = np.diff(new), np.diff(time[new])
    if len(each) < FEW_STAMPS or np.median(each) < 2:
        return ""
    middle = float(np.median(each))
    alike = np.abs(each - middle) <= max(1.0, ALIKE * middle)
    if alike.mean() < EVEN or np.median(step) <= 0:
        return ""
    rate = float(each.sum() / step.sum())
    return (
        f"each stamp has {middle:.0f} rows: a --map with rate_hz = {rate:.4g} and no "
        "time_s keeps them all, evenly spread"
    )


def _backwards(time: Array, rows: NDArray[np.intp], out: NDArray[np.intp]) -> Finding:
    """Return the finding of a time that falls; out: the rows that fit no rise."""
    steps = np.diff(time[rows])
    anew = rows[1:][steps < 0]
    far = float(-steps.min())
    often = "once" if len(anew) == 1 else f"{len(anew)} times"
    what = f"goes backwards {often}, by up to {far:.4g} s"
    wraps = 8.5e4 < far * _scale(steps) < 8.65e4
    if wraps:
        what += " (a clock that wraps at midnight?)"
    if len(out) <= LOST * len(time):
        what += f"; {len(out)} rows do not fit an increasing time"
        return _dropped("backwards", what, out)
    if wraps:
        mend = "add a day to the stamps from there on"
    elif len(anew) <= MANY_DRIVES:
        mend = "cut the file there: each drive in a file of its own"
    else:
        mend = "put the rows in the order in which they were measured"
    place = f"row {', '.join(str(row + 1) for row in anew[:MANY_DRIVES])}"
    action = f"{UNUSED}; {mend}"
    return Finding("backwards", "time_s", what, place, action=action, severity="error")


def _is_slow(trace: Trace, step: float) -> bool:
    """Tell whether a log of 3 to 9 "seconds" a row may be just that: it moves by rows.

    At a hundred rows a second nothing with a mass changes much from row to row.
    """
    if not LONGEST_STEP < step < 9 or "speed_mps" not in trace:
        return False
    speed = trace["speed_mps"]
    changes = np.abs(np.diff(speed[np.isfinite(speed)]))
    return len(changes) > 20 and float(np.quantile(changes, 0.95)) > 0.1 * spread(speed)


def _scale(steps: Array) -> float:
    unit = _unit(float(np.median(np.abs(steps))))
    return unit[0].factor if unit and unit[0].factor else 1.0


def _dropped(kind: str, what: str, rows: NDArray[np.intp], mend: str = "") -> Finding:
    place = f"row {rows[0] + 1}" + (f" to {rows[-1] + 1}" if len(rows) > 1 else "")
    return Finding(
        kind,
        "time_s",
        what,
        place,
        action=f"{len(rows)} rows left out" + (f"; {mend}" if mend else ""),
        severity="warning",
    )


def _longest_rise(values: Array) -> NDArray[np.intp]:
    """Return the rows of a longest strictly increasing subsequence (patience sort)."""
    tops: list[float] = []
    top_rows: list[int] = []
    before = np.empty(len(values), dtype=np.intp)
    for row, value in enumerate(values.tolist()):
        if not tops or value > tops[-1]:
            k = len(tops)
            tops.append(value)
            top_rows.append(row)
        else:
            k = bisect_left(tops, value)
            tops[k] = value
            top_rows[k] = row
        before[row] = top_rows[k - 1] if k else -1
    chain = np.empty(len(tops), dtype=np.intp)
    row = top_rows[-1]
    for k in range(len(tops) - 1, -1, -1):
        chain[k] = row
        row = int(before[row])
    return chain


def _unit(step: float) -> list[Finding]:
    """Return the finding of a time column that is not in seconds, by the step's size.

    Between 1/3 Hz and 50 kHz, steps of seconds, ms, µs and ns do not overlap much:
    a log slower than 1/3 Hz is the rarer thing.
    """
    if SHORTEST_STEP <= step <= LONGEST_STEP:
        return []
    if step < SHORTEST_STEP:
        return [
            Finding(
                "time_unit",
                "time_s",
                f"steps of {step:.3g} s are {1 / step:.3g} rows a second: not seconds?",
                sure=0.6,
                action="used as it is; if wrong, convert with a factor (--map)",
                severity="warning",
            )
        ]
    names = ((2e3, "ms", 1e-3), (2e6, "µs", 1e-6), (np.inf, "ns", 1e-9))
    unit, factor = next((u, f) for most, u, f in names if step <= most)
    return [
        Finding(
            "time_unit",
            "time_s",
            f"steps of {step:.4g} are not seconds; {unit} would be "
            f"{1 / (step * factor):.4g} rows a second",
            sure=0.7 if step < 9 else 0.95,
            action="not mended; give a --map; rccsim convert LOG --suggest-map drafts "
            f'one with unit = "{unit.replace("µ", "u")}"',
            severity="error",
            factor=factor,
        )
    ]


def _gaps(time: Array, keep: Mask, steps: Array, middle: float) -> list[Finding]:
    """Return what is lost between rows, and how evenly they come."""
    findings = []
    some = steps[:: max(1, len(steps) // 200_000)]
    loses = loses_rows(some / middle)
    if loses:
        some = some[np.round(some / middle) == 1]  # what is lost makes no row uneven
    low, high = np.quantile(some, [0.1, 0.9])
    jitter = float(high - low) / middle
    if jitter > 0.05:
        findings.append(
            Finding(
                "jitter",
                "time_s",
                f"rows come unevenly: {low:.4g} to {high:.4g} s apart (8 of 10)",
                action="used at their own stamps",
                severity="warning" if jitter > 3 else "info",
            )
        )
    wide = 1.6 * middle if loses or jitter < 0.3 else 3 * float(high)
    holes = np.flatnonzero(steps > wide)
    if not len(holes):
        return findings
    rows = np.flatnonzero(keep)
    paused = may_be_a_pause(steps[holes], middle)
    if paused.any():
        off = holes[paused]
        findings.append(_pauses(steps[off], _place_of_longest(time, rows, steps, off)))
    if not paused.all():
        lost = holes[~paused]
        place = _place_of_longest(time, rows, steps, lost)
        findings.append(_lost(steps, lost, middle, place))
    return findings


def loses_rows(steps: Array) -> bool:
    """Tell whether steps, in usual ones, are longer where rows were lost."""
    whole = np.round(steps)
    even = np.mean((np.abs(steps - whole) < OFF) & (whole > 0)) > EVEN
    return bool(even or doubles_stand_apart(steps))


def may_be_a_pause(steps: Array, usual: float) -> Mask:
    """Tell which steps of a clock are too long for rows that were lost. [s]"""
    return np.asarray(steps > max(PAUSE, GRAVE * usual))


def doubles_stand_apart(steps: Array) -> bool:
    """Tell whether steps, in usual ones, are of one row or two, and seldom between.

    Then they are rows that were lost, however much the others jitter: a loop that runs
    late now and then has steps of any length.
    """
    two, between = (
        np.count_nonzero(np.abs(steps - of) < half) / half
        for of, half in ((2.0, 0.25), (1.5, 0.1))
    )
    return bool(two > APART * between and np.mean(np.round(steps) == 1) > 0.5)


def _lost(
    steps: Array, holes: NDArray[np.intp], middle: float, place: Mapping[str, Any]
) -> Finding:
    """Return the finding of rows that were lost."""
    lost = float((steps[holes] / middle - 1).sum())
    longest = float(steps[holes].max())
    share = lost / (lost + len(steps))
    grave = share > LOST or longest > GRAVE * middle
    return Finding(
        "gap" if longest > 3.5 * middle else "lost_rows",
        "time_s",
        f"about {lost:.0f} rows ({100 * share:.2g} %) are lost in "
        f"{counted(len(holes), 'place')}; the longest gap is {longest:.4g} s",
        action="not filled; nothing is compared inside a gap",
        severity="warning" if grave else "info",
        **place,
    )


def _pauses(lasting: Array, place: Mapping[str, Any]) -> Finding:
    """Return the finding of holes that are no loss: a logger that was switched off."""
    often = f"{len(lasting)} times, up to " if len(lasting) > 1 else ""
    return Finding(
        "pause",
        "time_s",
        f"stops {often}{lasting.max():.4g} s: the logger paused, or the file holds "
        "several drives",
        action="nothing is compared meanwhile",
        severity="warning",
        **place,
    )


def _place_of_longest(
    time: Array, rows: NDArray[np.intp], steps: Array, holes: NDArray[np.intp]
) -> dict[str, Any]:
    """Return where the longest of some holes lies, as a finding tells it."""
    longest = int(holes[np.argmax(steps[holes])])
    start, end = float(time[rows[longest]]), float(time[rows[longest + 1]])
    where = f"{at(time, start)}–{at(time, end)} s (row {rows[longest] + 1})"
    return {"where": where, "start_s": start, "end_s": end}


def missing(time: Array, name: str, values: Array) -> list[Finding]:
    """Return the finding of a channel's empty rows."""
    empty = np.isnan(values)
    count = int(empty.sum())
    if not count:
        return []
    n = len(values)
    starts, ends = runs(empty)
    filled = np.flatnonzero(~empty)
    every = np.diff(filled)
    if len(every) > 10 and count > 0.3 * n:
        k = float(np.median(every))
        if k >= 2 and float(np.mean(every <= 2 * k)) > 0.95:
            return [
                Finding(
                    "sparse",
                    name,
                    f"has a value on every {k:.0f}. row only (a slower channel)",
                    when(time, filled),
                    action="used where it has one",
                )
            ]
    longest = int(np.argmax(ends - starts))
    first, end = int(starts[longest]), int(ends[longest])
    lasts = float(time[min(end, n - 1)] - time[first])
    grave = count > 0.02 * n or (end - first > 20 and lasts > 1.0)
    if end - first < 0.5 * count:  # here and there: from the first to the last
        first, end = int(starts[0]), int(ends[-1])
    return [
        Finding(
            "missing",
            name,
            f"empty in {counted(count)} ({100 * count / n:.2g} %), at most "
            f"{lasts:.3g} s without a break",
            f"{at(time, time[first])}–{at(time, time[end - 1])} s",
            action="not filled; left out of the comparison",
            severity="warning" if grave else "info",
            start_s=float(time[first]),
            end_s=float(time[end - 1]),
        )
    ]
