"""`rccsim pi`: the π-groups of vehicles side by side."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from rcc_sim.cli.complete import vehicle_names
from rcc_sim.cli.output import Csv, Json, Output, emit, say

if TYPE_CHECKING:
    from rcc_sim.definitions.vehicle import Vehicle


EXAMPLE = (
    "Example: rccsim pi rcc r1t; rccsim pi rcc --trace drive.csv --output drive_pi.csv"
)


def pi(
    vehicles: Annotated[
        list[str],
        typer.Argument(
            help="Names or files of vehicles.", autocompletion=vehicle_names
        ),
    ],
    repeating: Annotated[
        str, typer.Option(help="Three variables that span mass, length and time.")
    ] = "m,l,C_F",
    tolerance: Annotated[
        float, typer.Option(help="Share within which groups count as equal.", min=0)
    ] = 0.05,
    trace: Annotated[
        Path | None,
        typer.Option(
            help="Trace of the one vehicle to write dimensionless; - is stdin."
        ),
    ] = None,
    json: Json = False,
    csv: Csv = False,
    output: Output = None,
) -> None:
    """The thirteen π-groups of vehicles, which agree, and the scales between them.

    With --trace: time becomes pi_8_time, speed pi_9_speed, acceleration pi_2_accel_x,
    yaw rate pi_11_yaw_rate, energies pi_4_energy_…, every other quantity pi_ and its
    name, so that traces of two sizes can be laid over each other.
    """
    from rcc_sim.definitions.vehicle import load_vehicle

    chosen = [symbol.strip() for symbol in repeating.split(",")]
    loaded = [load_vehicle(name) for name in vehicles]
    if trace is not None:
        _write_trace(trace, loaded, chosen, json=json, csv=csv, output=output)
        return
    from rcc_sim.similitude.pi import compare

    result = compare(loaded, chosen, tolerance)
    emit(
        result.document(),
        result.rows(),
        json=json,
        csv=csv,
        output=output,
        shown=result.shown(),
    )
    for line in result.lines():
        say(line)


def _write_trace(
    trace: Path,
    vehicles: list[Vehicle],
    repeating: list[str],
    *,
    json: bool,
    csv: bool,
    output: Path | None,
) -> None:
    from rcc_sim.errors import InputError
    from rcc_sim.similitude.dimensionless import dimensionless_trace
    from rcc_sim.trace import read_trace

    if len(vehicles) != 1:
        raise InputError("--trace: should go with one vehicle, the one that drove")
    found = dimensionless_trace(read_trace(trace), vehicles[0], repeating)
    rows, left_out = found.rows(), found.left_out
    if left_out:
        say(f"note: left out, no mass-length-time unit: {', '.join(left_out)}")
    document = {"vehicle": vehicles[0].name, "rows": rows, "left_out": left_out}
    emit(document, rows, json=json, csv=csv, output=output)


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command(name="pi", epilog=EXAMPLE)(pi)
