"""A heading that was measured apart, by motion capture say: how fast it turns."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from rcc_sim.channel import sensor_noise
from rcc_sim.trace import Trace, integral_of

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

TURN_RATE = "turn_rate_radps"
"""Column of the rate at which a measured heading turns."""

SPAN = 0.1
"""Time over which a heading's turn is taken, at least. [s]

Well above what a camera's noise asks for at 100 Hz, and below a steering's lag.
"""

POINTS = 5
"""Steps to either side of a row by which the slope of a heading is fitted."""

HOLE = 1.5
"""Times the span from which on rows are too far apart to take a turn between them."""

LEAP = 3.0
"""Times by which a turn exceeds all but a hundredth of the others where it is none: a
camera that lost its marks."""

LOOK = 0.5
"""Time about a row over which a place is held against the speed. [s]"""

ASTRAY, NEAR = 2.0, 0.1
"""Factor, and distance [m], by which place and speed differ where the place is lost."""

OWN = 0.02
"""Share of its own size by which a heading's turn must differ from the gyro's, and from
speed times steering, to be a measurement of its own."""


NOISY = 0.005
"""Share of a turn's mean square that may be the noise of its heading: a gyro that is
judged by it seems to read too little by as much, and its gain is told to 0.01."""


def turn_rate(time: Array, heading: Array) -> Array:
    """Mean yaw rate over the time before each row, from the heading at the rows.

        (psi(t) - psi(t - h)) / h,  h the larger of SPAN and the rows' interval

    Parameters
    ----------
    time : ndarray, shape (n,)
        Increasing. [s]
    heading : ndarray, shape (n,)
        Whole turns do not matter; NaN where not known. [rad]

    Returns
    -------
    ndarray, shape (n,)
        NaN at rows without a heading, and after holes. [rad/s]
    """
    known = np.isfinite(heading)
    if known.sum() < 2:
        return np.full(len(time), np.nan)
    at, psi = time[known], np.unwrap(heading[known])
    span = _span(at)
    rate = (np.interp(time, at, psi) - np.interp(time - span, at, psi)) / span
    return np.where(known & _joined(at, time - span, span), rate, np.nan)


def turn_at(time: Array, heading: Array) -> Array:
    """Yaw rate at each row: slope of the straight line that fits the heading about it.

        sum(k psi(t + k dt)) / (dt sum(k^2)),  k dt from -h to h

    2h is half of what turn_rate takes; the line leaves little of a camera's noise, and
    none of it as a step from one row to the next.

    Parameters and result as of :func:`turn_rate`.
    """
    known = np.isfinite(heading)
    if known.sum() < 2:
        return np.full(len(time), np.nan)
    at, psi = time[known], np.unwrap(heading[known])
    span = _span(at)
    k = np.arange(-POINTS, POINTS + 1)
    step = 0.25 * span / POINTS
    even = np.arange(at[0] - span, at[-1] + span, step)
    slope = np.convolve(np.interp(even, at, psi), -k / (step * (k @ k)), "same")
    before, after = time - 0.25 * span, time + 0.25 * span
    sound = _joined(at, before, span) & _joined(at, after, span)
    return np.where(sound, np.interp(time, even, slope), np.nan)


def _span(time: Array) -> float:
    return max(SPAN, float(np.median(np.diff(time))))


def _joined(at: Array, when: Array, span: float) -> Mask:
    """Tell the instants between two known ones that are a span apart at most."""
    since = np.searchsorted(at, when, side="right") - 1
    steps = np.diff(at, prepend=-np.inf, append=np.inf)
    found: Mask = steps[since + 1] <= HOLE * span
    return found


def once_a_span(time: Array, rate: Array) -> Array:
    """Keep the turn nearest to the end of each span, without leaps: none share time."""
    out = np.full(len(rate), np.nan)
    known = np.flatnonzero(np.isfinite(rate))
    if not len(known):
        return out
    most = LEAP * float(np.quantile(np.abs(rate[known]), 0.99))
    at = (time[known] - time[known[0]]) / _span(time)
    span = np.round(at)
    nearest = np.lexsort((np.abs(at - span), span))
    first = np.unique(span[nearest], return_index=True)[1]
    kept = known[nearest[first]]
    kept = kept[np.abs(rate[kept]) <= most]
    out[kept] = rate[kept]
    return out


def lost(log: Trace) -> Mask:
    """Tell the rows at which a place does not go as far as the speed says.

    A camera that lost the vehicle goes on giving the last place, or another's.
    """
    if not all(c in log for c in ("x_m", "y_m", "speed_mps")):
        return np.zeros(len(log), dtype=bool)
    time, speed = log["time_s"], np.abs(log["speed_mps"])
    known = np.isfinite(log["x_m"]) & np.isfinite(log["y_m"])
    rolled = np.isfinite(speed)
    if min(known.sum(), rolled.sum()) < 2:
        return ~known
    driven = integral_of(time, np.interp(time, time[rolled], speed[rolled]))
    before, after = time - 0.5 * LOOK, time + 0.5 * LOOK
    wide, deep = (
        np.interp(after, time[known], log[c][known])
        - np.interp(before, time[known], log[c][known])
        for c in ("x_m", "y_m")
    )
    way = np.interp(after, time, driven) - np.interp(before, time, driven)
    straight = np.hypot(wide, deep)
    return (straight > ASTRAY * way + NEAR) | (ASTRAY * straight + NEAR < way)


def seen_heading(log: Trace) -> Array:
    """Heading where the camera saw the vehicle. [rad]"""
    return np.where(lost(log), np.nan, log["yaw_rad"])


class Turn(NamedTuple):
    """How fast a measured heading turns: once a span, since the last; at each row.

    The second is None where its heading is too noisy for a gyro to be judged by it.
    """

    since: Array
    at: Array | None


def measured_turn(log: Trace, wheelbase: float) -> Turn | None:
    """Return how fast the heading turns, if that is a measurement of its own.

    A heading that follows from the gyro's yaw rate, or by dead reckoning from speed
    and steering, tells nothing that they do not.

    Parameters
    ----------
    log : Trace
    wheelbase : float
        [m]
    """
    if "yaw_rad" not in log:
        return None
    time, heading = log["time_s"], seen_heading(log)
    rate = turn_rate(time, heading)
    others = []
    if "yaw_rate_radps" in log:
        others.append(log["yaw_rate_radps"])
    if "steer_cmd_rad" in log and "speed_mps" in log:
        others.append(log["speed_mps"] * np.tan(log["steer_cmd_rad"]) / wheelbase)
    if any(_follows(time, rate, x) for x in others):
        return None
    at = turn_at(time, heading)
    turns = at[np.isfinite(at)]
    noise = noise_of_turn(time, heading) if len(turns) else 0.0
    clear = len(turns) > 0 and noise**2 <= NOISY * float(np.mean(turns**2))
    return Turn(once_a_span(time, rate), at if clear else None)


def noise_of_turn(time: Array, heading: Array) -> float:
    """Noise that a heading's own, white, makes of its turn at each row. [rad/s]"""
    known = np.isfinite(heading)
    noise = sensor_noise(np.unwrap(heading[known]))
    white = np.random.default_rng(0).standard_normal(len(time))
    made = turn_at(time, np.where(known, 1e-3 * white, np.nan))  # far less than a turn
    return 1e3 * noise * float(np.nanstd(made)) if np.isfinite(made).any() else 0.0


def _follows(time: Array, rate: Array, other: Array) -> bool:
    """Tell whether a turn is that of another yaw rate, up to a factor."""
    known = np.isfinite(other)
    if known.sum() < 2:
        return False
    whole = np.interp(time, time[known], other[known])
    same = turn_rate(time, integral_of(time, whole))
    both = np.isfinite(rate) & np.isfinite(same)
    x, y = same[both], rate[both]
    if not x.any():
        return not y.any()
    rest = y - x * float(x @ y) / float(x @ x)
    return bool(np.sum(rest**2) <= OWN**2 * np.sum(y**2))
