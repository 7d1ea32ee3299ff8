"""What a diagnosis writes: the mended vehicle, profiles, the screen."""

from __future__ import annotations

from pathlib import Path
from typing import IO, Any

import numpy as np

from rcc_sim.definitions.figure import Z_90
from rcc_sim.definitions.write_vehicle import write_vehicle
from rcc_sim.diagnose.experiment import next_run
from rcc_sim.diagnose.run import Diagnosis
from rcc_sim.readers import write_commands
from rcc_sim.trace import Trace, write_trace

WORDS = {
    "no_gap": "no gap beyond what tolerances and noise explain",
    "explained": "explained",
    "partly_explained": "partly explained",
    "unexplained": "a real gap that none of the effects explains",
}


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
        band = Z_90 * np.interp(x, profile.knots, profile.sd)
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


def screen(found: Diagnosis) -> list[str]:
    """Return the lines of the human output: one screen."""
    g, s = found.gaps[0], found.shrink
    e = g.energy
    lines = [f"GAP      {found.vehicle.name} on {g.log} ({g.mode})"]
    if e.gap_percent is not None:
        lines.append(
            f"         battery energy {e.gap_percent:+.1f} % ({e.gap_wh:+.4g} Wh of "
            f"{e.measured_wh:.4g}), u_val {e.u_val:.2g} Wh"
        )
    regimes = sorted(g.regimes, key=lambda r: -abs(r.gap_wh or 0.0))[:4]
    if regimes:
        told = ", ".join(f"{r.regime} {r.gap_wh:+.3g} Wh" for r in regimes)
        lines.append(f"WHERE    {told}")
    lines.append(f"VERDICT  {WORDS[found.status]}")
    for a in found.asserted:
        figures = ", ".join(
            f"{k} {x.value:.4g} ({x.low:.4g} to {x.high:.4g})"
            for k, x in a.figures.items()
        )
        varies = ", varies over the drive (--profiles)" if a.cause.profiles else ""
        lines.append(
            f"CAUSE    {a.cause.effect}  p = {a.probability:.2f}  {figures}{varies}"
        )
        if a.cause.tied:
            lines.append(
                f"         this log cannot tell it from {', '.join(a.cause.tied)}"
            )
    if found.asserted:
        after = found.energy_after
        energy = "" if after is None else f", energy gap there {after:+.2f} %"
        lines.append(
            f"PROOF    held out: {100 * s.explained:.0f} % of the gap gone "
            f"({100 * s.low:.0f} to {100 * s.high:.0f}){energy}"
        )
    if found.left.is_real:
        where = ", ".join(
            f"{w['start_s']:.1f}-{w['end_s']:.1f} s" for w in found.left.windows[:4]
        )
        lines.append(
            f"LEFT     acts as a {found.left.acts_as}, follows {found.left.follows}"
            f" ({found.left.evidence:.0f} nats); {where}"
        )
    runs = found.next_experiments()[:2]
    return lines + [f"NEXT     {run.do}" for run in runs]
