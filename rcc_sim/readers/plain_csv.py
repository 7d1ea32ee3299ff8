"""CSV with columns of any name, by a column map."""

from __future__ import annotations

import numpy as np

from rcc_sim.errors import InputError
from rcc_sim.readers.build import (
    Report,
    assembled,
    find,
    finished,
    mapped_columns,
)
from rcc_sim.readers.column_map import (
    ColumnMap,
    matching,
    nearest,
    shipped_maps,
)
from rcc_sim.readers.csv_table import (
    TextTable,
    read_columns,
    text_table,
    written,
)
from rcc_sim.readers.log import Array, Log, Mapped
from rcc_sim.readers.worded import column_of, read_as_words
from rcc_sim.source import Source

NAME = "csv"
SUMMARY = "CSV of any columns, by a column map (--map); some maps are shipped"


def sniff(source: Source) -> bool:
    """Whether it is text with a header that a shipped map knows, or like a table."""
    table = text_table(source)
    return table is not None and (
        shipped_for(source) is not None or len(table.names) > 1
    )


def read(source: Source, columns: ColumnMap | None = None) -> Log:
    """Read it by the map, or by the shipped map whose header it has.

    Raises
    ------
    InputError
        If no map fits, or as in `read_columns`, `mapped_columns` and `finished`.
    """
    by = columns or shipped_for(source)
    table = _table(source, by)
    if by is None:
        raise _unknown(source, table)
    report = Report(notes=[f"column map {by.name}", *by.notes])
    names = [n for n in table.names if n]
    wanted = list(dict.fromkeys(n for w in by.wanted() if (n := find(names, w))))
    if not wanted and by.shipped:
        raise InputError(
            f"{source.name}: has none of the columns that the map {by.name} names",
            f"it has {', '.join(names[:40])}",
        )
    text = read_as_words(by, wanted)
    parsed, flaws = read_columns(table, wanted, text=text) if wanted else ({}, [])
    report.flaws += flaws
    report.notes += written(table)
    read = {n: column_of(by, n, v, source.name) for n, v in parsed.items()}
    report.dropped += [n for n in names if n not in wanted]
    found = mapped_columns(read, names, by, report)
    clock = _counted(by, found, report)
    return finished(source.name, assembled(found, [clock]), NAME, report)


def shipped_for(source: Source) -> ColumnMap | None:
    """The shipped map whose header the file has."""
    table = text_table(source)
    return None if table is None else matching(_maps(), table.names)


def _maps() -> list[ColumnMap]:
    return [m for m in shipped_maps() if m.format == "csv"]


def _table(source: Source, by: ColumnMap | None) -> TextTable:
    table = (
        text_table(source)
        if by is None
        else text_table(
            source,
            separator=by.separator,
            encoding=by.encoding,
            decimal=by.decimal,
            skip_rows=by.skip_rows,
        )
    )
    if table is None:
        raise InputError(f"{source.name}: not a CSV table")
    return table


def _counted(
    by: ColumnMap, found: list[tuple[str, int, Array]], report: Report
) -> Array | None:
    """Clock of a file that has none, by its rate."""
    if not by.rate_hz or not found or any(name == "time_s" for name, _, _ in found):
        return None
    report.mapped.insert(0, Mapped("time_s", "row number", 1 / by.rate_hz))
    report.guessed.append(f"time_s: no clock in the file; {by.rate_hz:g} rows a second")
    return np.arange(len(found[0][2])) / by.rate_hz


def _unknown(source: Source, table: TextTable) -> InputError:
    names = ", ".join(n for n in table.names[:40] if n)
    like = nearest(_maps(), table.names)
    draft = "--map FILE.toml"
    if like:
        lacks = ", ".join(n for n in like.header if n not in table.names)
        draft = f"--map {like.name}, whose header it has but for {lacks}, or --map FILE"
    return InputError(
        f"{source.name}: no time_s column, and no shipped column map knows this header",
        f"say what is what with {draft} (`rccsim convert {source.name} "
        f"--suggest-map` drafts one); the columns are: {names}",
    )
