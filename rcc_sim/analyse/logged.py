"""A log made ready for a comparison: read, checked, and what cannot be used dropped."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import inf
from pathlib import Path
from typing import IO

import numpy as np
from numpy.typing import NDArray

from rcc_sim.analyse.even_clock import on_even_clock
from rcc_sim.analyse.logcheck import check_log, file_findings
from rcc_sim.analyse.logcheck.finding import (
    ELECTRICAL,
    KINEMATIC,
    Array,
    Finding,
    Mask,
    counted,
    runs,
)
from rcc_sim.analyse.logcheck.one_clock import one_clock
from rcc_sim.analyse.lost_rows import with_lost_rows
from rcc_sim.analyse.stale import between_updates, refreshed
from rcc_sim.channel import sensor_noise
from rcc_sim.definitions.sensors import INERTIAL
from rcc_sim.definitions.vehicle import Vehicle
from rcc_sim.errors import InputError
from rcc_sim.readers import Log, read_log, with_vehicle
from rcc_sim.simulate.drive import is_on_stand
from rcc_sim.trace import Trace

Places = NDArray[np.intp]

MOVING = (*INERTIAL, "x_m", "y_m", "yaw_rad", "elevation_m", "slope", "steer_cmd_rad")
"""Columns that say nothing of a vehicle whose wheels turn off the ground."""

COMPARED = (
    *("speed_mps", "yaw_rate_radps", "accel_x_mps2", "accel_y_mps2"),
    *("motor_current_a", "motor_torque_nm", "battery_voltage_v"),
    *("battery_current_a", "battery_power_w"),
)
"""Channels that a model predicts; a log without one tells nothing."""

BACKWARD = 0.01
"""Speed as a share of the log's largest below which a vehicle reverses."""

WHOLE = (-inf, inf)
"""From when to when a log counts, all of it. [s]"""

ROLLED = Finding(
    "rolled",
    "speed_mps",
    "is motor_speed_radps over the file's gear and radius: the logged one is of no use",
    severity="warning",
)
"""What is said where a motor's speed takes the place of one that is of no use."""

FEWEST = 10
"""Rows below which a log is not compared."""


@dataclass(frozen=True)
class Logged:
    """A log that can be compared with a model.

    Parameters
    ----------
    log : Trace
        Usable columns; time increases, NaN where a channel has no sound value.
    findings : tuple of Finding
        What the check found, and what was left out of the comparison.
    reading : Log
        What the reader made of the file.
    hidden : tuple of str
        Measured columns that were left out as if the file did not have them.
    """

    log: Trace
    findings: tuple[Finding, ...]
    reading: Log
    hidden: tuple[str, ...] = ()


def open_log(
    source: str | Path,
    vehicle: Vehicle,
    *,
    reader: str | None = None,
    columns: str | Path | None = None,
    hide: Sequence[str] = (),
    span: tuple[float, float] = WHOLE,
    back: bool = False,
    on_stand: bool = False,
    stdin: IO[bytes] | None = None,
) -> Logged:
    """Read a log of any format, check it, and drop what cannot be used.

    Parameters
    ----------
    source : str or Path
        File, folder (a ROS 2 bag), or ``-`` for stdin.
    vehicle : Vehicle
        By which speeds follow from ERPM, and the check judges.
    reader, columns : str, optional
        As in :func:`rcc_sim.readers.read_log`.
    hide : sequence of str
        Measured columns to leave out.
    span : tuple of float
        From when to when on the log's own clock it counts. [s]
    back : bool
        It was driven the other way along the road: its ``direction`` is -1.
    on_stand : bool
        Its wheels turned off the ground: its ``on_stand`` is 1. What a vehicle that
        stands still feels, and how it is steered, is left out.

    Raises
    ------
    InputError
        If the log is broken, a hidden column is not there, or nothing usable is left.
    """
    reading = read_log(source, reader=reader, columns=columns, stdin=stdin)
    reading = with_vehicle(reading, vehicle)
    trace = steered(reading.trace, vehicle)
    said = {"direction": -1.0} if back else {}
    said |= {"on_stand": 1.0} if on_stand else {}
    all_along = {name: np.full(len(trace), x) for name, x in said.items()}
    trace = Trace({**trace.columns, **all_along}, name=trace.name)
    reading = replace(reading, trace=trace)
    trace = _within(_without(trace, hide), span)
    again = counted_again(trace, vehicle)
    if is_on_stand(trace):
        trace = _without(trace, [c for c in MOVING if c in trace])
    trace, notes = one_clock(trace)
    checked = check_log(trace, vehicle)
    _refuse_time(checked.findings, trace.name)
    kept = {
        name: values
        for name, values in checked.trace.columns.items()
        if name not in checked.unusable
    }
    rolled: tuple[Finding, ...] = ()
    wrong = {"speed_mps", "speed_ref_mps"}.intersection(checked.unusable)
    # without its commands it would be driven another way
    if wrong == {"speed_mps"} and "motor_speed_radps" in kept:
        kept["speed_mps"] = kept["motor_speed_radps"] * vehicle.lever
        rolled = (ROLLED,)
    log, evened = on_even_clock(Trace(kept, name=trace.name), vehicle)
    log, turned = _forward(log)
    slow = [f.channel for f in checked.findings if f.kind == "slow_channel"]
    log, held = between_updates(log, slow)
    log, renewed = refreshed(log)
    log = with_lost_rows(log, vehicle)
    _refuse(log, checked.findings)
    told = [f for f in checked.findings if not turned or f.kind != turned[0].kind]
    own = (*notes, *evened, *rolled, *turned, *held, *renewed)
    findings = (*file_findings(reading), *own, *again, *told)
    return Logged(log, findings, reading, tuple(hide))


