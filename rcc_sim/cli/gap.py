"""`rccsim gap`: where a log and the model part."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from rcc_sim.cli.complete import column_names, map_names, vehicle_names
from rcc_sim.cli.output import Csv, Json, Output, atomic, emit, say

if TYPE_CHECKING:
    from rcc_sim.analyse.gap import Gap

EXAMPLE = (
    "Example: rccsim simulate rcc --cycle 'udds[20:125]' --with "
    "rolling_resistance:coefficient=0.02 -o drive.csv; "
    "rccsim gap drive.csv --vehicle rcc"
)


def register(app: typer.Typer) -> None:
    """Add the command to the app."""
    app.command("gap", epilog=EXAMPLE)(gap)


def gap(
    log: Annotated[
        str, typer.Argument(help="CSV, Parquet, bag, MCAP, MF4, or - for stdin.")
    ],
    vehicle: Annotated[
        str,
        typer.Option(help="The model: a name or file.", autocompletion=vehicle_names),
    ],
    hide: Annotated[
        list[str] | None,
        typer.Option(
            help="Leave a logged column out; repeatable.",
            metavar="COLUMN",
            autocompletion=column_names,
        ),
    ] = None,
    repeats: Annotated[
        list[str] | None,
        typer.Option(
            help="Another log of the same drive, to know the noise by; repeatable.",
            metavar="LOG",
        ),
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
    plot: Annotated[
        Path | None, typer.Option(help="Draw it: PNG, SVG or PDF.", metavar="F")
    ] = None,
    html: Annotated[
        Path | None, typer.Option(help="Write it as one HTML page.", metavar="F")
    ] = None,
    output: Output = None,
    csv: Csv = False,
    json: Json = False,
) -> None:
    """Where a log and the model part: by energy, channel, regime, stage, time.

    The model is driven by the log's commands where it holds those that the vehicle's
    controller obeys, else by the measured motion. Gaps are measured less simulated.
    A gap is none within twice u_val, which joins noise, the file's sds and the time
    step (ASME V&V 20). Nothing is fitted.
    """
    found = _found(log, vehicle, hide or [], repeats or [], reader, map_)
    if plot is not None:
        from rcc_sim.report.gap_plot import plot_gap
        from rcc_sim.report.plots import save

        save(plot_gap(found), plot)
    if html is not None:
        _write_page(html, found, [log, vehicle, *(repeats or [])])
    _deliver(found, output, csv=csv, json=json)


def _write_page(html: Path, found: Gap, inputs: list[str]) -> None:
    from rcc_sim.report.gap_page import gap_page
    from rcc_sim.report.html import write_html

    page = gap_page(found, inputs)
    with atomic(html) as file:
        write_html(page, file)
    say(f"wrote {html}")


def _found(
    log: str,
    vehicle: str,
    hide: list[str],
    repeats: list[str],
    reader: str | None,
    map_: str | None,
) -> Gap:
    from rcc_sim.analyse.gap import gap
    from rcc_sim.analyse.logged import open_log
    from rcc_sim.cli.progress import progress
    from rcc_sim.definitions.vehicle import load_vehicle

    car = load_vehicle(vehicle)
    logged = open_log(log, car, reader=reader, columns=map_, hide=hide)
    others = [open_log(name, car, reader=reader, columns=map_).log for name in repeats]
    with progress("replaying", len(logged.log)) as tell:
        return gap(logged, car, repeats=others, progress=tell)


def _deliver(found: Gap, output: Path | None, *, csv: bool, json: bool) -> None:
    from rcc_sim.analyse import gap_report as report

    say(report.headline(found))
    for note in (*_beware(found), *found.notes):
        say(f"note: {note}")
    if output is None and sys.stdout.isatty() and not (json or csv):
        for title, table in report.tables(found):
            emit(None, table, title=title)
        return
    emit(report.document(found), report.rows(found), json=json, csv=csv, output=output)


def _beware(found: Gap) -> list[str]:
    """Return what was found wrong with the log, worse than a note."""
    return [
        f"{finding.channel} {finding.what}; {finding.action}"
        for finding in found.findings
        if finding.severity != "info"
    ]
