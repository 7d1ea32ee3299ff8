"""`rccsim scale`: a quantity of one vehicle at the size of another."""

from __future__ import annotations

from typing import Annotated

import typer

from rcc_sim.cli.complete import vehicle_names
from rcc_sim.cli.output import Csv, Json, Output, emit

EXAMPLE = (
    "Example: rccsim scale speed 25.3 --from r1t --to rcc; rccsim scale "
    "battery_power_w 40000 --from r1t --to rcc"
)


def scale(
    quantity: Annotated[
        str,
        typer.Argument(help="speed, time, energy_per_distance, …, or a column's name."),
    ],
    value: Annotated[float, typer.Argument(help="Of the vehicle --from. [SI]")],
    source: Annotated[
        str,
        typer.Option(
            "--from", help="Vehicle that it is known of.", autocompletion=vehicle_names
        ),
    ],
    target: Annotated[
        str,
        typer.Option(
            "--to", help="Vehicle that it is wanted for.", autocompletion=vehicle_names
        ),
    ],
    json: Json = False,
    csv: Csv = False,
    output: Output = None,
) -> None:
    """Scale a quantity from one vehicle to another, so that its π-group stays."""
    from rcc_sim.definitions.vehicle import load_vehicle
    from rcc_sim.similitude.scale import scaled_quantity

    result = scaled_quantity(
        quantity, value, to=load_vehicle(target), of=load_vehicle(source)
    )
    emit(result, [result], json=json, csv=csv, output=output)


def register(app: typer.Typer) -> None:
    """Add the command; a value may be negative."""
    app.command(
        name="scale", epilog=EXAMPLE, context_settings={"ignore_unknown_options": True}
    )(scale)
