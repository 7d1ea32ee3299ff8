"""Rows that came evenly, and whose time stamps jitter.

A logger that stamps a row when it gets round to it, and not when the sensors were read,
makes a smooth speed uneven: 20 ms at 2 m/s² are 0.04 m/s, and as much noise in what
accelerates the vehicle as a limit of braking is named for. But where one loop commands
and logs, its rows truly jitter, and a car that obeys within a row goes as evenly as it
is told to.
"""

from __future__ import annotations

from dataclasses import replace
from math import inf

import numpy as np
from numpy.typing import NDArray

from rcc_sim.analyse.logcheck.finding import Finding
from rcc_sim.channel import interval_of
from rcc_sim.definitions.vehicle import Vehicle
from rcc_sim.physics.tables import LINE, SINCE
from rcc_sim.simulate.drive import COMMANDS, Drive, drive_of, has_commands
from rcc_sim.simulate.replay import RECALLS, replay
from rcc_sim.trace import Trace

Array = NDArray[np.float64]

FEW = 200
"""Rows, and changes of speed among them, below which nothing is told."""

LEAST = 0.02
"""Share of a row by which stamps jitter at least, one sd, to be evened."""

EXACT = LEAST / 100
"""Share of a row by which stamps lie off whole rows at most that cannot jitter by the
least: over the rows of a straight line it adds up to no more."""

LOST, SMOOTH = 31, 101
"""Rows over which a step of the clock is one, as rows that were lost make it; and over
which stamps follow their straight line."""

SHORT = 5
"""Rows between two such steps that have no line of their own."""

ENOUGH = 20.0
"""Nats by which the speed must go more evenly with the rows than with the stamps."""

WILD = 5.0
"""Times the usual error beyond which one counts no more than so."""


def on_even_clock(log: Trace, vehicle: Vehicle) -> tuple[Trace, tuple[Finding, ...]]:
    """Return a log whose rows are stamped as evenly as they came, and that they are.

    As it is, where its stamps do not jitter, or the speed goes with them: each row's
    speed is laid beside the straight line between its neighbours', where it changes
    most, by the stamps and by rows that are even. Where the vehicle obeys commands,
    beside what it makes of them by either.
    """
    if "speed_mps" not in log or len(log) < FEW:
        return log, ()
    time = log["time_s"]
    row = interval_of(time)
    apart = np.diff(time) / row
    if np.abs(apart - np.round(apart)).max() < EXACT:
        return log, ()
    even = even_times(time)
    jitter = float(np.std(time - even))
    if jitter < LEAST * row or np.any(np.diff(even) <= 0.0):
        return log, ()
    if nats_for_even(log["speed_mps"], time, even) < ENOUGH:
        return log, ()
    if nats_as_commanded(log, vehicle, even) < ENOUGH:
        return log, ()
    told = Finding(
        "jitter",
        "time_s",
        f"jitters by {1000 * jitter:.2g} ms, while speed goes evenly from row to row",
        action="rows are taken as evenly spaced",
    )
    return Trace({**log.columns, "time_s": even}, name=log.name), (told,)


def even_times(time: Array) -> Array:
    """Return stamps that follow straight lines over the rows, but for lost rows."""
    from scipy.ndimage import median_filter

    rows = np.arange(len(time))
    row = interval_of(time)
    ahead = time - row * rows
    steps = np.abs(np.diff(median_filter(ahead, LOST, mode="nearest"))) > 0.5 * row
    even = ahead.copy()
    for part in np.split(rows, 1 + np.flatnonzero(steps)):
        if len(part) >= SHORT:
            even[part] = along_lines(ahead[part])
    stamps: Array = even + row * rows
    return stamps


def along_lines(x: Array) -> Array:
    """Return the straight line over some rows about each; at the ends over the last.

    A Savitzky-Golay filter of order 1 (scipy's module takes 0.7 s to load): within, it
    is the mean; of fewer rows all have one line.
    """
    from scipy.ndimage import uniform_filter1d

    rows, half = np.arange(len(x)), SMOOTH // 2
    if len(x) < SMOOTH:
        return np.asarray(np.polyval(np.polyfit(rows, x, 1), rows))
    line = uniform_filter1d(x, SMOOTH)
    for of, where in ((rows[:SMOOTH], rows[:half]), (rows[-SMOOTH:], rows[-half:])):
        line[where] = np.polyval(np.polyfit(of, x[of], 1), where)
    return np.asarray(line)


def nats_for_even(speed: Array, time: Array, even: Array) -> float:
    """Nats by which a speed is likelier smooth over even times than over its stamps."""
    by_stamps, by_rows = (_off_the_line(speed, t) for t in (time, even))
    return _nats(speed, by_stamps, by_rows)


def nats_as_commanded(log: Trace, vehicle: Vehicle, even: Array) -> float:
    """Nats by which a speed follows its commands better over even times, at least.

    From row to row the vehicle as stated errs by less; whether its commands run
    straight between their rows, or hold. Infinite where none drive it.
    """
    if not has_commands(log, vehicle):
        return inf
    speed = log["speed_mps"]
    given = {c: log[c] for c in COMMANDS.values() if c in log} | {"speed_mps": speed}
    drives = [
        drive_of(Trace({"time_s": time, **given}, name=log.name), vehicle)
        for time in (log["time_s"], even)
    ]

    def errors(drive: Drive, held: int) -> Array:
        drive = replace(drive, held=(held, drive.held[1]))
        simulated = replay(vehicle, drive, RECALLS)["speed_mps"]
        return np.asarray(np.diff(speed - simulated)[1:])

    return min(
        _nats(speed, *(errors(drive, held) for drive in drives))
        for held in (LINE, SINCE)
    )


def _nats(speed: Array, by_stamps: Array, by_rows: Array) -> float:
    """Nats by which errors at the inner rows are likelier by even rows than by stamps.

    Where the speed changes most. They have a Laplace distribution, which outliers do
    not sway.
    """
    change = np.abs(speed[2:] - speed[:-2])
    known = np.isfinite(change) & np.isfinite(by_stamps) & np.isfinite(by_rows)
    if known.sum() < FEW:
        return 0.0
    known &= change >= np.quantile(change[known], 0.75)
    both = [np.abs(e[known]) for e in (by_stamps, by_rows)]
    usual = [float(np.mean(np.minimum(e, WILD * np.median(e)))) for e in both]
    if min(usual) <= 0.0:
        return 0.0
    return float(known.sum() * np.log(usual[0] / usual[1]))


def _off_the_line(speed: Array, time: Array) -> Array:
    share = (time[1:-1] - time[:-2]) / (time[2:] - time[:-2])
    return speed[1:-1] - speed[:-2] - share * (speed[2:] - speed[:-2])
