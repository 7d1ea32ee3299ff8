"""`rccsim motor-map`: efficiency over torque and speed."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from rcc_sim.cli.complete import cycle_names, vehicle_names
from rcc_sim.cli.output import Csv, Json, Output, emit, say
from rcc_sim.files import atomic

if TYPE_CHECKING:
    from rcc_sim.definitions.cycle import Cycle
    from rcc_sim.definitions.vehicle import Vehicle
    from rcc_sim.similitude.motor_map import MotorMap


EXAMPLE = "Example: rccsim motor-map rcc --against r1t --cycle udds --plot map.png"


def motor_map(
    vehicle: Annotated[
        str,
        typer.Argument(
            help="Vehicle whose motor is mapped.", autocompletion=vehicle_names
        ),
    ],
    against: Annotated[
        str | None,
        typer.Option(
            help="Vehicle whose envelope is scaled onto it.",
            autocompletion=vehicle_names,
        ),
    ] = None,
    cycle: Annotated[
        str | None,
        typer.Option(
            help="Cycle that --against drives, scaled on too.",
            autocompletion=cycle_names,
        ),
    ] = None,
    top_speed: Annotated[
        float | None, typer.Option(help="Of --against, if its file has none. [m/s]")
    ] = None,
    points: Annotated[
        int, typer.Option(help="Torques, and speeds, of the grid.", min=2, max=2000)
    ] = 41,
    plot: Annotated[
        Path | None, typer.Option(help="Picture: .png, .svg, .pdf.")
    ] = None,
    json: Json = False,
    csv: Csv = False,
    output: Output = None,
) -> None:
    """Efficiency of a motor, and whether another vehicle's drive fits its envelope."""
    from rcc_sim.similitude.motor_map import motor_map as mapped

    loaded, other, driven = _read(vehicle, against, cycle)
    result = mapped(loaded, other, cycle=driven, top_speed=top_speed, points=points)
    if plot is not None:
        _draw(result, plot)
    emit(result.document(), result.rows(), json=json, csv=csv, output=output)
    for line in result.lines():
        say(line)


def _draw(result: MotorMap, plot: Path) -> None:
    from rcc_sim.similitude.motor_plot import draw, picture_format

    picture = picture_format(plot.name)
    with atomic(plot, "wb") as file:
        draw(result, file, picture)


def _read(
    vehicle: str, against: str | None, cycle: str | None
) -> tuple[Vehicle, Vehicle | None, Cycle | None]:
    import sys

    from rcc_sim.definitions.cycle import parse_cycle
    from rcc_sim.definitions.vehicle import load_vehicle
    from rcc_sim.errors import InputError

    if cycle is not None and against is None:
        raise InputError(
            "--cycle: should go with --against, the vehicle that drives it"
        )
    other = load_vehicle(against) if against is not None else None
    driven = parse_cycle(cycle, sys.stdin) if cycle is not None else None
    return load_vehicle(vehicle), other, driven


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command(name="motor-map", epilog=EXAMPLE)(motor_map)
