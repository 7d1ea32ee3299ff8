"""Speed behind a noisy speed sensor, so that its slope may be used."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from rcc_sim.channel import (
    interval_of,
    is_coarse,
    is_nil,
    is_rough,
    noise_of,
    rounded_to,
    sensor_noise,
    spells,
)
from rcc_sim.simulate.spans import ENOUGH, LONG, nats_for_means

Array = NDArray[np.float64]

ROUNDS = 6
"""Rounds of reweighting of the jerk."""

EVERY = 5
"""Of so many rows one is held out to choose the jerk."""

HOLE = 5.5
"""Usual intervals beyond which nothing is said of the time between two readings: five
are bridged, however their times are rounded."""

LOOKED_AT = 6000
"""Rows that the choice of the jerk looks at."""

GRID = (0.003, 0.01, 0.03, 0.1, 0.3, 1.0)
"""Spectral sizes of the jerk that are tried, of the drive's typical acceleration."""

PIECE = 200_000
"""Rows that are solved for at once; pieces overlap."""

OVERLAP = 1000
"""Rows beyond which one end of a piece no longer feels the other."""

CLOSEST = 0.01
"""Rows that follow each other within this share of the usual interval are taken as so
far apart: none may bend a speed without bounds."""

PASSING = 0.25
"""Share of a step to which a rounded speed is known where it passes half-way."""

SELDOM = 0.25
"""Usual interval from which on a drive bends more from row to row than what its steps
are off by. [s]"""

EVEN = 1e-6
"""Change of slope [m/s²] below which a speed is straight."""

PIECES = 10
"""Times that a reading counts at most that stands for long."""


class Smoothed(NamedTuple):
    """Speed [m/s] and acceleration [m/s²] of a drive; time over which it is smeared.

    The smear [s] is that of a smoothing spline, (noise² dt / jerk²)^(1/4): corners of
    the drive are spread over about as much to either side. 0 where nothing is smoothed.
    """

    speed: Array
    accel: Array
    smear: float = 0.0


class Felt(NamedTuple):
    """An accelerometer's rows [m/s²]; whether they are means since the row before."""

    accel: Array
    means: bool = False

    def part(self, rows: slice) -> Felt:
        """Return some of its rows."""
        return Felt(self.accel[rows], self.means)


def smoothed(
    time: Array,
    speed: Array,
    accel: Array | None = None,
    *,
    means: bool = False,
) -> Smoothed:
    """Return speed [m/s] and acceleration [m/s²] without noise and without gaps.

    A speed that is not noisy stays as it is, straight from row to row (its
    acceleration is then given as 0 and of no matter); so are gaps bridged.

    Parameters
    ----------
    time, speed : ndarray, shape (n,)
        As logged; NaN where no speed is known. [s], [m/s]
    accel : ndarray or None
        Logged acceleration, a second witness: samples, or means since the row before
        (:func:`felt_as`). [m/s²]
    means : bool
        Whether the log's other rows are means.
    """
    known = np.isfinite(speed)
    step = rounded_to(speed)
    if step:
        told, noise = passed(speed), PASSING * step
    elif not (is_rough(speed) or (interval_of(time) < SELDOM and is_coarse(speed))):
        whole = np.interp(time, time[known], speed[known])
        return Smoothed(whole, np.zeros(len(time)))
    else:
        told = speed
        noise = noise_of(speed)
    felt = None
    if accel is not None:
        felt = felt_as(time, told, accel, noise=noise, means=means)
    calm = without_noise(time, told, noise, felt=felt)
    moves = ~(stands(speed) | is_nil(time, speed, noise))
    return Smoothed(moves * calm.speed, moves * calm.accel, calm.smear)


