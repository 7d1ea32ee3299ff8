"""A trace: columns over time, measured or simulated alike."""

from __future__ import annotations

import io
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import IO, TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from rcc_sim.errors import InputError
from rcc_sim.source import Source, open_source
from rcc_sim.units import unit_of

if TYPE_CHECKING:
    import pandas as pd

DIGITS = 10
"""Significant digits, counted from a column's largest value, that a file holds."""

Array = NDArray[np.float64]


def integral_of(time: Array, rate: Array) -> Array:
    """Integral since the first row of rates (n,) or (n, k), by the trapezoidal rule."""
    steps = np.diff(time).reshape(-1, *[1] * (rate.ndim - 1))
    out = np.zeros_like(rate, dtype=float)
    np.cumsum(0.5 * (rate[1:] + rate[:-1]) * steps, axis=0, out=out[1:])
    return out


ELSEWHERE = "a log of another make: `rccsim convert LOG > log.csv`"
"""What to do with a table that is not written as ours are."""


@dataclass(frozen=True)
class Trace:
    """Time series by column name, the unit as the last part of each name.

    Parameters
    ----------
    columns : dict of ndarray, each of shape (n,)
        ``time_s`` and at least one channel; NaN where a channel has no value.
    name : str
        What reports call it.
    """

    columns: Mapping[str, Array]
    name: str = ""

    def __getitem__(self, column: str) -> Array:
        """Return a column.

        Raises
        ------
        InputError
            If the trace does not have it; lists what it has.
        """
        if column not in self.columns:
            raise InputError(
                f"{self.name or 'trace'}: no column {column}",
                f"there are {', '.join(self.columns)}",
            )
        return self.columns[column]

    def __contains__(self, column: str) -> bool:
        """Tell whether the trace has a column."""
        return column in self.columns

    def has(self, column: str) -> bool:
        """Tell whether the trace has a column with a value in it."""
        values = self.columns.get(column)
        return values is not None and bool(np.isfinite(values).any())

    def __len__(self) -> int:
        """Return the number of rows."""
        return len(self.columns["time_s"])

    def to_pandas(self) -> pd.DataFrame:
        """Return the columns as a data frame."""
        import pandas as pd

        return pd.DataFrame(dict(self.columns))


def write_trace(trace: Trace, file: IO[bytes]) -> None:
    """Write a trace as CSV, to ten significant digits; of time, from its start on."""
    from pyarrow import csv

    rounded = {
        name: _rounded(values, _start(values) if name == "time_s" else 0.0)
        for name, values in trace.columns.items()
    }
    file.write((",".join(rounded) + "\n").encode())
    options = csv.WriteOptions(include_header=False, quoting_style="none")
    csv.write_csv(_arrow(rounded), file, write_options=options)


def write_parquet(trace: Trace, file: IO[bytes]) -> None:
    """Write a trace as Parquet, in full precision."""
    from pyarrow import parquet

    parquet.write_table(_arrow(trace.columns), file)


def _arrow(columns: Mapping[str, Array]) -> Any:
    """Return columns as an Arrow table, as they lie (`pyarrow.table` loads pandas)."""
    import pyarrow

    whole = [np.ascontiguousarray(values, dtype=float) for values in columns.values()]
    arrays = [
        pyarrow.Array.from_buffers(
            pyarrow.float64(), len(values), [None, pyarrow.py_buffer(values)]
        )
        for values in whole
    ]
    return pyarrow.Table.from_arrays(arrays, names=list(columns))


def release_arrow() -> None:
    """Give back what Arrow held: a long log's table is as large as the log."""
    import pyarrow

    pyarrow.default_memory_pool().release_unused()


def from_arrow(column: Any) -> Array:
    """Return an Arrow column of floats as an array of its own, NaN where it has none.

    Arrow's own `to_numpy` loads pandas, which takes longer than to read most logs.
    """
    parts = [_floats(part) for part in column.chunks if len(part)]
    return np.concatenate(parts) if parts else np.zeros(0)


