"""A table of text: how it is written, its numbers, and what is wrong with it."""

from __future__ import annotations

import codecs
import io
import re
from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass, field
from typing import Any

from rcc_sim.errors import InputError
from rcc_sim.readers.header import fields_of, header_of
from rcc_sim.readers.log import Array, Flaw
from rcc_sim.readers.words import BLANKS, is_number
from rcc_sim.source import MAX_ROWS, Source
from rcc_sim.trace import from_arrow, release_arrow

LOOKED_AT = 200
"""Rows by which the mark of the decimals is known."""

LEFT_OUT = "left out"

SEPARATORS = (",", ";", "\t", "|")


@dataclass(frozen=True)
class TextTable:
    """A CSV file that was looked at and not read yet.

    Parameters
    ----------
    source : Source
        Where it is.
    names : tuple of str
        Of the header, blanks around them cut; the second of a name is ``NAME (2)``.
    first : tuple of str
        Fields of the first row.
    separator, encoding, decimal : str
        How it is written.
    skip : int
        Lines to the first row.
    above : int
        Of them, lines of a title above the header.
    """

    source: Source
    names: tuple[str, ...]
    first: tuple[str, ...]
    separator: str
    encoding: str
    decimal: str
    skip: int
    above: int = 0


@dataclass
class _Faults:
    """Rows with a wrong number of fields, as the parser meets them."""

    blank: int = 0
    found: list[Any] = field(default_factory=list)

    def __call__(self, row: Any) -> str:
        if not row.text.strip():
            self.blank += 1
        elif len(self.found) < 3:
            self.found.append(row)
        return "skip"


def text_table(
    source: Source,
    *,
    separator: str = "",
    encoding: str = "",
    decimal: str = "",
    skip_rows: int = 0,
) -> TextTable | None:
    """Look at a file as CSV; None if it is no text.

    What is not given is found: the separator by a first line of ``sep=;``, else by what
    the header has most of, the encoding by its mark, else UTF-8, else latin-1, a
    decimal comma by numbers that have one and none that has a point.
    """
    encoding = encoding or _encoding(source.head)
    text = source.head.decode(encoding, errors="ignore").removeprefix("\ufeff")
    if not text or any(c < " " and c not in "\t\r\n" for c in text):
        return None
    lines = text.splitlines()[skip_rows:]
    blank = next((k for k, line in enumerate(lines) if line.strip()), len(lines))
    lines = lines[blank:]
    told = re.fullmatch(r'"?sep=(.)"?,*', lines[0].strip()) if lines else None
    if told:  # by a spreadsheet, to itself
        separator, blank, lines = separator or told[1], blank + 1, lines[1:]
    if not lines:
        return None
    separator = separator or _separator(lines)
    names, above, own = header_of(lines, separator, first=skip_rows > 0)
    rows = [line for line in lines[above + own :] if line.strip()]
    first = fields_of(rows[0], separator) if rows else []
    if len(first) == len(names) + 1 and not first[-1]:
        names.append("")  # every row ends in a separator, and the header does not
    elif len(first) == len(names) - 1 and not names[-1]:
        names.pop()
    return TextTable(
        source=source,
        names=tuple(_distinct(names)),
        first=tuple(first),
        separator=separator,
        encoding=encoding,
        decimal=decimal or _decimal(rows[:-1] or rows, separator),
        skip=skip_rows + blank + above + own,
        above=above,
    )


def _separator(lines: Sequence[str]) -> str:
    """Return what parts the fields: what the first line has most of, or any below."""
    near = next((x for x in lines if any(m in x for m in SEPARATORS)), lines[0])
    return max(SEPARATORS, key=near.count)


def _decimal(rows: list[str], separator: str) -> str:
    """Return the mark of the decimals in some rows: a comma only if none is a point."""
    if separator == ",":
        return "."
    fields = [f for row in rows[:LOOKED_AT] for f in fields_of(row, separator)]
    commas = any(re.fullmatch(r"[+-]?\d+,\d+([eE][+-]?\d+)?", f) for f in fields)
    points = any(re.fullmatch(r"[+-]?\d*\.\d+([eE][+-]?\d+)?", f) for f in fields)
    return "," if commas and not points else "."


def read_columns(
    table: TextTable, names: Iterable[str], text: Collection[str] = ()
) -> tuple[dict[str, Array | list[str]], list[Flaw]]:
    """Read some columns: numbers, or words where asked; and what is wrong with rows.

    Parameters
    ----------
    table : TextTable
        As found.
    names : iterable of str
        Columns to read.
    text : collection of str
        Those of them that are words.

    Raises
    ------
    InputError
        Naming file, row and column of a word among numbers, or the row that has a
        wrong number of fields.
    """
    wanted = list(names)
    faults = _Faults()
    try:
        read = _arrow(table, {n: n in text for n in wanted}, faults)
    except _conversion_error() as error:
        raise _first_word(table, [n for n in wanted if n not in text], error) from None
    flaws = _judged(table, faults)
    columns: dict[str, Array | list[str]] = {}
    while read.num_columns:
        name = read.column_names[0]
        values = read.column(0)
        read = read.remove_column(0)
        columns[name] = _words(values) if name in text else from_arrow(values)
        del values
    release_arrow()
    return columns, flaws


