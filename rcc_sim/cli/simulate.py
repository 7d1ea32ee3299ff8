"""`rccsim simulate`: drive a vehicle over a cycle."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from rcc_sim.cli.batches import (
    CYCLE,
    Draws,
    Imposed,
    Jobs,
    LaneEvery,
    LaneLength,
    LaneWidth,
    Seed,
    Vehicle,
    lanes_of,
)
from rcc_sim.cli.output import Csv, Json, Output, emit, say, warn, write_log
from rcc_sim.cli.overrides import Own, Set, With, Without, changed_vehicle

if TYPE_CHECKING:
    from rcc_sim.analyse.energy import EnergyReport
    from rcc_sim.definitions.cycle import Cycle
    from rcc_sim.definitions.vehicle import Vehicle as Car
    from rcc_sim.simulate.given import Profile
    from rcc_sim.simulate.run import Run


def register(app: typer.Typer) -> None:
    """Add the command to the app."""
    app.command("simulate", epilog=EXAMPLE)(simulate)


BESIDE = (
    ("steer_cmd_rad", "steer", "--steer-log"),
    ("slope", "slope", "--road-log"),
    ("aux_power_w", "aux_power", "--aux-log"),
)
"""Column of a cycle's file that is none of the cycle, what follows it, and by what."""

EXAMPLE = (
    "Example: rccsim scale-cycle udds --from r1t --to rcc "
    "| rccsim simulate rcc --cycle - --lane-change-every 20 | rccsim energy -"
)


def simulate(
    vehicle: Vehicle,
    cycle: Annotated[str | None, CYCLE] = None,
    imposed: Imposed = False,
    lane_change_every: LaneEvery = None,
    lane_width: LaneWidth = None,
    lane_change_length: LaneLength = None,
    steer_log: Annotated[
        str | None,
        typer.Option(help="CSV with time_s, steer_cmd_rad, to steer by.", metavar="F"),
    ] = None,
    throttle_log: Annotated[
        str | None,
        typer.Option(
            help="CSV with time_s, throttle, for a car driven by it.", metavar="F"
        ),
    ] = None,
    road_log: Annotated[
        str | None,
        typer.Option(
            help="CSV with distance_m and slope or elevation_m (time_s too, if a log).",
            metavar="F",
        ),
    ] = None,
    aux_log: Annotated[
        str | None,
        typer.Option(
            help="CSV with time_s, aux_power_w, on top of the file's.", metavar="F"
        ),
    ] = None,
    effect: Own = None,
    with_: With = None,
    without: Without = None,
    set_: Set = None,
    output_rate: Annotated[
        float | None,
        typer.Option(
            help="Rows per second; default: the reference rate (speed mode), 10 Hz "
            "(torque mode), the cycle's own rows (imposed). [Hz]"
        ),
    ] = None,
    substeps: Annotated[
        int, typer.Option(help="Time steps per tick of the control loop.", min=1)
    ] = 1,
    draws: Draws = None,
    seed: Seed = 0,
    jobs: Jobs = 1,
    plot: Annotated[
        Path | None, typer.Option(help="Draw the run: PNG, SVG or PDF.", metavar="F")
    ] = None,
    output: Output = None,
    csv: Csv = False,
    json: Json = False,
) -> None:
    """Drive a vehicle over a cycle: a trace, with the ledger of where energy went.

    Writes CSV to a pipe or to --output (.parquet for Parquet); on a terminal it
    shows the summary. Speeds and places are samples, currents, torques and powers
    means since the row before. With --draws it prints the figures of the run with
    their intervals; the trace, of the file's own values, then goes to --output alone.
    """
    from rcc_sim.errors import InputError
    from rcc_sim.simulate import run as runs

    car = changed_vehicle(vehicle, set_, with_, without, effect)
    drive, throttle = _drive(cycle, throttle_log)
    if draws is not None and substeps > 1:
        raise InputError("--draws and --substeps: many runs take one step a tick")
    how: dict[str, Any] = {
        "imposed": imposed,
        "lanes": lanes_of(lane_change_every, lane_width, lane_change_length),
        "steer": _steer(steer_log, lane_change_every),
        "throttle": throttle,
        "slope": _road(road_log),
        "aux_power": _auxiliary(aux_log),
        "output_rate": output_rate,
    }
    _tell_unused(cycle, drive, how)
    result = runs.simulate(car, drive, substeps=substeps, **how)
    for note in result.notes:
        warn(note)
    if plot is not None:
        from rcc_sim.report.plots import plot_run, save

        save(plot_run(result.trace), plot)
        say(f"wrote {plot}")
    if draws is None:
        _deliver(result, output, csv=csv, json=json)
        return
    _write(result, output)
    _intervals(car, drive, how, draws, seed, jobs, csv=csv, json=json)


