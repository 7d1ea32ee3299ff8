"""Rows that no motion explains: spikes of a row or two, and poses that jump."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rcc_sim.analyse.logcheck.finding import (
    ELECTRICAL,
    KINEMATIC,
    Array,
    Columns,
    Finding,
    at,
    counted,
    is_noisy,
    sampled,
    spread,
    when,
)
from rcc_sim.definitions.sensors import INERTIAL
from rcc_sim.trace import integral_of

HARDEST = 40.0
"""Acceleration that no wheeled vehicle holds over a row. [m/s²]"""

LEAP = 5.0
"""Times that a height moves farther than 98 % of its steps where it leaps."""

BRIEF = 0.1
"""Share of a log that a height may be lost for; longer, it may be the other way."""

Rows = NDArray[np.intp]


def median_of_five(x: Array) -> Array:
    """Return the running median over five rows; the two at each end stay.

    By exchanges of pairs (Devillard's network), so that a log of millions of rows
    takes a blink.
    """
    out = x.copy()
    if len(x) < 5:
        return out
    a, b, c, d, e = (x[k : len(x) - 4 + k] for k in range(5))
    a, b = np.minimum(a, b), np.maximum(a, b)
    d, e = np.minimum(d, e), np.maximum(d, e)
    a, d = np.minimum(a, d), np.maximum(a, d)  # a: smallest of four
    b = np.minimum(b, e)  # largest of four out
    low, high = np.minimum(b, d), np.maximum(b, d)
    out[2:-2] = np.maximum(low, np.minimum(high, c))
    return out


def spikes(time: Array, name: str, values: Array) -> Rows:
    """Return the rows that stand out from their neighbours on either side (Hampel)."""
    if len(values) < 20 or name not in (*KINEMATIC, *INERTIAL, *ELECTRICAL):
        return np.empty(0, dtype=np.intp)
    x = np.where(np.isfinite(values), values, 0.0) if np.isnan(values).any() else values
    if name == "yaw_rad":
        x = np.unwrap(x)
    off = np.abs(x - median_of_five(x))
    some = sampled(off)
    least = 12 * 1.4826 * float(np.median(some))
    usual = float(np.quantile(some, 0.995))
    wide = spread(values)
    far = {**dict.fromkeys(KINEMATIC, 0.1), **dict.fromkeys(ELECTRICAL, 1.0)}
    least = max(least, 4 * usual, far.get(name, 0.7) * wide, 1e-12)
    rows = np.flatnonzero((off > least) & np.isfinite(values))
    if len(rows):
        first, last = np.maximum(rows - 2, 0), np.minimum(rows + 2, len(x) - 1)
        around = time[last] - time[first]
        rows = rows[around < 3 * (last - first) * float(np.median(np.diff(time)))]
    if name == "speed_mps" and len(rows):
        step = time[np.minimum(rows + 1, len(x) - 1)] - time[np.maximum(rows - 1, 0)]
        rows = rows[off[rows] / step > HARDEST / 2]
    if len(rows) > 0.02 * len(values):
        return np.empty(0, dtype=np.intp)  # that many are how the channel is
    return rows


def spike_findings(time: Array, name: str, values: Array, rows: Rows) -> list[Finding]:
    """Return the finding of a channel's spikes."""
    if not len(rows):
        return []
    worst = int(rows[np.argmax(np.abs(values[rows] - np.nanmedian(values)))])
    verb = "stands" if len(rows) == 1 else "stand"
    what = f"{counted(len(rows))} {verb} out alone, as {values[worst]:.5g} at "
    return [
        Finding(
            "glitch",
            name,
            what + f"{at(time, time[worst])} s",
            when(time, rows),
            sure=0.9,
            action=f"{counted(len(rows))} masked (NaN)",
            severity="warning",
            start_s=float(time[rows[0]]),
            end_s=float(time[rows[-1]]),
        )
    ]


def pose_jumps(time: Array, columns: Columns) -> list[Finding]:
    """Return where the pose moves faster than the car can, and stays there."""
    if "x_m" not in columns or "y_m" not in columns or len(time) < 20:
        return []
    x, y = columns["x_m"], columns["y_m"]
    there = np.flatnonzero(np.isfinite(x) & np.isfinite(y))
    if len(there) < 20:
        return []
    moved = np.hypot(np.diff(x[there]), np.diff(y[there]))
    steps = np.diff(time[there])
    pace = moved / steps
    changed = pace[moved > 0]
    if not len(changed):
        return []
    speed = columns.get("speed_mps")
    fastest = float(np.nanmax(np.abs(sampled(speed)))) if speed is not None else 0.0
    usual = float(np.quantile(changed, 0.98))
    limit = 5 * max(usual, fastest, 0.5)
    rows = there[1:][(pace > limit) & (moved > 0.2 * max(usual, fastest) * 0.5)]
    if not len(rows):
        return []
    far = float(moved[np.searchsorted(there[1:], rows)].max())
    return [
        Finding(
            "pose_jump",
            "x_m",
            f"the place jumps {len(rows)} times, by up to {far:.3g} m in a row: faster "
            f"than {limit:.3g} m/s",
            when(time, rows),
            sure=0.9,
            action="not mended; speeds from the pose are wrong there",
            severity="warning",
            start_s=float(time[rows[0]]),
            end_s=float(time[rows[-1]]),
        )
    ]


def height_leaps(time: Array, columns: Columns) -> tuple[Rows, list[Finding]]:
    """Return the rows whose height is not the road's, and what was found of leaps.

    A height leaps if from one reading to the next it goes farther than the vehicle
    went, and far beyond what its readings usually do. Between two leaps that all but
    undo each other it was lost; where it leaps and stays, nothing tells which is right.
    """
    nothing = np.empty(0, dtype=np.intp)
    height, speed = columns.get("elevation_m"), columns.get("speed_mps")
    if height is None or speed is None:
        return nothing, []
    there = np.flatnonzero(np.isfinite(height))
    if len(there) < 20:
        return nothing, []

    way = integral_of(time, np.abs(np.where(np.isfinite(speed), speed, 0.0)))
    rise = np.diff(height[there])
    usual = np.abs(rise[rise != 0])
    if not len(usual):
        return nothing, []
    least = LEAP * float(np.quantile(usual, 0.98))
    leaps = np.flatnonzero(
        (np.abs(rise) > least) & (np.abs(rise) > np.diff(way[there]))
    )
    if not len(leaps):
        return nothing, []
    lost, k = [], 0
    while k + 1 < len(leaps):
        a, b = leaps[k], leaps[k + 1]
        one, other = float(rise[a]), float(rise[b])
        brief = time[there[b]] - time[there[a + 1]] < BRIEF * (time[-1] - time[0])
        if brief and abs(one + other) < 0.5 * max(abs(one), abs(other)):
            lost.append(np.arange(there[a + 1], there[b] + 1))
            k += 1
        k += 1
    rows = np.concatenate(lost) if lost else nothing
    worst = leaps[np.argmax(np.abs(rise[leaps]))]
    at_row = there[worst + 1]
    return rows, [
        Finding(
            "height_leap",
            "elevation_m",
            f"leaps by {rise[worst]:+.4g} m at {at(time, time[at_row])} s, where the "
            f"vehicle went {way[at_row] - way[there[worst]]:.3g} m"
            + (f", and {len(leaps) - 1} times more" if len(leaps) > 1 else ""),
            when(time, rows if len(rows) else there[leaps + 1]),
            sure=0.95,
            action=f"{counted(len(rows))} masked (NaN)"
            if len(rows)
            else "not mended; the road is far too steep there",
            severity="warning",
            start_s=float(time[there[leaps[0]]]),
            end_s=float(time[there[leaps[-1] + 1]]),
        )
    ]


def backwards(time: Array, columns: Columns) -> list[Finding]:
    """Return when the car drives backwards."""
    speed = columns.get("speed_mps")
    if speed is None or len(speed) < 5:
        return []
    top = float(np.nanmax(np.abs(sampled(speed))))
    step = np.diff(speed[np.isfinite(speed)][:SOME])
    noise = float(np.median(np.abs(step))) if len(step) and is_noisy(speed) else 0.0
    least = max(0.03 * top, 6 * noise, 0.02)
    back = median_of_five(np.where(np.isfinite(speed), speed, 0.0)) < -least
    rows = np.flatnonzero(back)
    if not len(rows):
        return []
    lasts = len(rows) * float(np.median(np.diff(time)))
    if lasts < 0.2:
        return []
    parts = np.split(rows, np.flatnonzero(np.diff(rows) > 1) + 1)
    shown = ", ".join(
        f"{at(time, time[p[0]])}–{at(time, time[p[-1]])} s" for p in parts[:4]
    )
    more = f" and {len(parts) - 4} more" if len(parts) > 4 else ""
    return [
        Finding(
            "reversing",
            "speed_mps",
            f"is negative for {lasts:.3g} s, down to {np.nanmin(speed):.3g} m/s: the "
            "car reverses",
            shown + more,
            sure=0.9,
            action="those windows are left out; the model drives forward",
            severity="warning",
            start_s=float(time[rows[0]]),
            end_s=float(time[rows[-1]]),
        )
    ]


SOME = 50_000
"""Rows of a long log from which the noise of its speed is told."""
