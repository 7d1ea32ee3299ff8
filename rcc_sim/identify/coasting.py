"""Where a log coasts."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rcc_sim.channel import sensor_noise
from rcc_sim.errors import InputError
from rcc_sim.identify.series import GAP, Array, stretches, usual_step

ROWS_MIN = 6
"""Fewest rows of a coast. [1]"""

DROP_MIN = 0.2
"""Least fall of speed of a coast, of the top speed. [1]"""

DRIVE_NEAR_ZERO, NOISY = 0.02, 4.0
"""Size of the drive up to which it counts as none: of its largest, and in standard
deviations of its noise, which is all that a log of nothing but coasts has. [1]"""

LONG_ENOUGH = 0.5
"""Fall of speed, of the largest in the log, that makes a deceleration count. [1]"""

SETTLE_S = 0.15
"""What is left out at the start of a coast, while the drive's torque dies away. [s]"""


def find_coasts(
    t: Array,
    v: Array,
    drive: Array | None,
    threshold: float | None,
    min_speed: float | None,
) -> tuple[list[slice], tuple[str, ...]]:
    """Coasting stretches of a log.

    Parameters
    ----------
    t, v : ndarray, shape (n,)
        Time and speed. [s], [m/s]
    drive : ndarray, shape (n,), or None
        Torque, current or throttle, in any unit.
    threshold : float or None
        Size of `drive` up to which it is none.
    min_speed : float or None
        Speed at which a coast ends. [m/s]

    Returns
    -------
    coasts : list of slice
        Rows of each, at least one.
    warnings : tuple of str
        How they were found, where that matters.

    Raises
    ------
    InputError
        If there is none; says what was found.
    """
    top = float(np.quantile(v, 0.999))
    if top <= 0:
        raise InputError(
            f"speed_mps: the car never moves forwards: at most {top:.3g} m/s"
        )
    floor = 0.05 * top if min_speed is None else min_speed
    rolling = v > floor
    gap = max(GAP * usual_step(t), 1.0)
    warnings: tuple[str, ...] = ()
    if drive is None:
        parts = _decelerations(t, v, rolling, gap, top)
        taken = f"the {len(parts)} longest deceleration(s) were taken for coasting"
        warnings = (f"no drive signal: {taken}, and a brake cannot be told from drag",)
        what = "decelerations"
    else:
        least = DRIVE_NEAR_ZERO * float(np.max(np.abs(drive)))
        limit = max(least, NOISY * sensor_noise(drive))
        limit = limit if threshold is None else threshold
        parts = [
            _settled(t, part)
            for part in stretches(rolling & (np.abs(drive) <= limit), t, gap)
        ]
        what = f"stretches with the drive within ±{limit:.3g}"
    found = [
        part
        for part in parts
        if part.stop - part.start >= ROWS_MIN
        and v[part][:3].mean() - v[part][-3:].mean() > DROP_MIN * top
    ]
    if not found:
        raise InputError(
            f"speed_mps: no coast: none of {len(parts)} {what} above {floor:.3g} m/s"
            f" lasts {ROWS_MIN} rows and loses {100 * DROP_MIN:g} % of the top speed,"
            f" {top:.3g} m/s",
            "let the car roll out from speed with no torque; for a drive signal that is"
            " off, or wanders, give --drive-threshold",
        )
    return found, warnings


def _settled(t: Array, part: slice) -> slice:
    """Return the stretch without its start, while the drive's torque dies away."""
    late = int(np.searchsorted(t[part], t[part.start] + SETTLE_S))
    return slice(part.start + late, part.stop)


def _decelerations(
    t: Array, v: Array, rolling: NDArray[np.bool_], gap: float, top: float
) -> list[slice]:
    """Longest stretches over which the speed, apart from noise, only falls."""
    slack = max(4 * sensor_noise(v), 0.01 * top)
    parts = []
    for run in stretches(rolling, t, gap):
        start = low = run.start
        for k in range(run.start + 1, run.stop):
            if v[k] < v[low]:
                low = k
            if v[k] > v[low] + slack or k == run.stop - 1:
                parts.append(slice(_last_peak(v, start, low, slack), low + 1))
                start = low = k
    drops = [v[p.start] - v[p.stop - 1] for p in parts]
    most = max(drops, default=0.0)
    return [
        p for p, drop in zip(parts, drops, strict=True) if drop >= LONG_ENOUGH * most
    ]


def _last_peak(v: Array, start: int, low: int, slack: float) -> int:
    """Return the last row up to `low` from which the speed falls for good."""
    near_top = v[start : low + 1] > v[start : low + 1].max() - slack
    return start + int(np.flatnonzero(near_top)[-1])
