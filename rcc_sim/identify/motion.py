"""The log of a motor, cut into steady stretches and transients."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rcc_sim.errors import InputError
from rcc_sim.identify.series import GAP, Array, stretches, usual_step

STEADY_S = 0.2
"""Shortest stretch that counts as steady. [s]"""

STEADY_ROWS = 8
"""Fewest rows of a steady stretch. [1]"""

STEADY_CHANGE = 0.02
"""Most that a steady speed may change over that stretch, of the top speed. [1]"""

TRANSIENT = 0.05
"""Least change of speed that makes a transient, of the top speed. [1]"""


@dataclass(frozen=True)
class Motion:
    """A log cut into steady stretches and transients.

    Attributes
    ----------
    t, omega : ndarray, shape (n,)
        Time and speed. [s], [rad/s]
    steady, transient : list of slice
        Stretches of rows.
    below : float
        Part of the rows below the motion threshold. [1]
    threshold : float
        That threshold. [rad/s]
    """

    t: Array
    omega: Array
    steady: list[slice]
    transient: list[slice]
    below: float
    threshold: float


def in_motion(
    t: Array, omega: Array, threshold: float, steady_s: float | None
) -> Motion:
    """Cut a log into steady stretches and transients, or say why that fails.

    Raises
    ------
    InputError
        If fewer than 10 rows move or no speed is steady.
    """
    moving = np.abs(omega) > threshold
    below = 1 - float(moving.mean())
    found = (
        f"{100 * below:.0f} % of the samples are below the motion threshold"
        f" {threshold:g} rad/s, the largest speed is {np.max(np.abs(omega)):.4g} rad/s"
    )
    if moving.sum() < 10:
        raise InputError(
            f"omega: {found}",
            "gearing or unit? The motor's speed is wanted, in rad/s: neither the"
            " wheel's nor ERPM",
        )
    step = usual_step(t)
    gap = GAP * step
    window = max(STEADY_S, STEADY_ROWS * step) if steady_s is None else steady_s
    sign = np.sign(omega)
    runs = [
        part
        for way in (-1, 1)
        for part in stretches(moving & (sign == way), t, max(gap, window / 4))
    ]
    runs.sort(key=lambda run: run.start)
    top = float(np.max(np.abs(omega)))
    is_steady = np.zeros(t.size, dtype=bool)
    for run in runs:
        is_steady[run] = _steady_rows(t[run], omega[run], window, STEADY_CHANGE * top)
    steady = [
        part
        for part in stretches(is_steady, t, gap)
        if part.stop - part.start >= 5 and np.ptp(t[part]) >= window / 2
    ]
    if not steady:
        raise InputError(
            f"omega: no stretch of {window:.2g} s in which the moving motor holds its"
            f" speed to {100 * STEADY_CHANGE:g} %; {found}",
            "hold each step until the speed settles; two speeds at least",
        )
    transient = []
    for run in runs:
        loose = np.zeros(t.size, dtype=bool)
        loose[run] = True
        for part in steady:
            loose[part] = False
        for part in stretches(loose, t, gap):
            wide = slice(max(part.start - 3, run.start), min(part.stop + 3, run.stop))
            if wide.stop - wide.start >= 4 and np.ptp(omega[wide]) > TRANSIENT * top:
                transient.append(wide)
    return Motion(t, omega, steady, transient, below, threshold)


def _steady_rows(
    t: Array, omega: Array, window: float, most: float
) -> NDArray[np.bool_]:
    """Rows whose window's regression line changes by less than `most` or its noise."""
    steady = np.zeros(t.size, dtype=bool)
    if t[-1] - t[0] < 0.9 * window:
        return steady
    centre = t - t.mean()
    sums = [
        np.concatenate([[0.0], np.cumsum(v)])
        for v in (np.ones_like(t), centre, omega, centre**2, centre * omega, omega**2)
    ]
    starts = np.clip(t - window / 2, t[0], t[-1] - window * 0.999)
    low = np.searchsorted(t, starts)
    high = np.searchsorted(t, starts + window, side="right")
    n, s_t, s_w, s_tt, s_tw, s_ww = (s[high] - s[low] for s in sums)
    enough = n >= 5
    n = np.where(enough, n, 5.0)
    var_t = np.maximum(s_tt / n - (s_t / n) ** 2, 1e-300)
    slope = (s_tw / n - s_t * s_w / n**2) / var_t
    left = np.maximum(s_ww / n - (s_w / n) ** 2 - slope**2 * var_t, 0.0)
    slope_sd = np.sqrt(left / var_t / np.maximum(n - 2, 1))
    change = np.abs(slope) * window
    curved = np.sqrt(left) > 3 * most  # a corner inside the window, not noise
    level: NDArray[np.bool_] = change < np.maximum(most, 3 * slope_sd * window)
    level &= enough & ~curved
    return level
