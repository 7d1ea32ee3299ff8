"""`rccsim vehicles`: those that can be named, and what each states."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from rcc_sim.cli.complete import vehicle_names
from rcc_sim.cli.output import Csv, Json, Output, Text, emit, say
from rcc_sim.files import atomic

vehicles = typer.Typer(help="Vehicles: list them, show one, check one, begin one.")


def register(app: typer.Typer) -> None:
    """Add the command and those under it to the app."""
    app.add_typer(vehicles, name="vehicles", epilog="Example: rccsim vehicles show rcc")


Vehicle = Annotated[
    str, typer.Argument(help="Name or file.", autocompletion=vehicle_names)
]


@vehicles.callback(invoke_without_command=True)
def _alone(
    ctx: typer.Context, json: Json = False, csv: Csv = False, output: Output = None
) -> None:
    if ctx.invoked_subcommand is None:
        list_(json=json, csv=csv, output=output)


@vehicles.command("list", epilog="Example: rccsim vehicles list --json")
def list_(json: Json = False, csv: Csv = False, output: Output = None) -> None:
    """List the vehicles: working folder, your own, plugins, shipped.

    A file that cannot be read is listed with its problem.
    """
    from rcc_sim.definitions.catalogue import vehicle_rows

    rows = vehicle_rows()
    shown = ("name", "title", "origin", "problem")
    emit(rows, rows, json=json, csv=csv, output=output, shown=shown)


@vehicles.command(epilog="Example: rccsim vehicles show r1t")
def show(
    vehicle: Vehicle, json: Json = False, csv: Csv = False, output: Output = None
) -> None:
    """Show every figure of a vehicle: value, unit, sd or range, guess, source."""
    from rcc_sim.definitions.sheet import document, figure_rows
    from rcc_sim.definitions.vehicle import load_vehicle

    loaded = load_vehicle(vehicle)
    title = f"{loaded.name}: {loaded.where} ({loaded.origin})"
    emit(
        document(loaded),
        figure_rows(loaded),
        json=json,
        csv=csv,
        output=output,
        title=title,
    )


@vehicles.command(epilog="Example: rccsim vehicles validate rcc vehicles/mycar.toml")
def validate(
    files: Annotated[
        list[str],
        typer.Argument(help="Names or files.", autocompletion=vehicle_names),
    ],
    json: Json = False,
    csv: Csv = False,
    text: Text = False,
    output: Output = None,
) -> None:
    """Check vehicle files and list all that is wrong; exit 1 if anything is.

    What no car of any size has, a slip of a unit likely, is told of a sound file too.
    """
    from rcc_sim.errors import CheckFailed
    from rcc_sim.similitude.unlikely import report

    rows = report(files)
    emit(rows, rows, json=json, csv=csv, text=text, output=output)
    unsound = sorted({row["file"] for row in rows if not row["sound"]})
    if unsound:
        raise CheckFailed(f"not sound: {', '.join(unsound)}")


@vehicles.command(epilog="Example: rccsim vehicles new mycar --like rcc")
def new(
    name: Annotated[str, typer.Argument(help="What commands will call it.")],
    like: Annotated[
        str | None,
        typer.Option(help="Vehicle that it extends.", autocompletion=vehicle_names),
    ] = None,
    output: Output = None,
    force: Annotated[
        bool,
        typer.Option(
            "--force", help="Overwrite a file, or hide a vehicle, that is there."
        ),
    ] = False,
) -> None:
    """Write the file of a new vehicle: a blank sheet, or one that extends another.

    Writes vehicles/NAME.toml in the working folder unless --output says where.
    """
    from rcc_sim.definitions.library import names
    from rcc_sim.definitions.sheet import new_sheet
    from rcc_sim.errors import InputError

    text = new_sheet(name, like)
    path = output or Path("vehicles", f"{name}.toml")
    if path.exists() and not force:
        raise InputError(f"{path}: is there already", "--force overwrites it")
    if output is None:
        theirs = {e.name: e for e in names("vehicles", (".toml",))}.get(name)
        if theirs is not None and not force:
            what = f"{name}: a vehicle of this name is there ({theirs.origin})"
            raise InputError(
                what, "the new one would hide it: another name, or --force"
            )
        path.parent.mkdir(exist_ok=True)
    with atomic(path) as file:
        file.write(text)
    say(f"wrote {path}; fill it in, then: rccsim vehicles validate {path}")
