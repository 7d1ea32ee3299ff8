"""`rccsim energy`: where the energy of a drive went."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from rcc_sim.cli.batches import Draws, Seed
from rcc_sim.cli.complete import vehicle_names
from rcc_sim.cli.logs import Html, Map, Plot, trace_of, write_page
from rcc_sim.cli.output import Csv, Json, Output, emit, say, sketch, warn

if TYPE_CHECKING:
    from rcc_sim.analyse.energy import EnergyReport
    from rcc_sim.trace import Trace


def register(app: typer.Typer) -> None:
    """Add the command to the app."""
    app.command("energy", epilog=EXAMPLE)(energy)


EXAMPLE = (
    "Example: rccsim simulate rcc --cycle 'udds[20:125]' -o a.csv; "
    "rccsim simulate rcc --cycle 'udds[20:125]' --lane-change-every 20 -o b.csv; "
    "rccsim energy a.csv b.csv"
)


def energy(
    traces: Annotated[
        list[str],
        typer.Argument(
            help="Traces: CSV, Parquet, or - for stdin; with --map logs of any format."
        ),
    ],
    vehicle: Annotated[
        str | None,
        typer.Option(
            help="Give the range on this vehicle's battery; whose draws they are.",
            autocompletion=vehicle_names,
        ),
    ] = None,
    from_: Annotated[
        str | None,
        typer.Option(
            "--from", help="Whose traces these are ...", autocompletion=vehicle_names
        ),
    ] = None,
    to: Annotated[
        str | None,
        typer.Option(
            "--to",
            help="... and at whose size to report them.",
            autocompletion=vehicle_names,
        ),
    ] = None,
    regimes: Annotated[
        bool, typer.Option("--regimes", help="By kind of driving, not by sink.")
    ] = False,
    map_: Map = None,
    draws: Draws = None,
    seed: Seed = 0,
    plot: Plot = None,
    html: Html = None,
    output: Output = None,
    csv: Csv = False,
    json: Json = False,
) -> None:
    """Where the energy went: ledger, Wh/km, range; several traces side by side.

    The ledger's lines sum to the energy at the battery's terminals (plus what is
    lost inside the battery, where that is modelled); one that does not close is an
    error. The first trace is what the others are compared with. With --draws and
    --vehicle each figure of a simulated trace has its interval: the draws of the
    vehicle's file are driven along the trace.
    """
    from rcc_sim.analyse.energy import energy_report, scaled_trace
    from rcc_sim.analyse.logcheck.finding import counted
    from rcc_sim.errors import InputError
    from rcc_sim.trace import read_trace

    drives = [trace_of(t, map_) if map_ else read_trace(t) for t in traces]
    if draws is not None and (from_ or to):
        raise InputError("--from and --to: do not go with --draws")
    if from_ or to:
        drives = [scaled_trace(drive, from_, to) for drive in drives]
    if draws is not None:
        _intervals(drives, vehicle, draws, seed, json=json, csv=csv, output=output)
        return
    reports = [energy_report(drive) for drive in drives]
    for report in (r for r in reports if r.bridged):
        rows_of = counted(report.bridged, "row")
        say(f"note: {report.name}: no battery power in {rows_of}: bridged")
    if plot is not None:
        from rcc_sim.report.plots import plot_energy, save

        save(plot_energy(drives, reports), plot)
        say(f"wrote {plot}")
    if html is not None:
        from rcc_sim.report.energy_page import energy_page

        write_page(energy_page(drives, reports, traces), html)
    battery = _battery(vehicle)
    table = _regime_rows(reports) if regimes else rows(*reports, **battery)
    emit(
        document(*reports, **battery),
        table,
        json=json,
        csv=csv,
        output=output,
        title=" against ".join(report.name for report in reports),
    )
    for drive in drives:
        if "battery_power_w" in drive:
            sketch(f"{drive.name} power", drive["battery_power_w"].tolist(), "W")
    if from_ and to:
        _tell_likeness(from_, to)


def _tell_likeness(from_: str, to: str) -> None:
    """Say by which groups two vehicles differ, whose energies then do as well."""
    from rcc_sim.definitions.vehicle import load_vehicle
    from rcc_sim.similitude.comparison import DIFFER
    from rcc_sim.similitude.pi import compare

    pair = compare([load_vehicle(from_), load_vehicle(to)])
    if any(row.verdict == DIFFER for row in pair.groups):
        say(
            f"note: it is the energy of {from_} at the size of {to}, not that of {to}: "
            f"{pair.verdict()}"
        )


def _intervals(
    drives: list[Trace],
    vehicle: str | None,
    draws: int,
    seed: int,
    *,
    json: bool,
    csv: bool,
    output: Path | None,
) -> None:
    from rcc_sim.analyse.energy import energy_report
    from rcc_sim.batch import uncertain
    from rcc_sim.definitions.vehicle import load_vehicle
    from rcc_sim.errors import InputError

    if vehicle is None or len(drives) > 1:
        raise InputError(
            "--draws: should go with --vehicle and a single trace",
            "the draws are those of that vehicle's file",
        )
    report = energy_report(drives[0])
    found = uncertain.drawn_energy(
        load_vehicle(vehicle), drives[0], report, draws, seed=seed
    )
    if found.failed:
        warn(f"{found.failed} of {found.count} draws are no vehicle and left out")
    document = {**_one(report, None), "draws": uncertain.document(found)}
    rows = uncertain.rows(found)
    emit(document, rows, json=json, csv=csv, output=output, title=report.name)


def _battery(vehicle: str | None) -> dict[str, Any]:
    from rcc_sim.analyse.energy import battery_capacity
    from rcc_sim.definitions.vehicle import load_vehicle

    return {"capacity_wh": battery_capacity(load_vehicle(vehicle))} if vehicle else {}


def document(*reports: EnergyReport, capacity_wh: float | None = None) -> Any:
    """Return what --json prints: one object, or the runs and their comparison."""
    from rcc_sim.analyse.energy import compared

    runs = [_one(report, capacity_wh) for report in reports]
    return (
        runs[0]
        if len(runs) == 1
        else {"runs": runs, "against_first": compared(reports)}
    )


def _one(report: EnergyReport, capacity_wh: float | None) -> dict[str, Any]:
    found: dict[str, Any] = {
        "trace": report.name,
        "energy_wh": report.energy_wh,
        "distance_m": report.distance_m,
        "duration_s": report.duration_s,
        "wh_per_km": report.wh_per_km,
        "ledger": report.ledger,
        "residual": report.residual,
        "bridged_rows": report.bridged,
        "regimes": [
            {
                "regime": r.name,
                "time_s": r.time_s,
                "distance_m": r.distance_m,
                "energy_wh": r.energy_wh,
            }
            for r in report.regimes
        ],
    }
    if capacity_wh is not None:
        found["range_km"] = report.range_km(capacity_wh)
    return found


def rows(
    *reports: EnergyReport, capacity_wh: float | None = None
) -> list[dict[str, Any]]:
    """Return the table: a line a sink, then the totals; a column a trace."""
    from rcc_sim.analyse.energy import table

    return table(reports, capacity_wh)


def _regime_rows(reports: list[EnergyReport]) -> list[dict[str, Any]]:
    from rcc_sim.analyse.energy import regime_table

    return regime_table(reports)
