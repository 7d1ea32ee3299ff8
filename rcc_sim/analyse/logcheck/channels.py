"""One channel at a time: dead, held, stuck, clipped, coarse, with glitches."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from rcc_sim.analyse.logcheck.finding import (
    COMMANDS,
    DROPPED,
    KINEMATIC,
    MEASURED,
    Array,
    Columns,
    Finding,
    is_constant,
    is_noisy,
    parts,
    runs,
    sampled,
    spread,
    when,
)
from rcc_sim.definitions.sensors import INERTIAL
from rcc_sim.readers.own import is_named_so

STILL = (
    *("slope", "elevation_m", "direction", "on_stand"),
    *("aux_power_w", "headwind_mps", "ambient_temperature_degc"),
)
"""What may be constant over a whole log."""

BY_TURNING = ("yaw_rate_radps", "accel_y_mps2", "y_m", "yaw_rad")
"""What is zero in a drive straight on."""


SLOW = 0.3
"""Rows so far apart turn about without any noise. [s]"""

BY_DIGITS = 0.9
"""Share of a channel's changes that are one step of its last digit, from which it is
coarse and not slow: one that came seldom, while the vehicle went on, leaps by several.
"""

PILED, LEVELS = 4.0, 3
"""Times as many rows at a sensor's wall as at any of the levels next to it, where noise
takes it off the wall at once: a tail thins out, it does not pile up."""

POSE = ("x_m", "y_m", "yaw_rad", "elevation_m")


def dead(columns: Columns, step: float) -> list[Finding]:
    """Return the channels that hold one value all along, and what that means.

    ``step`` is the usual time between two rows. [s]
    """
    found = []
    fixed = {n: v for n, v in columns.items() if is_constant(v)}
    empty = [n for n, v in columns.items() if not np.isfinite(v).any()]
    found += [_dead(name, "has no value in any row") for name in empty]
    moves = "speed_mps" not in fixed and "speed_mps" in columns
    turns = "steer_cmd_rad" in columns and "steer_cmd_rad" not in fixed
    noisy = [is_noisy(columns[n]) for n in MEASURED if n in columns and n not in fixed]
    real = step < SLOW and 2 * sum(noisy) > len(noisy)
    for name, values in fixed.items():
        if name in empty or name == "time_s":
            continue
        value = float(values[np.isfinite(values)][0]) + 0.0  # no minus zero
        if name.startswith(("energy_", "battery_energy")) or name == "current_d_a":
            continue
        if not is_named_so(name):  # none of ours, and said so
            continue
        what = f"is {value:.6g} in every row"
        harmless = (
            name in STILL
            or name not in MEASURED
            or (name in BY_TURNING and value == 0 and not turns and not real)
            or (name == "battery_voltage_v" and value > 0 and not real)
            or (name != "battery_voltage_v" and not moves and name in KINEMATIC)
        )
        if name == "speed_mps":
            found.append(
                Finding(
                    "never_moves", name, what, severity="warning" if real else "info"
                )
            )
        elif harmless:
            found.append(Finding("constant", name, what))
        else:
            found.append(_dead(name, f"{what}: no sensor behind it, or it is stuck"))
    return found


def _dead(name: str, what: str) -> Finding:
    return Finding(
        "dead", name, what, sure=0.95, action=f"removed; {DROPPED}", severity="error"
    )


def zero_start(time: Array, columns: Columns) -> tuple[int, list[Finding]]:
    """Return how many first rows are all zero: written before the sensors spoke."""
    own = [n for n in MEASURED if n not in POSE]  # the pose is another system's
    names = [n for n in own if n in columns and is_noisy(columns[n])]
    names = [n for n in names if np.mean(sampled(columns[n]) == 0) < 0.05]
    volts = columns.get("battery_voltage_v")
    if volts is not None and np.mean(sampled(volts) == 0) < 0.05:
        names = [*dict.fromkeys([*names, "battery_voltage_v"])]
    if len(names) < 2 and "battery_voltage_v" not in names:
        return 0, []
    count = len(time)
    for name in names:
        other = columns[name][: len(time) // 2] != 0
        count = min(count, int(other.argmax()) if other.any() else len(other))
    if count == 0 or (count < 2 and "battery_voltage_v" not in names):
        return 0, []
    return count, [
        Finding(
            "zero_start",
            names[0] if len(names) == 1 else "all sensors",
            f"{', '.join(names)}: exactly zero in the first {count} rows",
            when(time, np.arange(count)),
            sure=0.9,
            action=f"{count} rows left out",
            severity="warning",
            start_s=float(time[0]),
            end_s=float(time[count - 1]),
        )
    ]


def held(time: Array, name: str, values: Array) -> list[Finding]:
    """Return the finding of a channel that updates more slowly than the rows come."""
    every = _between_changes(values)
    k = float(np.median(every)) if len(every) >= 10 else 1.0
    if k < 2:
        return []
    near = float(np.mean(np.abs(every - k) <= max(0.1 * k, k > 3)))
    early = float(np.mean(every < 0.7 * k))
    if near < 0.6 or early > 0.05 or goes_by_digits(values):
        return []
    step = float(np.median(np.diff(time)))
    return [
        Finding(
            "slow_channel",
            name,
            f"changes every {k:.0f} rows only: about {1 / (k * step):.3g} Hz",
            sure=min(0.99, near),
            action="used as it is; the held value lags by up to "
            f"{(k - 1) * step:.3g} s",
        )
    ]


def goes_by_digits(values: Array) -> bool:
    """Tell whether a channel changes by its last digit alone, up or down.

    A ramp in whole km/h changes every few rows, too, as often as it is steep.
    """
    known = np.unique(values[np.isfinite(values)])
    if len(known) < 2:
        return False
    digit = float(np.median(np.diff(known)))
    steps = np.abs(np.diff(values))
    return float(np.mean(steps[steps > 0] < 1.5 * digit)) > BY_DIGITS


def _between_changes(values: Array) -> NDArray[np.intp]:
    """Return the numbers of rows from one change of a channel to the next."""
    part = parts(len(values), 20_000)
    return np.concatenate(
        [np.diff(np.flatnonzero(np.diff(values[p]) != 0)) for p in part]
    )


def stuck(
    time: Array, name: str, values: Array, speed: Array | None
) -> list[tuple[int, int]]:
    """Return stretches in which a channel holds one value while the car drives.

    First row and one past the last. A command may hold, and so may a limit.
    """
    if name in COMMANDS or name not in MEASURED or speed is None or len(values) < 100:
        return []
    noisy = is_noisy(values)
    starts, ends = runs(np.concatenate([[False], np.diff(values) == 0]))
    changing = float(np.mean(sampled(np.diff(values)) != 0))
    if not len(starts) or not (noisy or changing > 0.98):
        return []
    lengths = ends - starts
    need = _longest_chance(time, lengths, changing)
    fast = 0.1 * float(np.nanmax(np.abs(sampled(speed)), initial=0.0))
    walls = (np.nanmin(values), np.nanmax(values))
    found = []
    for k in np.flatnonzero(lengths > need):
        first, end = max(int(starts[k]) - 1, 0), int(ends[k])
        if values[first] in walls or not (noisy or _resumes(values, end)):
            continue
        if name == "speed_mps":
            lives = abs(values[first]) > fast or _leaps(values, first, end)
        else:
            part = speed[first:end]
            lives = float(np.median(np.abs(part))) > fast and bool(np.ptp(part) > 0)
        if lives:
            found.append((first, end))
    return found


def _longest_chance(time: Array, lengths: NDArray[np.intp], changing: float) -> float:
    """Return the most rows that a channel may hold a value without being stuck."""
    usual = float(np.quantile(lengths, 0.98)) if len(lengths) > 20 else 1.0
    need = max(10.0, 8 * usual, 0.3 / float(np.median(np.diff(time))))
    if changing < 0.999:  # so many equal rows by chance: once in 1e12
        need = max(need, 12.0 / -np.log10(max(1 - changing, 1e-12)))
    return need


def stuck_findings(
    time: Array, name: str, values: Array, found: list[tuple[int, int]]
) -> list[Finding]:
    """Return the finding of a channel's stuck stretches."""
    if not found:
        return []
    first, end = max(found, key=lambda pair: pair[1] - pair[0])
    lasts = float(time[end - 1] - time[first])
    rows = sum(stop - start - 1 for start, stop in found)
    times = f", the longest of {len(found)} times" if len(found) > 1 else ""
    return [
        Finding(
            "stuck",
            name,
            f"holds {values[first]:.6g} for {lasts:.3g} s while the car drives{times}",
            when(time, np.arange(first, end)),
            sure=0.9,
            action=f"{rows} rows masked (NaN)",
            severity="warning",
            start_s=float(time[first]),
            end_s=float(time[end - 1]),
        )
    ]