def _intervals(
    car: Car,
    drive: Cycle,
    how: dict[str, Any],
    draws: int,
    seed: int,
    jobs: int,
    *,
    csv: bool,
    json: bool,
) -> None:
    """Print the figures of a run, each with its interval over draws of the vehicle."""
    from rcc_sim.batch.engine import Engine
    from rcc_sim.batch.runs import Manoeuvre
    from rcc_sim.batch.uncertain import document, drawn_run, rows

    found = drawn_run(
        car, drive, Manoeuvre(**how), draws, seed=seed, engine=Engine(jobs)
    )
    if found.failed:
        warn(f"{found.failed} of {found.count} draws are no vehicle and left out")
    title = f"{car.name} on {drive.name}, {found.count} draws of {len(found.keys)} keys"
    emit(document(found), rows(found), json=json, csv=csv, title=title)


def _drive(cycle: str | None, throttle_log: str | None) -> tuple[Cycle, Profile | None]:
    from rcc_sim.definitions.cycle import parse_cycle
    from rcc_sim.errors import InputError
    from rcc_sim.simulate.given import throttle_drive
    from rcc_sim.trace import read_trace

    if (cycle is None) == (throttle_log is None):
        raise InputError(
            "simulate: give --cycle, or --throttle-log for a car driven by throttle",
            "`rccsim cycles` lists the cycles; --help shows an example",
        )
    if cycle is not None:
        return parse_cycle(cycle, sys.stdin), None
    return throttle_drive(read_trace(throttle_log or ""))


def _tell_unused(path: str | None, drive: Cycle, how: dict[str, Any]) -> None:
    """Warn of what a cycle's file holds beside its speeds that is not followed."""
    for column, key, option in BESIDE:
        steered = key == "steer" and how["lanes"] is not None
        if column in drive.others and how[key] is None and not steered:
            warn(f"{path}: {column} is not followed; {option} takes such a file")


def _steer(path: str | None, every: float | None) -> Profile | None:
    from rcc_sim.errors import InputError
    from rcc_sim.trace import read_trace

    if path is None:
        return None
    if every is not None:
        raise InputError("--steer-log and --lane-change-every: both would steer")
    log = read_trace(path)
    return log["time_s"], log["steer_cmd_rad"]


def _road(path: str | None) -> Profile | None:
    from rcc_sim.simulate.given import road_profile
    from rcc_sim.trace import read_trace

    return None if path is None else road_profile(read_trace(path, along="distance_m"))


def _auxiliary(path: str | None) -> Profile | None:
    from rcc_sim.trace import read_trace

    if path is None:
        return None
    log = read_trace(path)
    return log["time_s"], log["aux_power_w"]


def _deliver(result: Run, output: Path | None, *, csv: bool, json: bool) -> None:
    from rcc_sim.cli.energy import document, rows
    from rcc_sim.trace import write_trace

    report = _write(result, output)
    if output is not None and not (csv or json):
        return
    if json:
        emit(document(report), [], json=True)
    elif csv or not sys.stdout.isatty():
        write_trace(result.trace, sys.stdout.buffer)
        sys.stdout.buffer.flush()
    else:
        emit(None, rows(report), title=report.name)
        say(f"{len(result.trace)} rows; --output FILE or a pipe gets the trace")


def _write(result: Run, output: Path | None) -> EnergyReport:
    """Write the trace, where a file was named; return its energy report."""
    from rcc_sim.analyse.energy import energy_report

    report = energy_report(result.trace)
    if output is not None:
        write_log(result.trace, output)
        say(
            f"wrote {output}: {len(result.trace)} rows, {report.distance_m:.4g} m, "
            f"{report.energy_wh:.4g} Wh"
        )
    return report
