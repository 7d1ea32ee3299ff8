"""What a channel's own rows tell: its noise, its rounding, where it stands still."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

ROWS = 200_000
"""Rows that are looked at."""

SPREADS = 2.0
"""Times by which bends over two rows exceed those over one, below which a channel is
noisy: 1 for white noise, sqrt(2) where a rate is white, sqrt(8) where what changes the
rate is, and 4 for a smooth curve. A drive's rate goes on from row to row: EPA schedules
of a row a second have 2.3 to 3.4, a BMW's wheel speeds at 10 Hz have 1.4 to 1.8."""

BENDS, BENT = 0.64, 0.8
"""Share of rows at which the bend turns, and share that bend at all, above which a
channel is noisy however sharp its corners. The bends of white noise turn at 0.73, and
at half the rows if a drive makes them: at 0.46 to 0.57 in EPA schedules of a row a
second.
"""

FEW = 20
"""Changes from which on their share is a measure."""

STANDS, ONE_STEP, WHOLE = 0.3, 1.5, 0.1
"""Share of rows under way that repeat the one before, median of the others' changes in
steps, and what they are off a whole step, by which a speed is known to be rounded."""

LITTLE = 1e-6
"""Share of its largest value that a speed errs at least, where it is smoothed."""

ROUNDING = 1e-9
"""Share of a channel's size below which a difference is none."""

DUST = 1e-5
"""The same of what other units and few digits leave of one: 0.1 km/h with five decimals
of a metre per second."""

LEAST, STEPS_WIDE, STEPPED = 0.02, 6.0, 0.9
"""Share of a channel's changes below which the least is sought of which the others are
multiples; multiples that are looked at; and the share of them that must be whole within
``WHOLE``: of changes of any size it would be a fifth."""

STILL, RESTS, GENTLE = 4.0, 0.5, 0.5
"""Times the noise of its mean that a speed may be off nil where the vehicle stands;
time over which that is a mean [s]; and acceleration with which one pulls away at least.
[m/s²]"""

BLURS = 0.07
"""Size of what a resolution makes of a change from row to row, in times that change,
from which on it matters: a mass is then told half a per cent too small (its square)."""


def sensor_noise(x: Array) -> float:
    """Noise [unit of x] of a sampled signal, from its second differences.

    For white noise of variance s² these have 6 s²; their median keeps the drive's own
    accelerations out. At least a third of the resolution of a quantised signal.
    """
    d2 = np.diff(x[np.isfinite(x)], 2)
    if len(d2) < 3:
        return 0.0
    noise = 1.4826 * float(np.median(np.abs(d2))) / 6**0.5
    return max(noise, resolution(x) / 3)


def resolution(x: Array) -> float:
    """Return the steps [unit of x] of which all changes from row to row are multiples.

    0 where they are not: a signal of full digits, or whose noise hides them.
    """
    v = x[np.isfinite(x)][:ROWS]
    change = np.abs(np.diff(v))
    change = np.sort(change[change > DUST * np.abs(v).max(initial=0.0)])
    if len(change) < FEW:
        return 0.0
    least = change[int(LEAST * len(change))]
    near = change[(change > least * (1 - WHOLE)) & (change < ONE_STEP * least)]
    step = float(np.median(near))
    times = change[change < STEPS_WIDE * step] / step
    whole = np.abs(times - np.round(times)) < WHOLE
    return step if bool(np.mean(whole) > STEPPED) else 0.0


def is_coarse(speed: Array) -> bool:
    """Tell whether its resolution blurs a speed's changes from row to row."""
    v = speed[np.isfinite(speed)][:ROWS]
    if len(v) < 2:
        return False
    blur = resolution(v) / 6**0.5  # of a difference of two
    return bool(blur > BLURS * np.sqrt(np.mean(np.diff(v) ** 2)))


def noise_of(speed: Array) -> float:
    """Noise [m/s] of a speed that is to be smoothed; not so little that nothing is."""
    return max(sensor_noise(speed), LITTLE * float(np.nanmax(np.abs(speed))))