def stuck_rows(found: list[tuple[int, int]]) -> NDArray[np.intp]:
    """Return the rows of stuck stretches that hold no reading of their own."""
    rows = [np.arange(first + 1, end) for first, end in found]
    return np.concatenate(rows) if rows else np.empty(0, dtype=np.intp)


def _resumes(values: Array, end: int) -> bool:
    """Tell whether a smooth channel leaps on when it lives again."""
    if end >= len(values):
        return False
    usual = float(np.median(np.abs(np.diff(sampled(values)))))
    return bool(abs(values[end] - values[end - 1]) > 5 * usual)


def _leaps(values: Array, first: int, end: int) -> bool:
    """Tell whether a speed drops to a held value and comes back in one row each."""
    if first == 0 or end >= len(values):
        return False
    into = abs(values[first] - values[first - 1])
    out = abs(values[end] - values[end - 1])
    usual = float(np.quantile(np.abs(np.diff(sampled(values))), 0.99))
    return bool(min(into, out) > 10 * usual)


def clipped(time: Array, name: str, values: Array) -> list[tuple[float, Finding]]:
    """Return the walls at which a sensor ends, the same extreme in many rows, as found.

    A limit of the current is no wall, and NaN.
    """
    if name not in (*INERTIAL, "motor_current_a", "battery_current_a"):
        return []
    some = values[np.isfinite(values)]
    if len(some) < 200 or not is_noisy(values):
        return []
    every = _between_changes(values)
    k = float(np.median(every)) if len(every) else 1.0
    found = []
    for side, wall in ((1, float(some.max())), (-1, float(some.min()))):
        at = side * values >= side * wall
        beside = (side * values)[~at & np.isfinite(values)]
        near = beside >= min(side * wall - 0.05 * spread(values), beside.max())
        count, around = int(at.sum()), int(near.sum())
        starts, ends = runs(at)
        long = int((ends - starts).max())
        stays = long >= 4 * k and count > 0.5 * around
        piled = count > PILED * _most_alike(beside)
        if wall != 0 and count >= 8 * k and (stays or piled):
            limit = "current" in name
            said = Finding(
                "saturated",
                name,
                f"sits at {wall:.6g} in {count} rows, up to {long} on end, and "
                f"never goes {'above' if side > 0 else 'below'}: "
                + ("a limit" if limit else "the sensor's range ends there"),
                when(time, np.flatnonzero(at)),
                sure=0.85,
                action=USED_LIMIT if limit else "those rows are masked (NaN)",
                severity="info" if limit else "warning",
            )
            found.append((np.nan if limit else wall, said))
    return found


