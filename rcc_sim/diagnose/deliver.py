"""What a diagnosis writes: the mended vehicle, profiles, a run to drive next."""

from __future__ import annotations

from pathlib import Path
from typing import IO, Any

import numpy as np

from rcc_sim.definitions.write_vehicle import write_vehicle
from rcc_sim.diagnose.experiment import next_run
from rcc_sim.diagnose.run import Diagnosis
from rcc_sim.readers import write_commands
from rcc_sim.trace import Trace, write_trace


def write_mended(found: Diagnosis, path: Path) -> None:
    """Write the vehicle with its causes; a road's profile goes into a file beside it.

    Raises
    ------
    InputError
        If a file cannot be written.
    """
    effects: dict[str, dict[str, Any]] = {}
    for name, figures in found.effects().items():
        effects[name] = dict(figures)
    for a in found.asserted:
        profile = a.cause.profiles.get(0)
        if profile is not None and profile.along == "distance_m":
            beside = path.with_name(f"{path.stem}.{a.cause.effect}.csv")
            rest = profile.value - a.figures["slope"].value
            road = Trace({"distance_m": profile.knots, "slope": rest})
            with beside.open("wb") as file:
                write_trace(road, file)
            effects[a.cause.effect]["profile"] = beside.name
    log = ", ".join(g.log for g in found.gaps)
    write_vehicle(found.vehicle, path, found.figures(), effects, log)


def write_profiles(found: Diagnosis, file: IO[bytes]) -> None:
    """Write ``time_s`` and one column per cause that varies, at the log's rows.

    ``effect.parameter``, with ``_low`` and ``_high`` of its 90 % band.
    """
    problem = found.found.engine.problems[0]
    time = problem.log["time_s"]
    columns = {"time_s": time}
    for a in found.asserted:
        profile = a.cause.profiles.get(0)
        if profile is None:
            continue
        x = problem.distance if profile.along == "distance_m" else time
        key = a.cause.keys[0]
        base = found.fit.values.get(key, 0.0)
        if base == 0.0 and key in found.vehicle.figures():
            base = found.vehicle.figures()[key].value
        value = profile.at(x) + base
        band = 1.645 * np.interp(x, profile.knots, profile.sd)
        name = key.removeprefix("effects.")
        columns |= {
            name: value,
            f"{name}_low": value - band,
            f"{name}_high": value + band,
        }
    write_trace(Trace(columns), file)


def write_next_run(found: Diagnosis, path: Path) -> None:
    """Write commands to drive next, within the speed and steer of the first log.

    Raises
    ------
    InputError
        If the format is not known, or the vehicle lacks what it takes.
    """
    problem = found.found.engine.problems[0]
    log = problem.log
    steer = 0.2
    if "steer_cmd_rad" in log:
        steer = 0.5 * float(np.nanmax(np.abs(log["steer_cmd_rad"]))) or steer
    top = float(problem.speed.max()) or 1.0
    time, speed, angle = next_run(top, steer, found.vehicle.wheelbase)
    kind = "mcap" if path.suffix == ".mcap" else "csv"
    write_commands(path, time, speed, angle, found.vehicle, format=kind)