def is_rough(x: Array) -> bool:
    """Tell whether neighbouring rows scatter, as a sensor's do and a model's do not.

    By how little wider bends exceed narrow ones; by how often the bends turn.
    """
    v = x[np.isfinite(x)][:ROWS]
    near, wide = np.diff(v, 2), v[4:] - 2 * v[2:-2] + v[:-4]
    least = ROUNDING * np.abs(v).max(initial=0.0)
    bends = near[np.abs(near) > least]
    if len(bends) <= FEW:
        return False
    if np.abs(wide).sum() < SPREADS * np.abs(near).sum():
        return True
    return len(bends) > BENT * len(v) and turning(bends) > BENDS


def turning(changes: Array) -> float:
    """Return the share of changes [any unit] whose sign is not that of the last."""
    some = changes[changes != 0]
    return float(np.mean(some[1:] * some[:-1] < 0)) if len(some) > FEW else 0.0


def rounded_to(speed: Array) -> float:
    """Return the steps [m/s] to which a speed is rounded, if that is what is seen.

    Under way it stands for some rows, and then changes by one step.
    """
    v = speed[np.isfinite(speed)][:ROWS]
    change = np.abs(np.diff(v))[(v[1:] != 0) | (v[:-1] != 0)]
    steps = change[change > ROUNDING * float(np.abs(v).max(initial=0.0))]
    if len(steps) < FEW or 1 - len(steps) / len(change) < STANDS:
        return 0.0
    step = float(np.median(steps[steps < 2 * steps.min()]))
    whole = np.abs(steps / step - np.round(steps / step)) < WHOLE
    one = float(np.median(steps)) < ONE_STEP * step
    return step if one and bool(np.mean(whole) > 1 - WHOLE) else 0.0


def spells(x: NDArray[Any]) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Return the first row, and one past the last, of each run of equal values."""
    at = np.flatnonzero(np.diff(x) != 0) + 1
    return np.append(0, at), np.append(at, len(x))


def interval_of(time: Array) -> float:
    """Return the usual time [s] between two rows; 0 where there is one alone."""
    return float(np.median(np.diff(time))) if len(time) > 1 else 0.0


def rows_in(time: Array, seconds: float) -> int:
    """Return how many rows a time lasts, an odd number. [s]"""
    return 2 * round(seconds / interval_of(time) / 2) + 1


def moving_mean(x: Array, rows: int) -> Array:
    """Return the mean of a channel over some rows about each, gaps bridged."""
    known = np.isfinite(x)
    if not known.any():
        return np.zeros(len(x))
    whole = x
    if not known.all():
        whole, there = x.copy(), np.flatnonzero(known)
        whole[~known] = np.interp(np.flatnonzero(~known), there, x[known])
    half = (min(rows, len(x)) - 1) // 2
    first, last = np.full(half + 1, whole[0]), np.full(half, whole[-1])
    total = np.cumsum(np.concatenate([first, whole, last]))
    return np.asarray((total[2 * half + 1 :] - total[: len(x)]) / (2 * half + 1))


def bridged(time: Array, x: Array) -> Array:
    """Return a channel without gaps, straight over time across each; else nil."""
    known = np.isfinite(x)
    if known.all():
        return x
    return np.interp(time, time[known], x[known]) if known.any() else np.zeros(len(x))


def is_nil(time: Array, speed: Array, noise: float) -> Mask:
    """Return the rows at which a speed [m/s] is nil but for its noise.

    Its mean over a while T is. That of a vehicle that pulls away at a is v at
    √(2 T v / a) - T/2 after it did: so near, none may be more.
    """
    half, whole = rows_in(time, RESTS) // 2, bridged(time, speed)
    total, count = (within(x, half) for x in (whole, np.ones(len(time))))
    # of seldom rows much is no noise
    least = np.minimum(STILL * noise / np.sqrt(count), GENTLE * RESTS)
    moves = np.abs(total) > least * count
    near = np.sqrt(2 * RESTS * float(np.median(least)) / GENTLE) - RESTS / 2
    return np.asarray(within(moves, max(rows_in(time, 2 * near) // 2, 0)) < 0.5)


def within(x: NDArray[Any], rows: int) -> Array:
    """Return the sum of a channel over some rows before and after each, and its own."""
    total = np.concatenate([[0.0], np.cumsum(x)])
    places = np.arange(len(x))
    last = np.minimum(places + rows + 1, len(x))
    return np.asarray(total[last] - total[np.maximum(places - rows, 0)])
