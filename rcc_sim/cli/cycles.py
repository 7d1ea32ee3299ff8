"""`rccsim cycles`: those that can be named, and what each drives."""

from __future__ import annotations

import sys
from typing import Annotated

import typer

from rcc_sim.cli.complete import cycle_names
from rcc_sim.cli.output import Csv, Json, Output, emit, sketch

cycles = typer.Typer(help="Drive cycles: list them, show one or a part of one.")


def register(app: typer.Typer) -> None:
    """Add the command and those under it to the app."""
    example = "Example: rccsim cycles show 'udds[20:125]'"
    app.add_typer(cycles, name="cycles", epilog=example)


@cycles.callback(invoke_without_command=True)
def _alone(
    ctx: typer.Context, json: Json = False, csv: Csv = False, output: Output = None
) -> None:
    if ctx.invoked_subcommand is None:
        list_(json=json, csv=csv, output=output)


@cycles.command("list", epilog="Example: rccsim cycles list --json")
def list_(json: Json = False, csv: Csv = False, output: Output = None) -> None:
    """List the cycles: working folder, your own, plugins, shipped.

    A file that is no cycle is listed with its problem.
    """
    from rcc_sim.definitions.catalogue import CYCLE_TABLE, cycle_rows

    rows = cycle_rows()
    emit(rows, rows, json=json, csv=csv, output=output, shown=CYCLE_TABLE)


@cycles.command(epilog="Example: rccsim cycles show 'udds[20:125]' --output part.csv")
def show(
    cycle: Annotated[
        str,
        typer.Argument(
            help="NAME, NAME[20:125] (s), NAME*3, NAME+NAME, a file, or - for stdin.",
            autocompletion=cycle_names,
        ),
    ],
    json: Json = False,
    csv: Csv = False,
    output: Output = None,
) -> None:
    """Show the rows of a cycle, cut and joined as asked for."""
    from rcc_sim.definitions.catalogue import cycle_document
    from rcc_sim.definitions.cycle import parse_cycle

    drive = parse_cycle(cycle, sys.stdin)
    pairs = zip(drive.time_s.tolist(), drive.speed_mps.tolist(), strict=True)
    rows = [{"time_s": t, "speed_mps": v} for t, v in pairs]
    emit(cycle_document(drive), rows, json=json, csv=csv, output=output)
    sketch("speed", drive.speed_mps.tolist(), "m/s")
