"""`rccsim effects`: the terms that the model can switch on and off."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from rcc_sim.cli.complete import effect_names, vehicle_names
from rcc_sim.cli.output import Csv, Json, Output, emit, say
from rcc_sim.cli.overrides import Set, With, Without, changed_vehicle

effects = typer.Typer(help="Effects: list what the model knows, show one.")


def register(app: typer.Typer) -> None:
    """Add the command and those under it to the app."""
    example = "Example: rccsim effects show rolling_resistance"
    app.add_typer(effects, name="effects", epilog=example)


@effects.callback(invoke_without_command=True)
def _alone(
    ctx: typer.Context, json: Json = False, csv: Csv = False, output: Output = None
) -> None:
    if ctx.invoked_subcommand is None:
        list_(json=json, csv=csv, output=output)


@effects.command("list", epilog="Example: rccsim effects list --json")
def list_(json: Json = False, csv: Csv = False, output: Output = None) -> None:
    """List the effects, with parameters, equation, channels and ledger line."""
    from rcc_sim.definitions.catalogue import effect_rows, flat_effect

    rows = effect_rows()
    flat = [flat_effect(row) for row in rows]
    shown = ("id", "title", "parameters", "ledger")
    emit(rows, flat, json=json, csv=csv, output=output, shown=shown)


@effects.command(epilog="Example: rccsim effects show gear_loss --json")
def show(
    effect: Annotated[
        str,
        typer.Argument(
            help="Id of the effect, or a Python file with one of your own.",
            autocompletion=effect_names,
        ),
    ],
    plot: Annotated[
        Path | None,
        typer.Option(help="Draw a reference drive without and with it.", metavar="F"),
    ] = None,
    json: Json = False,
    csv: Csv = False,
    output: Output = None,
) -> None:
    """Show one effect: equation, parameters, how a log shows it, source."""
    from rcc_sim.definitions.catalogue import effect_row, effect_sheet

    row = effect_row(effect)
    if plot is not None:
        from rcc_sim.report.effect_plot import plot_effect
        from rcc_sim.report.plots import save

        save(plot_effect(effect), plot)
        say(f"wrote {plot}")
    emit(row, effect_sheet(row), json=json, csv=csv, output=output)


@effects.command(epilog="Example: rccsim effects convert r1t_epa --max-speed 30")
def convert(
    vehicle: Annotated[
        str, typer.Argument(help="Name or file.", autocompletion=vehicle_names)
    ],
    max_speed: Annotated[
        float, typer.Option(help="Up to which rolling and drag are fitted. [m/s]")
    ] = 30.0,
    with_: With = None,
    without: Without = None,
    set_: Set = None,
    json: Json = False,
    csv: Csv = False,
    output: Output = None,
) -> None:
    """State a vehicle's road load the other way: A, B, C, or rolling and drag."""
    from rcc_sim.definitions.road_load import converted

    rows = converted(changed_vehicle(vehicle, set_, with_, without), max_speed)
    emit(rows, rows, json=json, csv=csv, output=output)