def steered(trace: Trace, vehicle: Vehicle) -> Trace:
    """Add the road wheels' angle where a log has the command that the file maps.

    Raises
    ------
    InputError
        If the map does not rise, or its two lists differ in length.
    """
    control = vehicle.controller
    command = control.steering_command if control else None
    angle = control.steering_angle_rad if control else None
    if "steering" not in trace or "steer_cmd_rad" in trace or not (command or angle):
        return trace
    command, angle = command or [], angle or []
    if len(command) != len(angle) or len(command) < 2 or min(np.diff(command)) <= 0:
        raise InputError(
            f"{vehicle.where}: controller.steering_command: should rise, an angle each",
            f"{len(command)} commands, steering_angle_rad has {len(angle)}",
        )
    found = np.interp(trace["steering"], command, angle)
    return Trace({**trace.columns, "steer_cmd_rad": found}, name=trace.name)


def _within(trace: Trace, span: tuple[float, float]) -> Trace:
    """Return a part of a log, by its own clock."""
    if span == WHOLE:
        return trace
    time, (start, end) = trace["time_s"], span
    rows = (time >= start) & (time <= end)
    if not rows.any():
        raise InputError(
            f"{trace.name}: has no row from {_times(start, end)}",
            f"its clock runs from {np.nanmin(time):.6g} to {np.nanmax(time):.6g} s",
        )
    return Trace({n: x[rows] for n, x in trace.columns.items()}, name=trace.name)


def _times(start: float, end: float) -> str:
    """Return a span in words; infinite is as far as the log goes."""
    first = f"{start:g} s" if start > -np.inf else "its start"
    return f"{first} to {f'{end:g} s' if end < np.inf else 'its end'}"


def counted_again(trace: Trace, vehicle: Vehicle) -> list[Finding]:
    """Return what a log has that was hidden as its vehicle's file was mended."""
    return [
        Finding(
            "counted_again",
            column,
            f"was hidden as {vehicle.name} was mended, which holds what it says",
            action=f"counted twice; --hide {column} leaves it out",
            severity="warning",
        )
        for column in vehicle.vehicle.mended_without
        if column in trace
    ]


def _without(trace: Trace, hide: Sequence[str]) -> Trace:
    for name in hide:
        if name not in trace or name == "time_s":
            there = ", ".join(n for n in trace.columns if n != "time_s")
            raise InputError(f"{trace.name}: no column {name} to hide", f"has {there}")
    kept = {n: values for n, values in trace.columns.items() if n not in hide}
    return Trace(kept, name=trace.name)


def _forward(trace: Trace) -> tuple[Trace, tuple[Finding, ...]]:
    """Return the log without what was measured while the vehicle went backwards."""
    speed = trace.columns.get("speed_mps")
    if speed is None or not np.isfinite(speed).any():
        return trace, ()
    least = max(6 * sensor_noise(speed), BACKWARD * float(np.nanmax(np.abs(speed))))
    back = np.where(np.isfinite(speed), speed, 0.0) < -least
    if not back.any():
        return trace, ()
    starts, ends = runs(back)
    out = _reversing(np.asarray(speed), starts, ends)
    columns = dict(trace.columns)
    for name in (*KINEMATIC, *INERTIAL, *ELECTRICAL):
        if name in columns and name not in ("x_m", "y_m", "yaw_rad", "elevation_m"):
            columns[name] = np.where(out, np.nan, columns[name])
    if "speed_ref_mps" in columns:
        columns["speed_ref_mps"] = np.maximum(columns["speed_ref_mps"], 0.0)
    time = trace["time_s"]
    found = Finding(
        "reversing",
        "speed_mps",
        f"the vehicle goes backwards in {counted(int(out.sum()))}",
        where=f"{len(starts)} times, first at {time[starts[0]]:.6g} s",
        action="left out of the comparison: the model drives forwards",
        severity="warning",
        start_s=float(time[starts[0]]),
        end_s=float(time[ends[-1] - 1]),
    )
    return Trace(columns, name=trace.name), (found,)


def _reversing(speed: Array, starts: Places, ends: Places) -> Mask:
    """Return the rows from standing still, backwards, to standing still again."""
    out = np.zeros(len(speed), dtype=bool)
    for start, end in zip(starts, ends, strict=True):
        first, last = int(start), int(end)
        while first > 0 and speed[first - 1] < 0:
            first -= 1
        while last < len(speed) and speed[last] < 0:
            last += 1
        out[first:last] = True
    return out


def _refuse_time(findings: Sequence[Finding], name: str) -> None:
    for finding in findings:
        if finding.channel == "time_s" and finding.severity == "error":
            at = f" ({finding.where})" if finding.where else ""
            raise InputError(f"{name}: time_s: {finding.what}{at}", finding.mend)


def _refuse(log: Trace, findings: Sequence[Finding]) -> None:
    usable = [n for n in COMPARED if n in log and np.isfinite(log[n]).any()]
    if not usable:
        wrong = [f for f in findings if f.severity == "error" and f.channel in COMPARED]
        why = "".join(f"; {f.channel} {f.what}" for f in wrong)
        raise InputError(
            f"{log.name}: nothing that a model predicts is left{why}",
            wrong[0].mend
            if wrong
            else f"one of {', '.join(COMPARED)}; `rccsim check` says what is wrong",
        )
    if len(log) < FEWEST:
        raise InputError(f"{log.name}: {counted(len(log))}: too few to compare")
