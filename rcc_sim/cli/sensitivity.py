"""`rccsim sensitivity`: which unknown figure makes how much of the spread."""

from __future__ import annotations

import sys
from typing import Annotated

import typer

from rcc_sim.cli.batches import (
    Cycle,
    Dask,
    Imposed,
    Jobs,
    LaneEvery,
    Seed,
    Vehicle,
    lanes_of,
)
from rcc_sim.cli.output import Csv, Json, Output, emit
from rcc_sim.cli.overrides import Own, Set, With, Without, changed_vehicle


def register(app: typer.Typer) -> None:
    """Add the command to the app."""
    app.command("sensitivity", epilog=EXAMPLE)(sensitivity)


EXAMPLE = (
    "Example: rccsim sensitivity r1t_epa --cycle udds --imposed --samples 256 "
    "--vary effects.headwind.speed_mps=-3:3 --with aerodynamic_drag:drag_area_m2=0 "
    "--without road_load"
)


def sensitivity(
    vehicle: Vehicle,
    cycle: Cycle,
    of: Annotated[
        list[str] | None,
        typer.Option(
            "--of", metavar="COLUMN", help="Column of a sweep; default: wh_per_km."
        ),
    ] = None,
    samples: Annotated[
        int,
        typer.Option(
            help="Base samples, rounded up to a power of 2; each takes keys + 2 runs."
        ),
    ] = 512,
    vary: Annotated[
        list[str] | None,
        typer.Option(
            "--vary", metavar="KEY=lo:hi", help="Vary this too, evenly between."
        ),
    ] = None,
    imposed: Imposed = False,
    lane_change_every: LaneEvery = None,
    effect: Own = None,
    with_: With = None,
    without: Without = None,
    set_: Set = None,
    seed: Seed = 0,
    jobs: Jobs = 1,
    dask: Dask = None,
    output: Output = None,
    csv: Csv = False,
    json: Json = False,
) -> None:
    """Which figure makes the spread: first-order and total Sobol indices.

    Draws every figure that has an sd or a range in the file and acts on the run. First
    order: the share of the variance that goes if that figure were known; total: with
    its part in what figures do together. Half-widths are of 90 % intervals.
    """
    from rcc_sim.batch.engine import Engine
    from rcc_sim.batch.runs import Manoeuvre
    from rcc_sim.batch.sobol import sobol_indices
    from rcc_sim.definitions.cycle import parse_cycle

    car = changed_vehicle(vehicle, set_, with_, without, effect)
    lanes = lanes_of(lane_change_every, None, None)
    rows = sobol_indices(
        car,
        parse_cycle(cycle, sys.stdin),
        Manoeuvre(imposed=imposed, lanes=lanes),
        samples=samples,
        of=of or ["wh_per_km"],
        ranges=dict(_range(text) for text in vary or []),
        seed=seed,
        engine=Engine(jobs, dask or ""),
    )
    document = {"vehicle": car.name, "cycle": cycle, "indices": rows}
    emit(document, rows, json=json, csv=csv, output=output)


def _range(text: str) -> tuple[str, tuple[float, float]]:
    from rcc_sim.errors import InputError

    key, _, ends = text.partition("=")
    try:
        low, high = (float(word) for word in ends.split(":"))
    except ValueError:
        low = high = 0.0
    if not (key.strip() and low < high):
        raise InputError(f"--vary {text}: should be KEY=lo:hi, lo below hi")
    return key.strip(), (low, high)
