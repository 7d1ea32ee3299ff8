"""`rccsim sweep`: many runs, each a row."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from rcc_sim.cli.batches import (
    Cycle,
    Dask,
    Imposed,
    Jobs,
    LaneEvery,
    LaneLength,
    LaneWidth,
    Method,
    ProgressLine,
    Seed,
    Vehicle,
    going_on,
    tell_failures,
)
from rcc_sim.cli.complete import figure_keys
from rcc_sim.cli.output import Json, emit, say, warn
from rcc_sim.cli.overrides import Own, With, Without, changed_vehicle

if TYPE_CHECKING:
    from rcc_sim.batch.batch import Progress
    from rcc_sim.batch.plan import Plan
    from rcc_sim.batch.runs import Sweep
    from rcc_sim.definitions.vehicle import Vehicle as Car
    from rcc_sim.simulate.run import LaneChanges


def register(app: typer.Typer) -> None:
    """Add the command to the app."""
    app.command("sweep", epilog=EXAMPLE)(sweep)


TABLES = (".csv", ".tsv", ".json", ".xlsx", ".html", ".gz")
"""Endings of what a folder of Parquet would be taken for."""

EXAMPLE = (
    "Example: rccsim sweep r1t_epa --cycle udds --imposed "
    "--set body.mass_kg=3000:3400:100 --set lanes.every=none,50 -o mass.parquet"
)


def sweep(
    vehicle: Vehicle,
    cycle: Cycle,
    output: Annotated[
        Path,
        typer.Option(
            "--output",
            "-o",
            metavar="OUT",
            help="A folder (a Parquet dataset), or a file in .parquet.",
        ),
    ],
    set_: Annotated[
        list[str] | None,
        typer.Option(
            "--set",
            metavar="KEY=VALUES",
            help="A figure's values, lo:hi:step or a,b,c: body.mass_kg=3:5:0.1, "
            "effects.ID.PARAM, cycle.speed_scale, cycle.time_scale, lanes.every "
            "(none: no lane changes), lanes.width, lanes.length. All combinations.",
            autocompletion=figure_keys,
        ),
    ] = None,
    draw: Annotated[
        int | None,
        typer.Option(
            "--draw",
            metavar="N",
            help="N draws of the file's sds and ranges, the same at each combination.",
        ),
    ] = None,
    method: Method = "lhs",
    seed: Seed = 0,
    draws_file: Annotated[
        Path | None,
        typer.Option(metavar="F", help="CSV of draws: keys, then a row a draw."),
    ] = None,
    imposed: Imposed = False,
    lane_change_every: LaneEvery = None,
    lane_width: LaneWidth = None,
    lane_change_length: LaneLength = None,
    effect: Own = None,
    with_: With = None,
    without: Without = None,
    output_rate: Annotated[
        float | None,
        typer.Option(help="Rows per second of which the peaks are the largest. [Hz]"),
    ] = None,
    jobs: Jobs = 1,
    dask: Dask = None,
    json: Json = False,
) -> None:
    """Many runs: a grid, draws, or both, over any figure; a row a run.

    A row holds the inputs, the energy ledger, distance and peaks; a run that fails is
    a row with its error. What is done is kept part by part: killed at any moment, the
    same command goes on and ends with the same rows.
    """
    from rcc_sim.batch.batch import run_batch
    from rcc_sim.batch.engine import Engine
    from rcc_sim.errors import InputError

    if output.suffix in TABLES and not output.is_dir():
        raise InputError(
            f"--output: {output}: runs are kept as Parquet",
            f"{output.with_suffix('.parquet')} for one file, "
            f"{output.with_suffix('')} for a folder of parts",
        )
    car, axes = _vehicle(vehicle, set_, with_, without, effect)
    lanes = _lanes(lane_change_every, lane_width, lane_change_length)
    plan = _plan(car, axes, draws_file, draw, method, seed, imposed=imposed)
    task = _task(car, cycle, plan, lanes, imposed=imposed, output_rate=output_rate)
    for note in task.notes():
        warn(note)
    line = ProgressLine("runs")
    with going_on(output):
        progress = run_batch(task, output, Engine(jobs, dask or ""), line)
    line.end()
    say(_summary(progress, output))
    tell_failures(progress, "runs")
    if json:
        emit(_document(progress, task, output), [], json=True)


def _vehicle(
    name: str,
    settings: list[str] | None,
    added: list[str] | None,
    removed: list[str] | None,
    files: list[str] | None,
) -> tuple[Car, list[str]]:
    """Return the vehicle with what is no number set, and the axes that are."""
    from rcc_sim.batch.plan import is_axis

    axes = [text for text in settings or [] if is_axis(text)]
    words = [text for text in settings or [] if text not in axes]
    return changed_vehicle(name, words, added, removed, files), axes


def _lanes(
    every: float | None, width: float | None, length: float | None
) -> LaneChanges | None:
    from math import inf

    from rcc_sim.simulate.run import LaneChanges

    if every is None and width is None and length is None:
        return None
    return LaneChanges(inf if every is None else every, width, length)


def _plan(
    car: Car,
    axes: list[str],
    draws_file: Path | None,
    draw: int | None,
    method: Any,
    seed: int,
    *,
    imposed: bool,
) -> Plan:
    from rcc_sim.batch import draws
    from rcc_sim.batch.plan import make_plan
    from rcc_sim.errors import InputError

    if draw is not None and draws_file is not None:
        raise InputError("--draw and --draws-file: give one of them")
    if draw is None and draws_file is None:
        if not axes:
            raise InputError(
                "sweep: nothing to sweep", "give --set KEY=values, --draw or a file"
            )
        return make_plan(axes)
    if draws_file is not None:
        return make_plan(axes, *draws.read_draws(draws_file))
    assert draw is not None
    grid = make_plan(axes)
    figures = draws.uncertain_figures(car, commanded=not imposed, fixed=grid.keys)
    return make_plan(axes, *draws.file_draws(car, draw, method, seed, figures))


def _task(
    car: Car,
    cycle: str,
    plan: Plan,
    lanes: LaneChanges | None,
    *,
    imposed: bool,
    output_rate: float | None,
) -> Sweep:
    from rcc_sim.batch.runs import Manoeuvre, Sweep
    from rcc_sim.definitions.cycle import parse_cycle

    how = Manoeuvre(imposed=imposed, lanes=lanes, output_rate=output_rate)
    task = Sweep(car, parse_cycle(cycle, sys.stdin), plan, how)
    task.check()
    return task


def _summary(progress: Progress, output: Path) -> str:
    new = progress.total - progress.before
    if not new:
        return f"{output}: all {progress.total:,} runs were there already"
    before = f", {progress.before:,} were there" if progress.before else ""
    return (
        f"wrote {output}: {progress.total:,} runs ({new:,} now{before}), "
        f"{progress.rate:,.4g} a second"
    )


def _document(progress: Progress, task: Sweep, output: Path) -> dict[str, Any]:
    return {
        "output": str(output),
        "runs": progress.total,
        "runs_before": progress.before,
        "failed": progress.failed,
        "failures": dict(progress.failures.most_common(100)),
        "keys": list(task.plan.keys),
        "runs_per_second": progress.rate,
    }
