"""`rccsim scale-cycle`: a full-size cycle at a car's size."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from rcc_sim.cli.complete import cycle_names, vehicle_names
from rcc_sim.cli.output import Csv, Json, Output, emit, say

if TYPE_CHECKING:
    from rcc_sim.definitions.cycle import Cycle
    from rcc_sim.definitions.vehicle import Vehicle


EXAMPLE = 'Example: rccsim scale-cycle "udds[20:125]" --from r1t --to rcc --rate 100'


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
    format_: Annotated[
        str | None,
        typer.Option(
            "--format",
            metavar="mcap|csv",
            help="Write what the car plays to --output: a bag, or CSV with ERPM.",
        ),
    ] = None,
    output: Output = None,
) -> None:
    """A drive cycle at the car's size, and what the car cannot drive of it.

    With --format mcap the file holds /drive and /commands/motor/speed (ERPM), at
    --rate or the rate of the car's reference; `ros2 bag play` plays either.
    """
    from rcc_sim.definitions.cycle import parse_cycle
    from rcc_sim.definitions.vehicle import load_vehicle
    from rcc_sim.similitude.cycles import scale_cycle as scaled_cycle

    car = load_vehicle(target)
    result = scaled_cycle(
        parse_cycle(cycle, sys.stdin),
        to=car,
        of=load_vehicle(source),
        rate=rate or (_reference_rate(car) if format_ else None),
        max_speed=max_speed,
        max_accel=max_accel,
        track_length=track_length,
    )
    if format_ is not None:
        _play(result.cycle, car, format_, output)
        output = None
    if format_ is None or json or csv:
        emit(result.document(), result.rows(), json=json, csv=csv, output=output)
    for line in result.lines():
        say(line)


def _reference_rate(car: Vehicle) -> float | None:
    """Rate of the car's own speed reference, where its file states one. [Hz]"""
    period = car.figures().get("effects.reference_sampling.period_s")
    return 1 / period.value if period else None


def _play(cycle: Cycle, car: Vehicle, format_: str, output: Path | None) -> None:
    from rcc_sim.errors import InputError
    from rcc_sim.readers.commands import write_commands

    if output is None:
        raise InputError("--format needs --output FILE")
    write_commands(output, cycle.time_s, cycle.speed_mps, None, car, format_)
    say(f"wrote {output}: {len(cycle.time_s)} commands; let the car take one topic")


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command(name="scale-cycle", epilog=EXAMPLE)(scale_cycle)
