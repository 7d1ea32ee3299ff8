"""`rccsim effects`: the terms that the model can switch on and off."""

from __future__ import annotations

from typing import Annotated

import typer

from rcc_sim.cli.complete import effect_names
from rcc_sim.cli.output import Csv, Json, Output, emit

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
        str, typer.Argument(help="Id of the effect.", autocompletion=effect_names)
    ],
    json: Json = False,
    csv: Csv = False,
    output: Output = None,
) -> None:
    """Show one effect: equation, parameters, how a log shows it, source."""
    from rcc_sim.definitions.catalogue import effect_row, effect_sheet

    row = effect_row(effect)
    emit(row, effect_sheet(row), json=json, csv=csv, output=output)