def _most_alike(values: Array) -> int:
    """Return how many rows hold the commonest of the highest few values."""
    counts = np.unique(values, return_counts=True)[1]
    return int(counts[-LEVELS:].max(initial=1))


USED_LIMIT = "used as it is; a controller's limit explains it"


def clipped_rows(values: Array, walls: Sequence[float]) -> NDArray[np.intp]:
    """Return the rows at a sensor's walls, to be masked."""
    return np.flatnonzero(np.isin(values, walls))


def coarse(name: str, values: Array) -> list[Finding]:
    """Return the finding of a channel whose resolution is coarser than its steps."""
    if name in COMMANDS:
        return []
    some = sampled(values, 20_000)
    some = some[np.isfinite(some)]
    levels = np.unique(some)
    if len(some) < 200 or len(levels) < 3 or len(levels) > len(some) / 10:
        return []
    gaps = np.diff(levels)
    gaps = gaps[gaps > 1e-9 * max(abs(levels[0]), abs(levels[-1]))]
    if not len(gaps):
        return []
    quantum = float(np.quantile(gaps, 0.1))
    steps = np.abs(np.diff(some))
    steps = steps[steps > 0]
    if not len(steps) or float(np.median(steps)) > 3 * quantum:
        return []
    return [
        Finding(
            "quantised",
            name,
            f"has a resolution of {quantum:.3g}, {100 * quantum / np.ptp(levels):.2g} "
            "% of its range: rows differ by one or two steps",
            sure=0.9,
            action="used as it is; the resolution counts as noise",
        )
    ]
