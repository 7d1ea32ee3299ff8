"""The rows of a cycle's CSV file, read line by line so that junk is noticed early."""

from __future__ import annotations

import csv
import gzip
import zlib
from array import array
from collections.abc import Iterator
from contextlib import AbstractContextManager, nullcontext
from difflib import get_close_matches
from pathlib import Path
from typing import NamedTuple, NoReturn, TextIO, cast

from rcc_sim.errors import InputError

SUFFIXES = (".csv", ".csv.gz")
"""Endings of cycle files."""

SPEED_COLUMNS = ("speed_mps", "speed_ref_mps")
"""Columns that serve as the speed; the first that is there. [m/s]"""

LINE_LIMIT = 65_536
"""Longest line that is still taken for a table's. [characters]"""

NEEDED = "a cycle needs the columns time_s (s) and speed_mps (m/s)"


class Rows(NamedTuple):
    """The columns of a file, and the line that each row stood on.

    Attributes
    ----------
    time, speed : array of double
        Numbers as they were written; not checked against each other. [s], [m/s]
    line : array of int
        Line in the file, counted from 1.
    speed_column : str
        The column that the speed was read from.
    others : tuple of str
        Columns that no cycle has.
    """

    time: array[float]
    speed: array[float]
    line: array[int]
    speed_column: str
    others: tuple[str, ...]


def read_rows(source: str | Path | TextIO, where: str) -> Rows:
    """Read time and speed from a path or a text stream.

    Parameters
    ----------
    source : str, Path or TextIO
        UTF-8 text, with or without byte order mark; a path may end in ``.gz``.
    where : str
        What errors call it.

    Returns
    -------
    rows : Rows

    Raises
    ------
    InputError
        If it cannot be opened, is no text, has no header with the columns, or has a
        row with a word for a number or another count of cells than the header.
    """
    try:
        with _opened(source) as stream:
            return _parse(stream, where)
    except UnicodeDecodeError:
        hint = "save it as CSV in UTF-8; a car's log: `rccsim convert LOG > log.csv`"
        raise InputError(f"{where}: should be text in UTF-8", hint) from None
    except (gzip.BadGzipFile, zlib.error, EOFError) as error:
        raise InputError(f"{where}: should be a whole gzip file: {error}") from None
    except csv.Error as error:
        raise InputError(f"{where}: should be a CSV table: {error}") from None
    except OSError as error:
        raise InputError(
            f"{where}: cannot be read: {error.strerror or error}"
        ) from None


def _opened(source: str | Path | TextIO) -> AbstractContextManager[TextIO]:
    if not isinstance(source, (str, Path)):
        return nullcontext(source)
    path = Path(source)
    if path.suffix == ".gz":
        stream = gzip.open(path, "rt", encoding="utf-8-sig", newline="")  # noqa: SIM115
        return cast(TextIO, stream)
    return path.open(encoding="utf-8-sig", newline="")


def _parse(stream: TextIO, where: str) -> Rows:
    reader = csv.reader(_lines(stream, where))
    header = next((row for row in reader if any(cell.strip() for cell in row)), None)
    if header is None:
        raise InputError(f"{where}: should not be empty", NEEDED)
    columns = [cell.strip() for cell in header]
    i_time, i_speed = _columns(columns, where, reader.line_num)
    width = max(i_time, i_speed) + 1
    others = tuple(c for i, c in enumerate(columns) if i not in (i_time, i_speed))
    rows = Rows(array("d"), array("d"), array("q"), columns[i_speed], others)
    for row in reader:
        if len(row) != len(columns) or not row[i_time].strip():
            if not any(cell.strip() for cell in row):
                continue
            _check_width(row, columns, width, f"{where}: line {reader.line_num}")
        try:
            time, speed = float(row[i_time]), float(row[i_speed])
        except ValueError:
            at = f"{where}: line {reader.line_num}"
            _refuse_word(row, columns, (i_time, i_speed), at)
        rows.time.append(time)
        rows.speed.append(speed)
        rows.line.append(reader.line_num)
    return rows


def _check_width(row: list[str], columns: list[str], width: int, at: str) -> None:
    """Refuse a row that lacks a column, or has cells beyond the header's."""
    beyond = any(cell.strip() for cell in row[len(columns) :])
    if len(row) < width or beyond:
        rule = f"should have {len(columns)} cells, as the header has"
        hint = "part the cells by commas, and decimals by a point"
        raise InputError(f"{at}: {rule}: {len(row)}", hint)


def _lines(stream: TextIO, where: str) -> Iterator[str]:
    """Lines of a text, refusing what no table has before all of it is in memory."""
    number = 0
    while line := stream.readline(LINE_LIMIT):
        number += 1
        if "\0" in line or len(line) == LINE_LIMIT:
            found = "bytes that are none" if "\0" in line else "a line without end"
            raise InputError(f"{where}: line {number}: should be text: {found}", NEEDED)
        yield line.removeprefix("\ufeff") if number == 1 else line


def _columns(columns: list[str], where: str, line: int) -> tuple[int, int]:
    """Where the time and the speed stand in the header."""
    speed = next((name for name in SPEED_COLUMNS if name in columns), None)
    missing = [] if "time_s" in columns else ["time_s"]
    missing += [] if speed else ["speed_mps"]
    if missing or speed is None:
        listed = ", ".join(_short(name) for name in columns[:12])
        more = f" and {len(columns) - 12} more" if len(columns) > 12 else ""
        lacks = " and ".join(missing)
        raise InputError(
            f"{where}: line {line}: the header should have {lacks}: {listed}{more}",
            _mend(columns, missing),
        )
    for name in ("time_s", speed):
        if columns.count(name) > 1:
            rule = f"the header should have {name} once"
            raise InputError(f"{where}: line {line}: {rule}: {columns.count(name)}")
    return columns.index("time_s"), columns.index(speed)


def _mend(columns: list[str], missing: list[str]) -> str:
    """What is probably amiss with a header."""
    if all(_is_number(name) for name in columns if name):
        return f"there is no header; {NEEDED}"
    if len(columns) == 1 and any(sign in columns[0] for sign in ";\t"):
        return "part the columns by commas, and decimals by a point"
    low = {name.lower(): name for name in columns if name}
    for unit, signs in (("km/h", ("kmh", "kph", "km/h")), ("mph", ("mph",))):
        found = next((low[n] for n in low if any(s in n for s in signs)), None)
        if found and "speed_mps" in missing:
            factor = "divide by 3.6" if unit == "km/h" else "multiply by 0.44704"
            short = _short(found)
            return f"{short} looks like {unit}: {factor} and name it speed_mps (m/s)"
    for name in missing:
        close = get_close_matches(name, list(low), n=1, cutoff=0.7)
        if close:
            return f"did you mean {name} by {_short(low[close[0]])}? {NEEDED}"
    return NEEDED


def _refuse_word(
    row: list[str], columns: list[str], wanted: tuple[int, int], at: str
) -> NoReturn:
    column = next(i for i in wanted if not _is_number(row[i]))
    found = _short(row[column].strip())
    raise InputError(f"{at}: {columns[column]} should be a number: {found!r}")


def _is_number(cell: str) -> bool:
    try:
        float(cell)
    except ValueError:
        return False
    return True


def _short(words: str) -> str:
    return words if len(words) <= 40 else words[:37] + "..."
