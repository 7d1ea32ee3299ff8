"""`rccsim plot`: figures for papers."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from rcc_sim.cli.complete import column_names, cycle_names, effect_names, vehicle_names
from rcc_sim.cli.output import say

if TYPE_CHECKING:
    from matplotlib.figure import Figure

plot = typer.Typer(help="Figures for papers: PNG, SVG or PDF by the file's name.")

Into = Annotated[
    Path,
    typer.Option("--output", "-o", help="Picture: .png, .svg, .pdf.", metavar="FILE"),
]
From = Annotated[
    str, typer.Option("--from", help="Whose it is.", autocompletion=vehicle_names)
]
To = Annotated[
    str, typer.Option("--to", help="At whose size.", autocompletion=vehicle_names)
]


def register(app: typer.Typer) -> None:
    """Add the command and those under it to the app."""
    example = "Example: rccsim plot effect rolling_resistance"
    app.add_typer(plot, name="plot", epilog=example, no_args_is_help=True)


@plot.command(epilog="Example: rccsim plot cycle udds --from r1t --to rcc -o cycle.pdf")
def cycle(
    name: Annotated[
        str,
        typer.Argument(help="Cycle, as for scale-cycle.", autocompletion=cycle_names),
    ],
    from_: From,
    to: To,
    output: Into = Path("cycle.png"),
) -> None:
    """A drive cycle, actual and scaled: on one axis, and the scaled one alone."""
    import sys

    from rcc_sim.definitions.cycle import parse_cycle
    from rcc_sim.definitions.vehicle import load_vehicle
    from rcc_sim.report.figures import plot_cycles
    from rcc_sim.similitude.cycles import scale_cycle

    actual = parse_cycle(name, sys.stdin)
    scaled = scale_cycle(actual, to=load_vehicle(to), of=load_vehicle(from_)).cycle
    _save(plot_cycles(actual, scaled, (f"{from_}, actual", f"{to}, scaled")), output)


@plot.command(epilog="Example: rccsim plot run straight.csv lanes.csv -o run.pdf")
def run(
    traces: Annotated[list[str], typer.Argument(help="Traces of the same drive.")],
    output: Into = Path("run.png"),
    column: Annotated[
        list[str] | None,
        typer.Option(
            help="Draw this column; repeatable. Speed, power, steering unless given.",
            metavar="COLUMN",
            autocompletion=column_names,
        ),
    ] = None,
) -> None:
    """Drives over time: speed, current, power, steering; with and without lane changes.

    The paper's figure of the experiment. The first trace is drawn on top, so that the
    others show where they differ.
    """
    from rcc_sim.report.plots import plot_run
    from rcc_sim.trace import read_trace

    runs = [read_trace(name) for name in traces]
    _save(plot_run(*runs, columns=column or ()), output)


@plot.command(epilog="Example: rccsim plot pi rcc=small.csv r1t=large.csv -o pi.svg")
def pi(
    traces: Annotated[list[str], typer.Argument(help="VEHICLE=TRACE, for each size.")],
    output: Into = Path("pi.png"),
) -> None:
    """Drives of several sizes over each other, dimensionless by their π-groups."""
    from rcc_sim.definitions.vehicle import load_vehicle
    from rcc_sim.report.figures import plot_overlay
    from rcc_sim.similitude.dimensionless import dimensionless_trace
    from rcc_sim.trace import read_trace

    pairs = [_pair(text) for text in traces]
    runs = {
        f"{vehicle} ({trace})": dimensionless_trace(
            read_trace(trace), load_vehicle(vehicle)
        )
        for vehicle, trace in pairs
    }
    _save(plot_overlay(runs), output)


@plot.command("motor-map", epilog="Example: rccsim plot motor-map rcc -o map.pdf")
def motor_map(
    vehicle: Annotated[
        str, typer.Argument(help="Whose motor.", autocompletion=vehicle_names)
    ],
    output: Into = Path("motor-map.png"),
    against: Annotated[
        str | None,
        typer.Option(
            help="Whose envelope is scaled onto it.", autocompletion=vehicle_names
        ),
    ] = None,
    cycle: Annotated[
        str | None,
        typer.Option(help="What --against drives.", autocompletion=cycle_names),
    ] = None,
) -> None:
    """A motor's efficiency over torque and speed, another's envelope scaled onto it."""
    import io

    from rcc_sim.definitions.cycle import parse_cycle
    from rcc_sim.definitions.vehicle import load_vehicle
    from rcc_sim.similitude.motor_map import motor_map as mapped
    from rcc_sim.similitude.motor_plot import draw, picture_format

    kind, picture = picture_format(output.name), io.BytesIO()
    other = load_vehicle(against) if against else None
    driven = parse_cycle(cycle) if cycle else None
    draw(mapped(load_vehicle(vehicle), other, cycle=driven), picture, kind)
    _write(picture.getvalue(), output)


@plot.command(epilog="Example: rccsim plot effect rolling_resistance -o rolling.svg")
def effect(
    name: Annotated[
        str,
        typer.Argument(
            help="Id, or a Python file of your own.", autocompletion=effect_names
        ),
    ],
    output: Into = Path("effect.png"),
) -> None:
    """The signature of an effect: a reference drive without it and with it."""
    from rcc_sim.report.effect_plot import plot_effect

    _save(plot_effect(name), output)


@plot.command(epilog="Example: rccsim plot gap gap.json -o gap.pdf")
def gap(
    found: Annotated[
        str, typer.Argument(help="What gap or diagnose --json wrote; - is stdin.")
    ],
    output: Into = Path("gap.png"),
) -> None:
    """Where a gap sits: energy by regime and by stage of the power chain."""
    from rcc_sim.report.figures import plot_gap

    _save(plot_gap(_read_json(found)), output)


def _pair(text: str) -> tuple[str, str]:
    from rcc_sim.errors import InputError

    vehicle, equals, trace = text.partition("=")
    if not (vehicle and equals and trace):
        raise InputError(f"{text}: should be VEHICLE=TRACE", "such as rcc=straight.csv")
    return vehicle, trace


def _read_json(name: str) -> dict[str, Any]:
    import json

    from rcc_sim.errors import InputError
    from rcc_sim.source import open_source

    with open_source(name).stream() as stream:
        try:
            found = json.loads(stream.read())
        except (json.JSONDecodeError, UnicodeDecodeError) as error:
            raise InputError(f"{name}: not JSON: {error}") from None
    if not isinstance(found, dict):
        raise InputError(f"{name}: should be one JSON object")
    return found


def _save(figure: Figure, output: Path) -> None:
    from rcc_sim.report.plots import save

    save(figure, output)
    say(f"wrote {output}")


def _write(picture: bytes, output: Path) -> None:
    from rcc_sim.files import atomic

    with atomic(output, "wb") as file:
        file.write(picture)
    say(f"wrote {output}")