def slope_at(time: Array, speed: Array) -> Array:
    """Return the acceleration [m/s²] at the rows of a speed that is not smoothed.

    Of the slopes before and after a row the straighter counts more,

        a = (w- a- + w+ a+) / (w- + w+),  w = (6 s² + c²)^-2,

    c being the change of slope beside it, and s the noise of a slope (weighted
    essentially non-oscillatory differences, Jiang and Shu 1996): where a drive bends
    between two rows, neither side's slope is that of the other. Halfway in a steady
    bend, and where the noise is all that bends.
    """
    before, after = slopes_beside(time, speed)
    noise = sensor_noise(speed) / interval_of(time)
    least = max(6 * noise**2, EVEN**2)
    turns = (after - before) ** 2
    turned, turning = np.append(turns[0], turns[:-1]), np.append(turns[1:], turns[-1])
    w, u = (1 / (least + turned) ** 2), (1 / (least + turning) ** 2)
    slope: Array = (w * before + u * after) / (w + u)
    return slope


def slopes_beside(time: Array, speed: Array) -> tuple[Array, Array]:
    """Return the slopes [m/s²] before and after each row; at an end the only one."""
    along = np.diff(speed) / np.diff(time)
    return np.append(along[0], along), np.append(along, along[-1])


def stands(speed: Array) -> NDArray[np.bool_]:
    """Return the rows at which a speed is nil, and was, and will be.

    A car that creeps by what smoothing leaves there would have to be driven.
    """
    nil = np.pad(speed == 0, 1, mode="edge")
    return np.asarray(nil[:-2] & nil[1:-1] & nil[2:])


def without_noise(
    time: Array, speed: Array, noise: float, *, felt: Felt | None = None
) -> Smoothed:
    """Return what a speed [m/s] is behind a known noise [m/s], however rough it looks.

    By the size of the jerk that foresees it best.
    """
    jerk = chosen_jerk(time, speed, noise=noise, felt=felt)
    calm, change = smooth_speed(time, speed, noise=noise, jerk=jerk, felt=felt)
    return Smoothed(calm, change, smear_of(noise, interval_of(time), jerk))


def felt_as(
    time: Array, speed: Array, accel: Array, *, noise: float, means: bool
) -> Felt:
    """Return what an accelerometer's rows are, by the speed [m/s] without it.

    They are as the log's other rows, ``means`` or samples, unless this tells otherwise.
    """
    row = interval_of(time)
    if row < LONG:
        return Felt(accel)
    calm, change, smear = without_noise(time, speed, noise)
    span = np.diff(time, prepend=time[0] - row)
    mean = np.diff(calm, prepend=calm[0]) / span
    bend = 0.25 * np.diff(change, prepend=change[0])  # a runs straight from row to row
    over_sample, over_late = nats_for_means(accel, mean, mean + bend, smear / row)
    needed = -ENOUGH if means else ENOUGH
    return Felt(accel, over_sample > needed and over_late > -ENOUGH)


def smear_of(noise: float, row: float, jerk: float) -> float:
    """Time [s] over which a smoothing spline smears: (noise² dt / jerk²)^(1/4)."""
    return float((noise * row**0.5 / jerk) ** 0.5)


def jerk_of(noise: float, row: float, smear: float) -> float:
    """Spectral size of the jerk by which one smears over a time [s]."""
    return float(noise * row**0.5 / smear**2)


def pieces(long: Array | NDArray[np.intp]) -> tuple[NDArray[np.int_], Array]:
    """Cut what is longer than usual: of which each piece is, and its middle's share."""
    many = np.clip(np.round(long / np.median(long)), 1, PIECES).astype(int)
    middles = np.concatenate([(np.arange(n) + 0.5) / n for n in many])
    return np.repeat(np.arange(len(many)), many), middles


