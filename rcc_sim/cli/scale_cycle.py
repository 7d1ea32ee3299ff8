"""`rccsim scale-cycle`: a full-size cycle at a car's size."""

from __future__ import annotations

import sys
from typing import Annotated

import typer

from rcc_sim.cli.complete import cycle_names, vehicle_names
from rcc_sim.cli.output import Csv, Json, Output, emit, say


def scale_cycle(
    cycle: Annotated[
        str,
        typer.Argument(
            help="Name, file, NAME[20:125], or - for stdin.", autocompletion=cycle_names
        ),
    ],
    source: Annotated[
        str,
        typer.Option(
            "--from", help="Vehicle that the cycle is of.", autocompletion=vehicle_names
        ),
    ],
    target: Annotated[
        str,
        typer.Option(
            "--to", help="Car that should drive it.", autocompletion=vehicle_names
        ),
    ],
    rate: Annotated[float | None, typer.Option(help="Rows a second. [Hz]")] = None,
    max_speed: Annotated[
        float | None, typer.Option(help="Clip at the car's speed. [m/s]")
    ] = None,
    max_accel: Annotated[
        float | None, typer.Option(help="Clip at the car's acceleration. [m/s²]")
    ] = None,
    track_length: Annotated[
        float | None, typer.Option(help="End at the last stop on this track. [m]")
    ] = None,
    json: Json = False,
    csv: Csv = False,
    output: Output = None,
) -> None:
    """A drive cycle at the car's size, and what the car cannot drive of it.

    Example: rccsim scale-cycle "udds[20:125]" --from r1t --to rcc --rate 100
    """
    from rcc_sim.definitions.cycle import parse_cycle
    from rcc_sim.definitions.vehicle import load_vehicle
    from rcc_sim.similitude.cycles import scale_cycle as scaled_cycle

    result = scaled_cycle(
        parse_cycle(cycle, sys.stdin),
        to=load_vehicle(target),
        of=load_vehicle(source),
        rate=rate,
        max_speed=max_speed,
        max_accel=max_accel,
        track_length=track_length,
    )
    emit(result.document(), result.rows(), json=json, csv=csv, output=output)
    for line in result.lines():
        say(line)


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command(name="scale-cycle")(scale_cycle)
