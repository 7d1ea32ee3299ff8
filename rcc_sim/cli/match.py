"""`rccsim match`: what would make one vehicle similar to another."""

from __future__ import annotations

from typing import Annotated

import typer

from rcc_sim.cli.complete import vehicle_names
from rcc_sim.cli.output import Csv, Json, Output, emit, say

EXAMPLE = "Example: rccsim match rcc --to r1t"


def match(
    vehicle: Annotated[
        str, typer.Argument(help="Vehicle to change.", autocompletion=vehicle_names)
    ],
    to: Annotated[
        str,
        typer.Option(
            help="Vehicle that it should be similar to.", autocompletion=vehicle_names
        ),
    ],
    arm: Annotated[
        float | None,
        typer.Option(
            help="Distance from the CG at which masses are fixed; 3/4 of the wheelbase "
            "unless given. [m]"
        ),
    ] = None,
    tolerance: Annotated[
        float, typer.Option(help="Share within which groups count as equal.", min=0)
    ] = 0.05,
    json: Json = False,
    csv: Csv = False,
    output: Output = None,
) -> None:
    """What to change on a car so that it is similar to another vehicle.

    Says which changes are out of reach and why, and what the other vehicle would have
    to be for the car, as it is, to represent it.
    """
    from rcc_sim.definitions.vehicle import load_vehicle
    from rcc_sim.similitude.match import match as matched

    result = matched(load_vehicle(vehicle), load_vehicle(to), arm, tolerance)
    emit(
        result.document(),
        result.rows(),
        json=json,
        csv=csv,
        output=output,
        shown=("key", "now", "needed", "status", "other_instead", "how"),
    )
    for line in result.lines():
        say(line)


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command(name="match", epilog=EXAMPLE)(match)
