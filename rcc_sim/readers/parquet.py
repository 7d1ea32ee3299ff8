"""Parquet: rccsim's own columns, or any by a column map."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from contextlib import contextmanager
from typing import Any

from rcc_sim.errors import InputError
from rcc_sim.readers.build import (
    Report,
    assembled,
    find,
    finished,
    mapped_columns,
)
from rcc_sim.readers.column_map import ColumnMap, matching, shipped_maps
from rcc_sim.readers.log import Array, Log, Mapped
from rcc_sim.readers.worded import column_of, read_as_words
from rcc_sim.source import MAX_ROWS, Source
from rcc_sim.trace import from_arrow, release_arrow

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
    with _opened(source) as file:
        return _read(source, file, columns)


def header(source: Source) -> tuple[list[str], list[str]]:
    """Return the names of all columns, and the first row of those that hold words.

    Raises
    ------
    InputError
        If the file is broken.
    """
    from pyarrow import types

    with _opened(source) as file:
        fields = {field.name: field.type for field in file.schema_arrow}
        words = [name for name, kind in fields.items() if types.is_string(kind)]
        part = next(file.iter_batches(1, columns=words), None)
    row = part.to_pylist()[0] if part is not None and part.num_rows else {}
    return [*fields], [str(row.get(name, "")) for name in fields]


@contextmanager
def _opened(source: Source) -> Iterator[Any]:
    import pyarrow
    from pyarrow import parquet

    with source.unpacked_path(".parquet") as path:
        try:
            with parquet.ParquetFile(path) as file:
                yield file
        except (pyarrow.ArrowException, OSError) as error:
            reason = str(error).partition("\n")[0]
            where = f"{source.name}: a broken Parquet file"
            raise InputError(f"{where}: {reason}") from None


def _read(source: Source, file: Any, asked: ColumnMap | None) -> Log:
    names = list(file.schema_arrow.names)
    if file.metadata.num_rows > MAX_ROWS:
        raise InputError(
            f"{source.name}: {file.metadata.num_rows} rows: more than {MAX_ROWS}",
            "cut the log into parts",
        )
    report = Report()
    if asked is None and "time_s" in names:
        numeric = [n for n in names if _is_numeric(file.schema_arrow.field(n).type)]
        report.dropped += [n for n in names if n not in numeric]
        report.mapped += [Mapped(n, n) for n in numeric]
        ours = {n: _numbers(source, file, n) for n in numeric}
        release_arrow()
        return finished(source.name, ours, NAME, report)
    by = asked or matching(shipped_maps(), names)
    if by is None:
        raise InputError(
            f"{source.name}: no time_s column, and no shipped column map knows it",
            f"say what is what with --map (`rccsim convert {source.name} "
            f"--suggest-map` drafts one); it has {', '.join(names[:40])}",
        )
    wanted = list(dict.fromkeys(n for w in by.wanted() if (n := find(names, w))))
    read = _columns(source, file, wanted, read_as_words(by, wanted))
    report.notes += [f"column map {by.name}", *by.notes]
    report.dropped += [n for n in names if n not in wanted]
    columns = {n: column_of(by, n, values, source.name) for n, values in read.items()}
    found = mapped_columns(columns, names, by, report)
    return finished(source.name, assembled(found, [None]), NAME, report)


def _columns(
    source: Source, file: Any, names: list[str], text: Collection[str]
) -> dict[str, Array | list[str]]:
    """Return columns: those of ``text`` as words, but for stamps, others as numbers."""
    import pyarrow

    found: dict[str, Array | list[str]] = {}
    for name in names:  # one at a time: a long log's table would stand twice in memory
        stamps = pyarrow.types.is_timestamp(file.schema_arrow.field(name).type)
        words = name in text and not stamps
        found[name] = (_words if words else _numbers)(source, file, name)
    release_arrow()
    return found


def _numbers(source: Source, file: Any, name: str) -> Array:
    """Return a column as numbers; stamps in seconds since 1970."""
    import pyarrow

    values = file.read(columns=[name]).column(0)
    if pyarrow.types.is_timestamp(values.type):
        stamps = values.cast(pyarrow.timestamp("ns")).cast("int64")
        return from_arrow(stamps.cast("float64", safe=False)) / 1e9
    try:
        return from_arrow(values.cast("float64", safe=False))
    except (ValueError, NotImplementedError):
        raise InputError(
            f"{source.name}: {name}: should be numbers: {values.type}"
        ) from None


def _words(source: Source, file: Any, name: str) -> list[str]:
    """Return a column as words, empty where it has none; of truths true and false."""
    values = file.read(columns=[name]).column(0).to_pylist()
    told = {None: "", True: "true", False: "false"}
    return [told[v] if v is None or isinstance(v, bool) else str(v) for v in values]


def _is_numeric(kind: Any) -> bool:
    from pyarrow import types

    return bool(
        types.is_floating(kind)
        or types.is_integer(kind)
        or types.is_boolean(kind)
        or types.is_timestamp(kind)
    )
