"""What a command prints: data on stdout, everything else on stderr."""

from __future__ import annotations

import csv as csv_format
import json as json_format
import math
import sys
from collections.abc import Iterable, Mapping, Sequence
from contextlib import nullcontext
from pathlib import Path
from typing import IO, TYPE_CHECKING, Annotated, Any, cast

import typer

from rcc_sim.cli.table import print_table
from rcc_sim.errors import InputError
from rcc_sim.files import atomic
from rcc_sim.report.text import printable as printable
from rcc_sim.report.text import sparkline

if TYPE_CHECKING:
    from rcc_sim.trace import Trace

LEAST_SKETCH = 15
"""Columns below which a line of bars shows nothing."""

FOREIGN = (
    *(".xlsx", ".xls", ".ods", ".feather", ".h5", ".mat", ".mf4", ".zip"),
    *(".png", ".svg", ".pdf", ".html"),
)
"""Endings of files that ``--output`` never writes."""


def not_foreign(path: Path | None) -> Path | None:
    """Return a file to write; raise where its name promises what it would not hold."""
    if path is not None and path.suffix.lower() in FOREIGN:
        raise InputError(
            f"{path}: {path.suffix} is not written",
            f"CSV, which spreadsheets read, would be {path.with_suffix('.csv')}",
        )
    return path


Rows = Sequence[Mapping[str, Any]]
Json = Annotated[bool, typer.Option("--json", help="Print one JSON object.")]
Csv = Annotated[bool, typer.Option("--csv", help="Print CSV (the default when piped).")]
Text = Annotated[
    bool,
    typer.Option("--text", help="Print what a terminal shows where piped, or to -o."),
]
Output = Annotated[
    Path | None,
    typer.Option(
        "--output",
        "-o",
        help="Write to this file, whole or not at all.",
        metavar="FILE",
        callback=not_foreign,
    ),
]


def one_format(*, json: bool, csv: bool, text: bool = False, hint: str = "") -> None:
    """Raise if two formats are asked for: before long work, rather than after."""
    asked = {"--text": text, "--json": json, "--csv": csv}
    given = [option for option, is_asked in asked.items() if is_asked]
    if len(given) > 1:
        raise InputError(f"{' and '.join(given)}: one of them", hint)


def emit(
    document: Any,
    rows: Rows,
    *,
    json: bool = False,
    csv: bool = False,
    text: bool = False,
    output: Path | None = None,
    title: str = "",
    shown: Sequence[str] = (),
) -> None:
    """Write a result: JSON, CSV, or a table where a person looks on.

    Parameters
    ----------
    document : object
        What ``--json`` prints, whole.
    rows : sequence of mapping
        The same as rows, for the table and for CSV.
    text : bool
        Write the table wherever it goes.
    output : Path or None
        File to write in place of stdout; JSON where its name ends so.
    title : str
        Line above the table.
    shown : sequence of str
        Columns that the table on a terminal shows; all of them unless given.

    Raises
    ------
    InputError
        If two formats are asked for, or the file cannot be written.
    """
    one_format(json=json, csv=csv, text=text)
    if text or (output is None and not (json or csv) and sys.stdout.isatty()):
        part = [{key: row[key] for key in shown} for row in rows] if shown else rows
        emit_text((), [(title, part)], output)
        return
    if output is None:
        _write(sys.stdout, document, rows, json)
        sys.stdout.flush()
        return
    named = output.suffix.lower() == ".json" and not csv
    with atomic(output) as file:
        _write(file, document, rows, json or named)


def emit_text(
    lines: Iterable[str],
    tables: Iterable[tuple[str, Rows]] = (),
    output: Path | None = None,
) -> None:
    """Write what a terminal shows, lines and titled tables, to stdout or a file."""
    with nullcontext(sys.stdout) if output is None else atomic(output) as file:
        file.writelines(f"{printable(line)}\n" for line in lines)
        for title, table in tables:
            if title or table:
                print_table(table, title, readable, printable, file)


def _write(file: IO[str], document: Any, rows: Rows, json: bool) -> None:
    if json:
        file.write(json_format.dumps(_plain(document), indent=1, allow_nan=False))
        file.write("\n")
        return
    if rows:
        writer = csv_format.writer(file, lineterminator="\n")
        writer.writerow(rows[0].keys())
        writer.writerows([_cell(value) for value in row.values()] for row in rows)


def write_log(trace: Trace, output: Path) -> None:
    """Write a trace: CSV, packed if its name ends in .gz, or Parquet.

    Raises
    ------
    InputError
        If the name ends in anything else, or the file cannot be written.
    """
    import gzip

    from rcc_sim.trace import write_parquet, write_trace

    if output.suffix not in ("", ".csv", ".txt", ".gz", ".parquet"):
        raise InputError(
            f"{output}: should end in .csv, .csv.gz or .parquet",
            "what a car plays is written by scale-cycle --format mcap",
        )
    with atomic(output, "wb") as file:
        if output.suffix == ".parquet":
            write_parquet(trace, file)
        elif output.suffix == ".gz":
            with gzip.GzipFile("", "wb", fileobj=file, mtime=0) as packed:
                write_trace(trace, cast("IO[bytes]", packed))
        else:
            write_trace(trace, file)


def say(message: str) -> None:
    """Tell the person at the keyboard something that is not data.

    On a terminal a line is broken between words, the rest a little to the right.
    """
    text = printable(message)
    if sys.stderr.isatty():
        text = "\n".join(folded(line) for line in text.split("\n"))
    sys.stderr.write(text + "\n")


def say_error(message: str, hint: str = "") -> None:
    """Tell what is wrong, in one line, and the likely mend."""
    say(f"error: {' '.join(message.split())}")
    if hint:
        say(f"hint: {hint}")


def folded(line: str) -> str:
    """Return a line broken between words at the terminal's width."""
    import textwrap
    from shutil import get_terminal_size

    width = max(get_terminal_size().columns, LEAST_SKETCH)
    if len(line) <= width:
        return line
    inner = " " * (len(line) - len(line.lstrip()) + 2)
    return textwrap.fill(
        line,
        width,
        subsequent_indent=inner,
        break_long_words=False,
        break_on_hyphens=False,
    )


def sketch(what: str, values: Sequence[float], unit: str) -> None:
    """Draw values over time in one line, for the person at the terminal alone."""
    if not (sys.stderr.isatty() and sys.stdout.isatty()):
        return
    from shutil import get_terminal_size

    low, high = min(values, default=0.0), max(values, default=0.0)
    told = f"{printable(what)}, {readable(low)} to {readable(high)} {unit}: "
    room = get_terminal_size().columns - len(told) - 1
    if room >= LEAST_SKETCH and "utf" in (sys.stderr.encoding or "").lower():
        say(told + sparkline(values, room))


def warn(message: str) -> None:
    """Tell the person at the keyboard what to beware of."""
    say(f"warning: {message}")


def _plain(value: Any) -> Any:
    """Return what JSON can hold: no NaN, no infinity, no numpy scalar."""
    if isinstance(value, Mapping):
        return {str(k): _plain(v) for k, v in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(v) for v in value]
    if hasattr(value, "item") and not isinstance(value, str):
        value = value.item()
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value


def _cell(value: Any) -> Any:
    if value is None:
        return ""
    if isinstance(value, float):
        return f"{value:.9g}"
    return printable(str(value))


def readable(value: Any) -> str:
    """Return a cell as a person reads it: four figures, no noise."""
    if value is None:
        return "–"
    if isinstance(value, float):
        short = f"{value:.4g}"
        return f"{value:.0f}" if "e+" in short and abs(value) < 1e7 else short
    return printable(str(value))
