"""A log as a file holds it, in rccsim's columns, whatever its time does."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import IO

from rcc_sim.errors import InputError
from rcc_sim.trace import Trace, _bytes, _csv, _first_word, _parquet, _unzipped


def open_log(source: str | Path, stdin: IO[bytes] | None = None) -> Trace:
    """Return a log with its rows as they are: time may jump, repeat or be missing.

    Raises
    ------
    InputError
        Naming file and row if it is empty, no table, or holds words.
    """
    name = "stdin" if str(source) == "-" else str(source)
    raw = (stdin or sys.stdin.buffer).read() if name == "stdin" else _bytes(source)
    raw = _unzipped(raw, name) if raw[:2] == b"\x1f\x8b" else raw
    if not raw.strip():
        raise InputError(f"{name}: the file is empty")
    table = _parquet(raw, name) if raw[:4] == b"PAR1" else _csv(raw, name)
    columns = {}
    for column, values in zip(table.column_names, table.columns, strict=True):
        try:
            columns[column] = values.cast("float64").to_numpy()
        except (ValueError, NotImplementedError):
            row, word = _first_word(values.to_pylist())
            raise InputError(
                f"{name}: {column}, row {row}: should be a number: {word!r}"
            ) from None
    return Trace(columns, name=name)
