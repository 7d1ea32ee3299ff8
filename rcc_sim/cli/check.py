"""`rccsim check`: is a log sound?"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from rcc_sim.cli.batches import Dask, Jobs
from rcc_sim.cli.complete import vehicle_names
from rcc_sim.cli.fleets import (
    Asked,
    By,
    Each,
    List,
    one_log,
    refuse_single,
    run_fleet,
)
from rcc_sim.cli.logs import Map, Reader
from rcc_sim.cli.output import (
    Csv,
    Json,
    Output,
    Text,
    emit,
    emit_text,
    one_format,
    say,
    say_error,
)
from rcc_sim.cli.overrides import vehicle_of

if TYPE_CHECKING:
    from rcc_sim.analyse.logcheck import Checked
    from rcc_sim.errors import InputError


def register(app: typer.Typer) -> None:
    """Add the command to the app."""
    app.command("check", epilog=EXAMPLE)(check)


EXAMPLE = (
    "Example: rccsim simulate rcc --cycle 'udds[20:125]' -o drive.csv; "
    "rccsim check drive.csv --vehicle rcc"
)


def check(
    logs: Annotated[
        list[str] | None,
        typer.Argument(
            help="Logs of any format, or - for stdin; with --each, or as a folder or "
            "a pattern, a fleet."
        ),
    ] = None,
    vehicle: Annotated[
        str | None,
        typer.Option(
            help="Judge motor speed, voltage and power by this vehicle too.",
            autocompletion=vehicle_names,
        ),
    ] = None,
    reader: Reader = None,
    map_: Map = None,
    strict: Annotated[
        bool, typer.Option("--strict", help="Exit 1 if a log is not sound.")
    ] = False,
    each: Each = False,
    list_: List = None,
    by: By = None,
    jobs: Jobs = 1,
    dask: Dask = None,
    html: Annotated[
        Path | None,
        typer.Option(help="Write a fleet as one HTML page.", metavar="F"),
    ] = None,
    output: Output = None,
    text: Text = False,
    csv: Csv = False,
    json: Json = False,
) -> None:
    """Is the log sound: time base, units, signs, sensors.

    Each finding says what, where, how sure, and what rccsim does about it. A note
    (info) is good to know; after a warning some rows are left out; a channel with an
    error would be wrong to use. Nothing is silently repaired.
    """
    from rcc_sim.errors import InputError

    asked = Asked(
        tuple(logs or ()), each, list_, tuple(by or ()), "", jobs, dask or "", html,
        output, csv, json,
    )  # fmt: skip
    if asked.is_fleet:
        refuse_single({"--text": text})
        options = {"vehicle": vehicle, "reader": reader, "map": map_}
        _fleet(asked, options, strict=strict)
        return
    one_log(asked)
    one_format(json=json, csv=csv, text=text)
    if html is not None:
        raise InputError("--html: belongs to a fleet", "add --each")
    checks, broken = _checked(logs or [], vehicle, reader, map_)
    if checks:
        _deliver(checks, output, text=text, csv=csv, json=json)
    if broken:
        for log, error in broken[:-1]:
            say_error(f"{log}: {str(error).removeprefix(f'{log}: ')}")
        raise broken[-1][1]
    if strict:
        _insist(checks)


def _deliver(
    checks: list[Checked], output: Path | None, *, text: bool, csv: bool, json: bool
) -> None:
    from rcc_sim.analyse.logcheck import report

    verdicts = [report.verdict(checked) for checked in checks]
    if text:
        emit_text(verdicts, [("", report.shown(checks))], output)
        return
    for verdict in verdicts:
        say(verdict)
    read = sys.stdout.isatty() and not (json or csv or output)
    rows = report.shown(checks) if read else report.rows(checks)
    emit(report.document(checks), rows, json=json, csv=csv, output=output)


def _fleet(asked: Asked, options: dict[str, Any], *, strict: bool) -> None:
    from rcc_sim.batch.fleet_rows import CHECK, check_row
    from rcc_sim.errors import CheckFailed

    found = run_fleet(asked, "check", check_row, CHECK, options)
    bad = found["logs"] - found["sound"]
    if strict and bad:
        raise CheckFailed(f"not sound: {bad:,} of {found['logs']:,} logs")


def _checked(
    logs: list[str], vehicle: str | None, reader: str | None, map_: str | None
) -> tuple[list[Checked], list[tuple[str, InputError]]]:
    """Return what was found in each log, and the logs that cannot be read at all."""
    from rcc_sim.analyse.logcheck import check_reading
    from rcc_sim.errors import InputError
    from rcc_sim.readers import read_log

    judge = vehicle_of(vehicle) if vehicle else None
    found, broken = [], []
    for log in logs:
        try:
            reading = read_log(log, reader=reader, columns=map_)
            found.append(check_reading(reading, judge))
        except InputError as error:
            broken.append((log, error))
    return found, broken


def _insist(checks: list[Checked]) -> None:
    from rcc_sim.analyse.logcheck.report import is_sound
    from rcc_sim.errors import CheckFailed

    bad = [checked.trace.name for checked in checks if not is_sound(checked)]
    if bad:
        raise CheckFailed(f"not sound: {', '.join(bad)}")
