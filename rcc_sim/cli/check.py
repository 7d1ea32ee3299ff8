"""`rccsim check`: is a log sound?"""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING, Annotated

import typer

from rcc_sim.cli.complete import vehicle_names
from rcc_sim.cli.output import Csv, Json, Output, emit, say

if TYPE_CHECKING:
    from rcc_sim.analyse.logcheck import Checked


def register(app: typer.Typer) -> None:
    """Add the command to the app."""
    app.command("check", epilog=EXAMPLE)(check)


EXAMPLE = (
    "Example: rccsim simulate rcc --cycle 'udds[20:125]' -o drive.csv; "
    "rccsim check drive.csv --vehicle rcc"
)


def check(
    logs: Annotated[
        list[str], typer.Argument(help="Logs: CSV, Parquet, or - for stdin.")
    ],
    vehicle: Annotated[
        str | None,
        typer.Option(
            help="Judge motor speed, voltage and power by this vehicle too.",
            autocompletion=vehicle_names,
        ),
    ] = None,
    strict: Annotated[
        bool, typer.Option("--strict", help="Exit 1 if a log is not sound.")
    ] = False,
    output: Output = None,
    csv: Csv = False,
    json: Json = False,
) -> None:
    """Is the log sound: time base, units, signs, sensors.

    Each finding says what, where, how sure, and what rccsim does about it. A note
    (info) is good to know; after a warning some rows are left out; a channel with an
    error would be wrong to use. Nothing is silently repaired.
    """
    from rcc_sim.analyse.logcheck import report

    checks = _checked(logs, vehicle)
    for checked in checks:
        say(report.verdict(checked))
    read = sys.stdout.isatty() and not (json or csv or output)
    rows = report.shown(checks) if read else report.rows(checks)
    emit(report.document(checks), rows, json=json, csv=csv, output=output)
    if strict:
        _insist(checks)


def _checked(logs: list[str], vehicle: str | None) -> list[Checked]:
    from rcc_sim.analyse.logcheck import check_reading
    from rcc_sim.definitions.vehicle import load_vehicle
    from rcc_sim.readers import read_log

    judge = load_vehicle(vehicle) if vehicle else None
    return [check_reading(read_log(log), judge) for log in logs]


def _insist(checks: list[Checked]) -> None:
    from rcc_sim.analyse.logcheck.report import is_sound
    from rcc_sim.errors import CheckFailed

    bad = [checked.trace.name for checked in checks if not is_sound(checked)]
    if bad:
        raise CheckFailed(f"not sound: {', '.join(bad)}")
