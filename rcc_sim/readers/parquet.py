"""Parquet: rccsim's own columns, or any by a column map."""

from __future__ import annotations

from typing import Any

from rcc_sim.errors import InputError
from rcc_sim.readers.build import (
    Column,
    Report,
    assembled,
    find,
    finished,
    mapped_columns,
)
from rcc_sim.readers.column_map import ColumnMap, matching, shipped_maps
from rcc_sim.readers.log import Array, Log, Mapped
from rcc_sim.source import MAX_ROWS, Source
from rcc_sim.trace import from_arrow

NAME = "parquet"
SUMMARY = "Parquet, in rccsim's own columns or by a column map"


def sniff(source: Source) -> bool:
    """Whether it begins as Parquet does."""
    return source.head.startswith(b"PAR1")


def read(source: Source, columns: ColumnMap | None = None) -> Log:
    """Read it by the map, or by its own names if it has ``time_s``.

    Raises
    ------
    InputError
        If the file is broken, too long or unknown, or as `finished`.
    """
    import pyarrow
    from pyarrow import parquet

    with source.unpacked_path(".parquet") as path:
        try:
            with parquet.ParquetFile(path) as file:
                return _read(source, file, columns)
        except (pyarrow.ArrowException, OSError) as error:
            reason = str(error).partition("\n")[0]
            raise InputError(
                f"{source.name}: a broken Parquet file: {reason}"
            ) from None


def _read(source: Source, file: Any, columns: ColumnMap | None) -> Log:
    names = list(file.schema_arrow.names)
    if file.metadata.num_rows > MAX_ROWS:
        raise InputError(
            f"{source.name}: {file.metadata.num_rows} rows: more than {MAX_ROWS}",
            "cut the log into parts",
        )
    report = Report()
    if columns is None and "time_s" in names:
        numeric = [n for n in names if _is_numeric(file.schema_arrow.field(n).type)]
        report.dropped += [n for n in names if n not in numeric]
        report.mapped += [Mapped(n, n) for n in numeric]
        return finished(source.name, _columns(source, file, numeric), NAME, report)
    by = columns or matching(shipped_maps(), names)
    if by is None:
        raise InputError(
            f"{source.name}: no time_s column, and no shipped column map knows it",
            f"say what is what with --map; it has {', '.join(names[:40])}",
        )
    wanted = list(dict.fromkeys(n for w in by.wanted() if (n := find(names, w))))
    read = _columns(source, file, wanted)
    report.notes += [f"column map {by.name}", *by.notes]
    report.dropped += [n for n in names if n not in wanted]
    found = mapped_columns(
        {name: Column(values) for name, values in read.items()}, names, by, report
    )
    return finished(source.name, assembled(found, [None]), NAME, report)


def _columns(source: Source, file: Any, names: list[str]) -> dict[str, Array]:
    import pyarrow

    found: dict[str, Array] = {}
    for name in names:  # one at a time: a long log's table would stand twice in memory
        values = file.read(columns=[name]).column(0)
        if pyarrow.types.is_timestamp(values.type):
            stamps = values.cast(pyarrow.timestamp("ns")).cast("int64")
            found[name] = from_arrow(stamps.cast("float64", safe=False)) / 1e9
            continue
        try:
            found[name] = from_arrow(values.cast("float64", safe=False))
        except (ValueError, NotImplementedError):
            raise InputError(
                f"{source.name}: {name}: should be numbers: {values.type}"
            ) from None
    pyarrow.default_memory_pool().release_unused()
    return found


def _is_numeric(kind: Any) -> bool:
    from pyarrow import types

    return bool(
        types.is_floating(kind)
        or types.is_integer(kind)
        or types.is_boolean(kind)
        or types.is_timestamp(kind)
    )
