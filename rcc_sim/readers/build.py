"""From source columns, through a column map, to a log in rccsim's own columns."""

from __future__ import annotations

import fnmatch
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from rcc_sim.errors import InputError
from rcc_sim.readers.column_map import ColumnMap, Term, Where
from rcc_sim.readers.log import Array, Flaw, Group, Log, Mapped, merged
from rcc_sim.trace import Trace

EPOCH = 1e5
"""Stamps above a day count from the first: ten digits would not hold them. [s]"""

Words = list[str]


@dataclass
class Report:
    """What a reader has to say of a file while it reads it."""

    mapped: list[Mapped] = field(default_factory=list)
    dropped: list[str] = field(default_factory=list)
    guessed: list[str] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
    flaws: list[Flaw] = field(default_factory=list)


@dataclass(frozen=True)
class Column:
    """A source column on its clock."""

    values: Array
    clock: int = 0
    words: Words | None = None


def find(names: Sequence[str], wanted: str) -> str | None:
    """The name as the file has it; ``*`` stands for one part of a topic's name."""
    if wanted in names:
        return wanted
    if "*" not in wanted:
        return None
    parts = wanted.split("/")
    for name in names:
        theirs = name.split("/")
        if len(theirs) == len(parts) and all(
            fnmatch.fnmatchcase(t, p) for t, p in zip(theirs, parts, strict=True)
        ):
            return name
    return None


def mapped_columns(
    columns: dict[str, Column], names: Sequence[str], by: ColumnMap, report: Report
) -> list[tuple[str, int, Array]]:
    """Our columns by the map: name, clock, values.

    Parameters
    ----------
    columns : dict
        Name in the file -> column, of all that the map may need and the file has.
    names : sequence of str
        All names that the file has, for the error.
    by : ColumnMap
        The map.
    report : Report
        Filled in.

    Raises
    ------
    InputError
        If the file lacks a column that the user's own map does not call optional.
    """
    found: list[tuple[str, int, Array]] = []
    for ours, terms in by.columns.items():
        parts = [_part(term, columns) for term in terms]
        lacking = [t for t, p in zip(terms, parts, strict=True) if p is None]
        if lacking:
            there = [
                t for t in lacking if any(find(list(columns), s) for s in t.sources)
            ]
            for term in lacking:
                if not (by.shipped or term.optional):
                    lost = term.times if term in there else term.sources[0]
                    raise _lacking(by, ours, lost, names)
            gone = [t.sources[0] for t in lacking if t not in there]
            if gone and (len(lacking) < len(terms) or not by.shipped):
                report.notes.append(f"{ours}: no {gone[0]}: left out")
            for term in there:
                told = f"{ours}: no {term.times}, which it is multiplied by: left out"
                report.notes.append(told)
                report.dropped.append(ours)
            continue
        kept = [p for p in parts if p is not None]
        dead = [(name, why) for name, _, why in kept if why]
        if dead:
            name, why = dead[0]
            report.flaws.append(Flaw("dead", name, why, "left out"))
            report.dropped.append(name)
            continue
        clock = kept[0][1].clock
        found.append((ours, clock, np.sum([c.values for _, c, _ in kept], axis=0)))
        for term, (name, _, _) in zip(terms, kept, strict=True):
            report.mapped.append(Mapped(ours, name, term.scale, term.offset))
            if term.guess:
                report.guessed.append(f"{ours}: {term.guess}")
    return found


def finished(
    name: str,
    columns: dict[str, Array],
    reader: str,
    report: Report,
) -> Log:
    """Return the log, or say why there is none.

    Raises
    ------
    InputError
        If there is no time, no channel, fewer than two rows, or nothing but blanks.
    """
    if "time_s" not in columns:
        raise InputError(
            f"{name}: no time column",
            "a column map can name it, or state rate_hz; see --map",
        )
    time = columns["time_s"]
    channels = {n: v for n, v in columns.items() if n != "time_s"}
    if not channels:
        raise InputError(
            f"{name}: a time column and no channel",
            "a map names every column that is to be read; rccsim convert LOG "
            "--suggest-map drafts one",
        )
    if len(time) < 2:
        rows = "one row" if len(time) else "a header and no rows"
        raise InputError(f"{name}: {rows}: too few for a log")
    for column, values in columns.items():
        wild = np.isinf(values)
        if wild.any():
            columns[column] = np.where(wild, np.nan, values)
            row = int(wild.argmax()) + 1
            report.notes.append(
                f"{column}: {int(wild.sum())} infinite values made blank, the first in "
                f"row {row}"
            )
    if np.isnan(columns["time_s"]).all():
        raise InputError(f"{name}: time_s: every row is blank")
    if all(np.isnan(columns[n]).all() for n in channels):
        raise InputError(f"{name}: every channel is blank in every row")
    start = _epoch(columns["time_s"])
    if start:
        columns["time_s"] = columns["time_s"] - start
        report.notes.append(f"time_s 0 is {_date(start)}")
    return Log(
        trace=Trace(columns, name=name),
        reader=reader,
        start_s=start,
        mapped=tuple(report.mapped),
        dropped=tuple(dict.fromkeys(report.dropped)),
        guessed=tuple(dict.fromkeys(report.guessed)),
        notes=tuple(report.notes),
        flaws=tuple(report.flaws),
    )


