"""`rccsim convert`: a log of any kind in rccsim's own columns."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from rcc_sim.cli.complete import map_names, vehicle_names
from rcc_sim.cli.output import Csv, Json, Output, emit, say, write_log
from rcc_sim.files import atomic

if TYPE_CHECKING:
    from rcc_sim.readers import Log

EXAMPLE = (
    "Example: rccsim convert ride.csv --map my_car.toml -o ride.parquet; "
    "rccsim convert ride.csv --suggest-map -o my_car.toml; "
    "rccsim convert run.mcap --vehicle f1tenth --rows-of speed_mps -o run.csv"
)


def register(app: typer.Typer) -> None:
    """Add the command to the app."""
    app.command("convert", epilog=EXAMPLE)(convert)


def convert(
    log: Annotated[
        str | None,
        typer.Argument(help="CSV, Parquet, bag, MCAP, MF4, or - for stdin."),
    ] = None,
    reader: Annotated[
        str | None, typer.Option(help="Force a reader; the file tells otherwise.")
    ] = None,
    map_: Annotated[
        str | None,
        typer.Option(
            "--map",
            help="Column map: a TOML file or a shipped name.",
            autocompletion=map_names,
        ),
    ] = None,
    vehicle: Annotated[
        str | None,
        typer.Option(
            help="Add speeds that follow from ERPM by its wheel, gear and poles; with "
            "--suggest-map, judge units and signs by this vehicle too.",
            autocompletion=vehicle_names,
        ),
    ] = None,
    rows_of: Annotated[
        str | None,
        typer.Option(
            "--rows-of",
            help="Only rows where this column has a value; others are held (commands) "
            "or interpolated there.",
            metavar="COLUMN",
        ),
    ] = None,
    suggest_map: Annotated[
        bool,
        typer.Option(
            "--suggest-map",
            help="Print a draft of a column map for a CSV file: by its header, with "
            "the units and signs that its rows give away.",
        ),
    ] = False,
    output: Output = None,
    csv: Csv = False,
    json: Json = False,
) -> None:
    """Read a log of any kind; write it in rccsim's own columns, CSV or Parquet.

    Says on stderr what was mapped, dropped and guessed; --json prints that instead of
    the rows. Every row is kept, also where time stands still or jumps. Without a log
    it lists the readers and the shipped column maps.
    """
    if log is None:
        emit(_known(), _known(), json=json, csv=csv, output=output)
        return
    if suggest_map:
        _suggest(log, vehicle, output)
        return
    found = _read(log, reader, map_, vehicle, rows_of)
    rows = _rows(found)
    if output is not None:
        _write(found, output)
    if json:
        emit(_document(found, rows), [], json=True)
        return
    if output is None and (csv or not sys.stdout.isatty()):
        from rcc_sim.trace import write_trace

        write_trace(found.trace, sys.stdout.buffer)
        sys.stdout.buffer.flush()
    elif sys.stdout.isatty():
        emit(None, rows, title=f"{found.trace.name}: {len(found.trace)} rows")
    _tell(found)


def _suggest(log: str, vehicle: str | None, output: Path | None) -> None:
    from rcc_sim.analyse.logcheck.draft import checked_draft
    from rcc_sim.definitions.vehicle import load_vehicle
    from rcc_sim.readers.plain_csv import shipped_for
    from rcc_sim.source import open_source

    car = None if vehicle is None else load_vehicle(vehicle)
    source = open_source(log)
    shipped = shipped_for(source)
    if shipped:
        text = Path(shipped.where).read_text(encoding="utf-8")
        say(f"note: {log} is read by the shipped map {shipped.name} without a --map")
    else:
        draft, unread = checked_draft(source, car)
        text = draft.toml()
        if unread:
            say(f"note: units and signs by the header alone: {unread}")
    if output is None:
        sys.stdout.write(text)
        return
    with atomic(output) as file:
        file.write(text)
    what = f"a copy of {shipped.name}" if shipped else "a draft"
    say(f"wrote {output}: {what}; look through it before it is used")


def _read(
    log: str,
    reader: str | None,
    map_: str | None,
    vehicle: str | None,
    rows_of: str | None,
) -> Log:
    from dataclasses import replace

    from rcc_sim.readers import on_one_clock, read_log, with_vehicle

    found = read_log(log, reader=reader, columns=map_)
    if vehicle is not None:
        from rcc_sim.definitions.vehicle import load_vehicle

        found = with_vehicle(found, load_vehicle(vehicle))
    if rows_of is not None:
        found = replace(found, trace=on_one_clock(found.trace, rows_of))
    return found


def _write(log: Log, output: Path) -> None:
    write_log(log.trace, output)
    say(f"wrote {output}: {len(log.trace)} rows, {len(log.trace.columns)} columns")


def _tell(log: Log) -> None:
    say(f"read {log.trace.name} as {log.reader}: {len(log.trace)} rows")
    renamed = [m.line() for m in log.mapped if not m.is_as_it_was]
    for title, lines in (
        ("mapped", renamed or ["every column by its own name"]),
        ("guessed", log.guessed),
        ("dropped", [", ".join(log.dropped)] if log.dropped else []),
        ("note", [*(flaw.line() for flaw in log.flaws), *log.notes]),
    ):
        for line in lines:
            say(f"{title}: {line}")


def _rows(log: Log) -> list[dict[str, Any]]:
    """A row a column: where from, and what is in it."""
    from rcc_sim.readers.summary import summary

    return summary(log)


def _document(log: Log, rows: list[dict[str, Any]]) -> dict[str, Any]:
    return {
        "log": log.trace.name,
        "reader": log.reader,
        "rows": len(log.trace),
        "columns": rows,
        "mapped": [m._asdict() for m in log.mapped],
        "dropped": list(log.dropped),
        "guessed": list(log.guessed),
        "notes": list(log.notes),
        "flaws": [flaw._asdict() for flaw in log.flaws],
    }


def _known() -> list[dict[str, Any]]:
    """Every reader and every shipped column map."""
    from rcc_sim.readers.summary import known

    return known()