def passed(speed: Array) -> Array:
    """Return what a rounded speed [m/s] tells, row by row; NaN where it tells nothing.

    Half-way between two readings where it passes from one to the next. Between two such
    places it is somewhere within half a step, whichever the row: that counts once, or
    some times where it stands for long.
    """
    rows = np.flatnonzero(np.isfinite(speed))
    v = speed[rows]
    starts, ends = spells(v)
    at, long = starts[1:] - 1, ends - starts
    total, count = np.zeros(len(v)), np.zeros(len(v))
    for end in (at, at + 1):
        np.add.at(total, end, 0.5 * (v[at] + v[at + 1]))
        np.add.at(count, end, 1.0)
    among, each = pieces(long)
    middle = starts[among] + (each * long[among]).astype(int)
    inner = middle[count[middle] == 0]
    total[inner], count[inner] = v[inner], 1.0
    told = np.full(len(speed), np.nan)
    told[rows[count > 0]] = (total / np.maximum(count, 1.0))[count > 0]
    return told


def chosen_jerk(
    time: Array, speed: Array, *, noise: float, felt: Felt | None = None
) -> float:
    """Return the jerk [m/s³ √s] that foresees rows of the speed as well as any does.

    Every fifth row is held out; what is then missed by is pooled by a robust sum, so
    that a corner of the drive does not decide. Beside an accelerometer several may do
    about as well, the roughest best if that has errors of its own, as a mean that is
    taken for a sample: of those that are behind the best by no more than a standard
    error [1]_ it is the one that does best without it, or the least that does as well.

    The grid is scaled by the drive's own acceleration over one second, or by ten times
    the noise where that is more: such a speed tells little of its acceleration beside
    an accelerometer, and what is too rough of that lightens a car by a fifth. The least
    jerk counts then that is behind the best by no more than a standard error.

    References
    ----------
    .. [1] L. Breiman et al., Classification and Regression Trees, Wadsworth, 1984,
           sec. 3.4.3 (the one-standard-error rule).
    """
    n = len(time)
    middle = max((n - LOOKED_AT) // 2, 0)
    part = slice(middle, middle + LOOKED_AT)
    t, v = time[part], speed[part]
    beside = None if felt is None else felt.part(part)
    held = np.zeros(len(t), dtype=bool)
    held[EVERY // 2 :: EVERY] = True
    held &= np.isfinite(v)
    given = np.where(held, np.nan, v)
    known = np.isfinite(given)
    if held.sum() < 10 or known.sum() < 10:
        return 0.05
    even = np.arange(t[0], t[-1], 1.0)
    change = (
        np.diff(np.interp(even, t[known], given[known])) if len(even) > 3 else [1.0]
    )
    drive = float(np.std(change))
    scale = max(drive, 10 * noise)

    def missed(share: float, witness: Felt | None) -> Array:
        jerk = share * scale
        x, _ = smooth_speed(t, given, noise=noise, jerk=jerk, felt=witness)
        return np.log1p(((x - v)[held] / noise) ** 2 / 4)

    together = np.array([missed(share, beside) for share in GRID])
    best = [int(np.argmin(together.sum(axis=1)))]
    if beside is not None or scale > drive:
        best = about_as_good(together)
    if beside is not None and scale == drive and len(best) > 1:
        alone = np.array([missed(GRID[k], None) for k in best])
        best = [best[k] for k in about_as_good(alone)]
    return float(scale * GRID[best[0]])


def about_as_good(missed: Array) -> list[int]:
    """Return which of some ways (k, n) miss by no more than a standard error more.

    Than the best of them, all they missed added up.
    """
    behind = missed - missed[np.argmin(missed.sum(axis=1))]
    error = np.sqrt(missed.shape[1]) * behind.std(axis=1)
    return np.flatnonzero(behind.sum(axis=1) <= error).tolist()


def smooth_speed(
    time: Array, speed: Array, *, noise: float, jerk: float, felt: Felt | None = None
) -> tuple[Array, Array]:
    r"""Speed [m/s], acceleration [m/s²] of a drive that changes it seldom but freely.

    The likeliest path of

    .. math:: \dot v = a, \qquad \dot a = w, \qquad y = v + e

    where w follows a Cauchy distribution (spectral size ``jerk`` [m/s³ √s]): smooth
    while a speed is held or a ramp driven, and free at the corners between. An
    accelerometer, its median offset taken off, is a second witness: of a, or, where its
    rows are means, of how v changed since the row before. Solved by reweighted least
    squares on a banded system; rows without a speed are bridged.
    """
    out = np.zeros((len(time), 2))
    for start in range(0, len(time), PIECE):
        low, high = max(start - OVERLAP, 0), min(start + PIECE + OVERLAP, len(time))
        if not np.isfinite(speed[low:high]).any():
            continue
        witness = None if felt is None else felt.part(slice(low, high))
        x = _piece(time[low:high], speed[low:high], witness, noise, jerk)
        out[start : start + PIECE] = x[start - low :][:PIECE]
    return out[:, 0], out[:, 1]


def _piece(
    time: Array, speed: Array, felt: Felt | None, noise: float, jerk: float
) -> Array:
    from scipy.linalg import solveh_banded

    n = len(time)
    dt = np.maximum(np.diff(time), CLOSEST * interval_of(time))
    known = np.isfinite(speed)
    seen, offset, accel_noise = _witness(time, speed, felt and felt.accel)
    right = np.zeros(2 * n)
    right[0::2] = np.where(known, speed, 0.0) / noise**2
    sure, change_sure = np.full(n, 1e-9), np.zeros(n - 1)
    if felt is not None:
        change = np.where(seen, felt.accel - offset, 0.0) / accel_noise**2
        if felt.means:  # (v_k - v_(k-1)) / dt at row k
            change_sure = seen[1:] / (accel_noise * dt) ** 2
            right[2::2] += change[1:] / dt
            right[:-2:2] -= change[1:] / dt
        else:
            sure += seen / accel_noise**2
            right[1::2] = change
    weight = np.ones(n - 1)
    x = np.zeros((n, 2))
    for _ in range(ROUNDS):
        stiff = weight / jerk**2
        bands = _bands(dt, stiff, known / noise**2, sure, change_sure)
        x = solveh_banded(
            bands, right, lower=True, overwrite_ab=True, check_finite=False
        ).reshape(n, 2)
        jump = np.diff(x[:, 1]) / np.sqrt(dt) / jerk
        weight = 2 / (1 + jump * jump)
    return x


def _witness(
    time: Array, speed: Array, accel: Array | None
) -> tuple[NDArray[np.bool_], float, float]:
    """Return the rows where an acceleration is known, its offset and its noise."""
    nothing = np.zeros(len(time), dtype=bool)
    if accel is None or np.isfinite(accel).sum() <= 10:
        return nothing, 0.0, 1.0
    known = np.isfinite(speed)
    seen = np.isfinite(accel) & known
    if not seen.any():
        return nothing, 0.0, 1.0
    slope = np.gradient(np.interp(time, time[known], speed[known]), time)
    offset = float(np.median((accel - slope)[seen]))
    return seen, offset, max(sensor_noise(accel), 1e-6)


def _bands(
    dt: Array, stiff: Array, v_sure: Array, a_sure: Array, change_sure: Array
) -> Array:
    """Return the lower bands of the normal equations of v and a, side by side.

    The information on each row's v and a, and on the change of v since the row before.
    """
    n = len(v_sure)
    w_v, w_a = 12 * stiff / dt**3, stiff / dt
    half = w_v * dt / 2
    mixed = half * dt / 2
    bands = np.zeros((4, 2 * n))
    bands[0, 0::2] = v_sure
    bands[0, 1::2] = a_sure
    for side in (slice(0, -1), slice(1, None)):
        bands[0, 0::2][side] += w_v + change_sure
        bands[0, 1::2][side] += mixed + w_a
    bands[1, 0::2][:-1] += half
    bands[1, 0::2][1:] -= half
    bands[1, 1::2][:-1] = -half
    bands[2, 0::2][:-1] = -w_v - change_sure
    bands[2, 1::2][:-1] = mixed - w_a
    bands[3, 0::2][:-1] = half
    return bands