def assembled(
    found: Sequence[tuple[str, int, Array]], clocks: Sequence[Array | None]
) -> dict[str, Array]:
    """One table of the columns of one or several clocks, ``time_s`` first."""
    own = {name: values for name, _, values in found}
    if len(clocks) == 1:
        time = own.get("time_s", clocks[0])
        first = {} if time is None else {"time_s": time}
        return first | own
    groups = [
        Group(time, {n: v for n, c, v in found if c == k and n != "time_s"})
        for k, time in enumerate(clocks)
    ]
    kept = [group for group in groups if group.columns]
    table = merged(kept) if kept else {}
    return {"time_s": table.pop("time_s"), **{n: table[n] for n, _, _ in found}}


def unwrapped(time: Array, period: float) -> Array:
    """A clock that starts over, as one that goes on. [s]"""
    step = np.diff(time, prepend=time[:1])
    step[np.isnan(step)] = 0.0
    turns: Array = np.cumsum(step < -period / 2) - np.cumsum(step > period / 2)
    return np.where(np.isnan(time), np.nan, time + period * turns)


def _part(term: Term, columns: dict[str, Column]) -> tuple[str, Column, str] | None:
    """Name, converted column, and why it means nothing; None if it is not there."""
    there = list(columns)
    name = next((n for s in term.sources if (n := find(there, s))), None)
    if name is None:
        return None
    column = columns[name]
    values = column.values
    for none in term.missing:
        values = np.where(values == none, np.nan, values)
    why = _dead(term, values)
    if term.times:
        by = columns.get(term.times)
        if by is None:
            return None
        values = values * by.values
    values = values * term.scale + term.offset
    if np.isfinite(term.wrap_s):
        values = unwrapped(values, term.wrap_s)
    for where, turn in (
        (term.blank_where, lambda v: np.full_like(v, np.nan)),
        (term.negative_where, np.negative),
    ):
        rows = _rows(where, columns)
        if rows is not None:
            values = np.where(rows, turn(values), values)
    return name, Column(values, column.clock), why


def _dead(term: Term, values: Array) -> str:
    known = values[np.isfinite(values)]
    if len(known) and (known == term.absent).all():
        return f"reads {term.absent:g} throughout: no sensor"
    if len(known) and (known < term.below).all():
        return f"reads below {term.below:g} throughout: no sensor"
    return ""


def _rows(where: Where | None, columns: dict[str, Column]) -> NDArray[np.bool_] | None:
    if where is None or where.source not in columns:
        return None
    column = columns[where.source]
    if column.words is not None:
        rows = np.array([word.strip() == where.equals for word in column.words])
    else:
        rows = column.values == float(where.equals)
    return rows if rows.any() else None


def _lacking(by: ColumnMap, ours: str, lost: str, names: Sequence[str]) -> InputError:
    shown = ", ".join(n for n in names[:40] if n)
    return InputError(
        f"{by.where}: columns.{ours}: the file has no {lost!r}",
        f"it has {shown}{' …' if len(names) > 40 else ''}; optional = true lets a "
        "file go without",
    )


def _epoch(time: Array) -> float:
    """Return what stamps count from, in whole seconds: 0, or an epoch's first. [s]"""
    known = time[np.isfinite(time)]
    return 0.0 if np.abs(known).max() < EPOCH else float(np.floor(known[0]))


def _date(stamp: float) -> str:
    from datetime import UTC, datetime

    if 1e8 < stamp < 1e10:
        return datetime.fromtimestamp(stamp, UTC).strftime("%Y-%m-%dT%H:%M:%SZ")
    return f"{stamp:.0f} s of the log's clock"
