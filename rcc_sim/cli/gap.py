"""`rccsim gap`: where a log and the model part."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from rcc_sim.cli.batches import Dask, Jobs
from rcc_sim.cli.fleets import (
    Asked,
    By,
    Each,
    List,
    one_log,
    refuse_single,
    run_fleet,
)
from rcc_sim.cli.logs import (
    Hide,
    Html,
    Map,
    Model,
    Plot,
    Reader,
    Repeats,
    Span,
    notes_of,
    once,
    span_of,
    tell_notes,
    write_page,
)
from rcc_sim.cli.output import (
    Csv,
    Json,
    Output,
    Text,
    emit,
    emit_text,
    one_format,
    say,
)
from rcc_sim.cli.overrides import vehicle_of

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
    vehicle: Model,
    logs: Annotated[
        list[str] | None,
        typer.Argument(
            help="CSV, Parquet, bag, MCAP, MF4, or - for stdin; several, a folder or "
            "a pattern are a fleet."
        ),
    ] = None,
    hide: Hide = None,
    span: Span = None,
    back: Annotated[
        bool,
        typer.Option(
            "--back",
            help="The way back along a road: the vehicle's slope and wind come from "
            "the other side.",
        ),
    ] = False,
    on_stand: Annotated[
        bool,
        typer.Option("--on-stand", help="The wheels turn off the ground: no road."),
    ] = False,
    repeats: Repeats = None,
    reader: Reader = None,
    map_: Map = None,
    plot: Plot = None,
    html: Html = None,
    each: Each = False,
    list_: List = None,
    by: By = None,
    jobs: Jobs = 1,
    dask: Dask = None,
    output: Output = None,
    text: Text = False,
    csv: Csv = False,
    json: Json = False,
) -> None:
    """Where a log and the model part: by energy, channel, regime, stage, time.

    The model is driven by the log's commands where it holds those that the vehicle's
    controller obeys, else by the measured motion. Gaps are measured less simulated.
    A gap is none within twice u_val, which joins noise, the file's sds and the time
    step (ASME V&V 20). Nothing is fitted.
    """
    asked = Asked(
        tuple(logs or ()), each or len(logs or ()) > 1, list_, tuple(by or ()), "",
        jobs, dask or "", html, output, csv, json,
    )  # fmt: skip
    if asked.is_fleet:
        refuse_single(
            {
                "--back": back,
                "--on-stand": on_stand,
                "--repeats": repeats,
                "--span": span,
                "--plot": plot,
                "--text": text,
            }
        )
        _fleet(asked, {"vehicle": vehicle, "hide": hide, "reader": reader, "map": map_})
        return
    log = one_log(asked)
    one_format(json=json, csv=csv, text=text)
    read = [log, vehicle, *(repeats or [])]
    once([log, *(repeats or [])])
    how = {"reader": reader, "columns": map_, "span": span_of(span)}
    once_only = {"hide": hide or [], "back": back, "on_stand": on_stand}
    found = _found(log, vehicle, repeats or [], how, once_only)
    if plot is not None:
        from rcc_sim.report.gap_plot import plot_gap
        from rcc_sim.report.plots import save

        save(plot_gap(found), plot)
    if html is not None:
        from rcc_sim.report.gap_page import gap_page

        write_page(gap_page(found, read), html)
    _deliver(found, vehicle, output, text=text, csv=csv, json=json)


def _fleet(asked: Asked, options: dict[str, Any]) -> None:
    from rcc_sim.batch.fleet_rows import GAP, gap_row

    run_fleet(asked, "gap", gap_row, GAP, options)


def _found(
    log: str,
    vehicle: str,
    repeats: list[str],
    how: dict[str, Any],
    once_only: dict[str, Any],
) -> Gap:
    from rcc_sim.analyse.gap import gap
    from rcc_sim.analyse.logged import open_log
    from rcc_sim.cli.progress import progress

    car = vehicle_of(vehicle)
    logged = open_log(log, car, **how, **once_only)
    others = [open_log(name, car, **how).log for name in repeats]
    with progress("replaying", len(logged.log)) as tell:
        return gap(logged, car, repeats=others, progress=tell)


def _deliver(
    found: Gap,
    vehicle: str,
    output: Path | None,
    *,
    text: bool,
    csv: bool,
    json: bool,
) -> None:
    from rcc_sim.analyse import gap_report as report

    headline = report.headline(found, vehicle)
    notes = notes_of(found.findings, found.notes)
    if text:
        told = (headline, *(f"note: {note}" for note in notes))
        emit_text(told, report.tables(found), output)
        return
    say(headline)
    tell_notes([("", notes)])
    if output is None and sys.stdout.isatty() and not (json or csv):
        emit_text((), report.tables(found))
        return
    emit(report.document(found), report.rows(found), json=json, csv=csv, output=output)