def _arrow(table: TextTable, words: dict[str, bool], faults: Any) -> Any:
    """Columns of the file as an Arrow table, streamed from the disk."""
    import pyarrow
    from pyarrow import csv as arrow_csv

    types = {n: pyarrow.binary() if w else pyarrow.float64() for n, w in words.items()}
    read = arrow_csv.ReadOptions(
        column_names=[name or f"\0{k}" for k, name in enumerate(table.names)],
        skip_rows=table.skip,
        encoding=table.encoding,
        block_size=1 << 22,
    )
    parse = arrow_csv.ParseOptions(
        delimiter=table.separator, invalid_row_handler=faults
    )
    convert = arrow_csv.ConvertOptions(
        column_types=types,
        include_columns=list(words),
        null_values=BLANKS,
        strings_can_be_null=False,
        check_utf8=False,
        decimal_point=table.decimal,
    )
    with table.source.arrow_file() as stream:
        try:
            found = arrow_csv.read_csv(
                stream,
                read_options=read,
                parse_options=parse,
                convert_options=convert,
            )
        except pyarrow.ArrowInvalid as error:
            if "Empty CSV" in str(error):
                raise InputError(f"{table.source.name}: a header and no rows") from None
            if "onversion error" in str(error):
                raise
            reason = str(error).partition("\n")[0]
            raise InputError(
                f"{table.source.name}: not a CSV table: {reason}"
            ) from None
    if found.num_rows > MAX_ROWS:
        raise InputError(
            f"{table.source.name}: {found.num_rows} rows: more than {MAX_ROWS}",
            "cut the log into parts",
        )
    return found


def _words(column: Any) -> list[str]:
    """Return a column's words; what is no text of the file's encoding shows as such."""
    return [word.decode("utf-8", "replace") for word in column.to_pylist()]


def _conversion_error() -> type[Exception]:
    import pyarrow

    kind: type[Exception] = pyarrow.ArrowInvalid
    return kind


def written(table: TextTable) -> list[str]:
    """Return what a person should know of how the table is written."""
    mark, notes = table.decimal, []
    if mark != ".":
        notes.append(f"numbers are read with a decimal {mark!r}")
    if table.above:
        notes.append(f"{table.above} lines above the header are passed over")
    return notes


def _judged(table: TextTable, faults: _Faults) -> list[Flaw]:
    """Return which rows were left out; raise if the table is not one."""
    blank = Flaw("blank_rows", "", f"{faults.blank} rows are blank", LEFT_OUT)
    flaws = [blank] if faults.blank else []
    if not faults.found:
        return flaws
    first = faults.found[0]
    row, last = _row_of(table, first.text)
    if last and len(faults.found) == 1 and first.actual_columns < len(table.names):
        cut = Flaw("cut_short", "", f"the last row ({row}) is cut short", LEFT_OUT)
        return [*flaws, cut]
    raise InputError(
        f"{table.source.name}: row {row}: should have {first.expected_columns} "
        f"fields, as the header has: {first.actual_columns}",
        f"the row reads: {first.text[:80]}",
    )


def _row_of(table: TextTable, text: str) -> tuple[int, bool]:
    """Number of the row with this text, and whether it is the last."""
    row, skip = 0, table.skip
    with table.source.stream() as stream:
        lines = io.TextIOWrapper(
            io.BufferedReader(stream),  # type: ignore[type-var]
            encoding=table.encoding,
            errors="replace",
            newline="",
        )
        for line in lines:
            if skip:
                skip -= 1
                continue
            row += bool(line.strip())
            if line.rstrip("\r\n") == text.rstrip("\r\n"):
                return row, not next(lines, "").strip()
    return row, True


def _first_word(table: TextTable, names: list[str], error: Exception) -> InputError:
    """Return the error that names row and column of the first word among numbers."""
    worst: tuple[int, str, str] | None = None
    for name in names:
        values = _arrow(table, {name: True}, _Faults()).column(0)
        row = 0
        for chunk in values.chunks:
            words = _words(chunk)
            bad = [k for k, w in enumerate(words) if not is_number(w, table.decimal)]
            if bad:
                found = (row + bad[0] + 1, name, words[bad[0]])
                worst = min(worst or found, found)
                break
            row += len(words)
    if worst is None:
        return InputError(f"{table.source.name}: not a table of numbers: {error}")
    return InputError(
        f"{table.source.name}: {worst[1]}, row {worst[0]}: should be a number: "
        f"{worst[2]!r}"
    )


def _distinct(names: list[str]) -> list[str]:
    seen: dict[str, int] = {}
    found = []
    for name in names:
        seen[name] = seen.get(name, 0) + 1
        found.append(f"{name} ({seen[name]})" if seen[name] > 1 and name else name)
    return found


def _encoding(head: bytes) -> str:
    if head.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        return "utf-16"
    try:
        codecs.getincrementaldecoder("utf-8")().decode(head)
    except UnicodeDecodeError:
        return "latin-1"
    return "utf-8"