def _floats(part: Any) -> Array:
    import pyarrow

    held = [None, part.buffers()[1]]  # without what says which of them are none
    bare = pyarrow.Array.from_buffers(part.type, len(part), held, offset=part.offset)
    values: Array = np.asarray(np.from_dlpack(bare), dtype=float)
    if not part.null_count:
        return values
    known = np.from_dlpack(part.is_valid().cast("uint8"))
    return np.where(known > 0, values, np.nan)


def read_trace(
    source: str | Path, stdin: IO[bytes] | None = None, *, along: str = "time_s"
) -> Trace:
    """Read a trace in rccsim's own columns: CSV (also .gz), Parquet, or ``-``.

    ``along`` is the column that must be there and increase: time, or the distance of
    a road.

    Raises
    ------
    InputError
        Naming file and row if it is empty, lacks that column, holds words, or the
        column does not increase.
    """
    place = open_source(source, stdin)
    name = place.name
    table = _parquet(place) if place.head.startswith(b"PAR1") else _csv(place)
    columns: dict[str, Array] = {}
    try:
        names = table.column_names
    except UnicodeDecodeError:
        what = f"{name}: its header is no text in UTF-8"
        raise InputError(what, ELSEWHERE) from None
    if doubles := [column for column in names if names.count(column) > 1]:
        raise InputError(f"{name}: the column {doubles[0]} is there twice")
    for column in names:
        values = table.column(column)
        try:
            columns[column] = from_arrow(values.cast("float64"))
        except (ValueError, NotImplementedError):
            row, word = _first_word(values.to_pylist())
            raise InputError(
                f"{name}: {column}, row {row}: should be a number: {word!r}"
            ) from None
    _check_rising(columns, name, along)
    return Trace(columns, name=name)


def _start(time: Array) -> float:
    """Return where a clock starts, from which its digits are counted: Unix time."""
    known = time[np.isfinite(time)]
    return float(known[0]) if len(known) > 1 else 0.0


def _rounded(values: Array, start: float) -> Array:
    largest = np.nanmax(np.abs(values - start), initial=0.0)
    if not np.isfinite(largest) or largest == 0.0:
        return values + 0.0
    decimals = DIGITS - 1 - int(np.floor(np.log10(largest)))
    return np.round(values, decimals) + 0.0


def _csv(source: Source) -> Any:
    import pyarrow
    from pyarrow import csv

    with source.arrow_file() as stream:
        try:
            return csv.read_csv(stream)
        except pyarrow.ArrowInvalid as error:
            reason = str(error).partition("\n")[0]
            what = f"{source.name}: not a CSV table: {reason}"
            raise InputError(what, ELSEWHERE) from None


def _parquet(source: Source) -> Any:
    import pyarrow
    from pyarrow import parquet

    with source.stream() as stream:
        try:
            return parquet.read_table(io.BytesIO(stream.read()))
        except (pyarrow.ArrowInvalid, OSError) as error:
            raise InputError(f"{source.name}: a broken Parquet file: {error}") from None


def _first_word(values: list[Any]) -> tuple[int, Any]:
    for row, value in enumerate(values, start=1):
        try:
            float(value if value is not None else 0)
        except (TypeError, ValueError):
            return row, value
    return 0, None


def _check_rising(columns: Mapping[str, Array], name: str, along: str) -> None:
    if along not in columns:
        there = f"there are {', '.join(columns) or 'none'}"
        hint = ELSEWHERE if ";" in there or "\t" in there else there
        raise InputError(f"{name}: no column {along}", hint)
    values, unit = columns[along], unit_of(along)
    if len(values) == 0:
        raise InputError(f"{name}: a header and no rows")
    if np.isnan(values).any():
        row = int(np.isnan(values).argmax()) + 1
        raise InputError(f"{name}: {along}, row {row}: missing")
    back = np.flatnonzero(np.diff(values) <= 0)
    if len(back):
        k = int(back[0])
        raise InputError(
            f"{name}: {along}, row {k + 2}: should increase: {values[k + 1]:g} {unit} "
            f"after {values[k]:g} {unit}"
        )
