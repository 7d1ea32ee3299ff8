"""What a diagnosis writes: the mended vehicle, profiles, a run to drive next."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import IO, Any

import numpy as np
from numpy.typing import NDArray

from rcc_sim.definitions.figure import Z_90
from rcc_sim.definitions.kernel import road_of
from rcc_sim.definitions.write_vehicle import write_vehicle
from rcc_sim.diagnose.causes.cause import Cause
from rcc_sim.diagnose.causes.profile import Profile
from rcc_sim.diagnose.diagnosis import Diagnosis
from rcc_sim.diagnose.next_run.limits import level_column, limits_of
from rcc_sim.diagnose.next_run.menu import Run, menu
from rcc_sim.diagnose.residuals.problem import Problem
from rcc_sim.errors import InputError
from rcc_sim.files import atomic, restored
from rcc_sim.readers import write_commands
from rcc_sim.simulate.replay import speed_share
from rcc_sim.trace import Trace, write_trace

Array = NDArray[np.float64]

SPEED_COMMAND = "speed_ref_mps"
"""Column by which a car in speed mode is driven."""


def write_mended(found: Diagnosis, path: Path) -> None:
    """Write the vehicle with its causes; a road's profile goes into a file beside it.

    Raises
    ------
    InputError
        If a file cannot be written.
    """
    effects: dict[str, dict[str, Any]] = {}
    roads: dict[Path, Trace] = {}
    for name, figures in found.effects().items():
        effects[name] = dict(figures)
    values = {e: {k: f.value for k, f in of.items()} for e, of in effects.items()}
    # a profile lies along the log's distances; a road that a file states is true
    settings = {key: figure.value for key, figure in found.figures().items()}
    share = speed_share(found.vehicle.changed(effects=values, settings=settings))
    for a in found.asserted:
        profile = way_out(found, a.cause)
        if profile is not None and profile.along == "distance_m":
            beside = path.with_name(f"{path.stem}.{a.cause.effect}.csv")
            (key,) = a.cause.keys
            figure = a.figures[key.rpartition(".")[2]].value
            distance, slope = beyond(profile, figure - base_of(found, key))
            stated = road_of(found.vehicle)
            if stated is None:
                distance = distance * share
            else:  # which this one stands in place of
                every = np.union1d(distance, stated[0])
                slope = np.interp(every, distance, slope) + np.interp(every, *stated)
                distance = every
            roads[beside] = Trace({"distance_m": distance, "slope": slope})
            effects[a.cause.effect]["profile"] = beside.name
    log = ", ".join(g.log for g in found.gaps)
    with restored(roads):  # the vehicle is read once it is written, and reads them
        for beside, road in roads.items():
            with atomic(beside, "wb") as file:
                write_trace(road, file)
        write_vehicle(found.vehicle, path, found.figures(), effects, log, found.hidden)


def way_out(found: Diagnosis, cause: Cause) -> Profile | None:
    """Return a cause's profile over the log that is shown, as the way out goes.

    Of a log driven the other way none: that of the first that was not, or, where all
    were, its own from its end, where the way out begins.
    """
    problems, profiles = found.found.engine.problems, cause.profiles
    if not profiles:
        return None
    first = sorted(profiles, key=lambda i: (problems[i].drive.back, i != found.shown))
    profile = profiles[first[0]]
    if not problems[first[0]].drive.back or profile.along != "distance_m":
        return profile
    knots = (profile.knots[-1] - profile.knots)[::-1]
    return replace(profile, knots=knots, value=profile.value[::-1], sd=profile.sd[::-1])


def beyond(profile: Profile, less: float) -> tuple[Array, Array]:
    """Return a profile beside a constant, and one knot more at which both come to nil.

    A drive that goes farther than the log finds there the road that the file states,
    and not for ever the last slope that was found.
    """
    knots = profile.knots
    step = knots[-1] - knots[-2]
    return np.append(knots, knots[-1] + step), np.append(profile.value - less, -less)


def base_of(found: Diagnosis, key: str) -> float:
    """Return what a varying cause acts on top of: what was fitted, else is stated."""
    return found.fit.values.get(key, found.found.engine.problems[0].stated(key))


def varying(found: Diagnosis) -> list[str]:
    """Return the causes that vary over a drive."""
    return [a.cause.effect for a in found.asserted if a.cause.profiles]


def over_time(found: Diagnosis) -> list[str]:
    """Return those of them that vary over time, and not along the road."""
    return [a.cause.effect for a in found.asserted if a.cause.over_time]


def acting(found: Diagnosis, cause: Cause, log: int = 0) -> tuple[Array, Array]:
    """Return a varying cause's figure at a log's rows, and half its 90 % band.

    It acts on top of what was fitted, else of what the file states.
    """
    profile, key = cause.profiles[log], cause.keys[0]
    x = found.found.engine.problems[log].coordinate(profile.along)
    band = Z_90 * np.interp(x, profile.knots, profile.sd)
    return profile.at(x) + base_of(found, key), band


def write_profiles(found: Diagnosis, file: IO[bytes], log: int = 0) -> None:
    """Write ``time_s`` and one column per cause that varies, at a log's rows.

    ``effect.parameter``, with ``_low`` and ``_high`` of its 90 % band.
    """
    time = found.found.engine.problems[log].log["time_s"]
    columns = {"time_s": time}
    for a in found.asserted:
        if log not in a.cause.profiles:
            continue
        value, band = acting(found, a.cause, log)
        name = a.cause.keys[0].removeprefix("effects.")
        columns |= {
            name: value,
            f"{name}_low": value - band,
            f"{name}_high": value + band,
        }
    write_trace(Trace(columns), file)


def refuse_bag(path: Path, log: Callable[[], Problem]) -> None:
    """Raise if a run like a log is to be a bag, and is not commanded by its speed."""
    if path.suffix == ".mcap" and (column := level_column(log())) != SPEED_COMMAND:
        raise InputError(
            f"--next-run: {path}: should end in .csv where {column} is what is driven",
            "a bag holds the commands of a car whose mode is speed",
        )


def write_next_run(found: Diagnosis, path: Path) -> Run:
    """Write, and return, the best run that commands make; of out and back, one way.

    A speed to follow where the log has no commands. Where nothing is tied or wide:
    the run of the menu that steers most, else the longest.

    Raises
    ------
    InputError
        If the format is not known, the vehicle lacks what it takes, or the file cannot
        be written.
    """
    problem = found.found.engine.problems[0]
    refuse_bag(path, lambda: problem)
    runs = [e.run for e in found.experiments if e.run.is_commanded]
    if not runs:
        every = menu(problem, limits_of(problem), problem.row)
        every = [r for r in every if r.is_commanded and not r.is_both_ways]
        runs = [max(every, key=lambda r: (float(np.ptp(r.legs[0].steer)), r.seconds))]
    leg = runs[0].commands
    column = level_column(problem)
    if column == SPEED_COMMAND:
        kind = "mcap" if path.suffix == ".mcap" else "csv"
        write_commands(path, leg.time, leg.level, leg.steer, found.vehicle, format=kind)
        return runs[0]
    columns = {"time_s": leg.time, column: leg.level, "steer_cmd_rad": leg.steer}
    with atomic(path, "wb") as file:
        write_trace(Trace(columns), file)
    return runs[0]
