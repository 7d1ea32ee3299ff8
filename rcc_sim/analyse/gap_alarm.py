"""From where on a difference is no chance any more, over all windows of a log."""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Mapping, Sequence
from math import erfc, exp, log, log1p, sqrt

import numpy as np
from numpy.typing import NDArray

from rcc_sim.analyse.gap_channels import ChannelGap
from rcc_sim.analyse.gap_replays import Tolerances
from rcc_sim.analyse.offsets import noise_of
from rcc_sim.jit import compiled, jit

Array = NDArray[np.float64]

FALSE = 0.05
"""Share of sound logs of which any window may be flagged. [1]"""

DRAWS = 200
"""Draws of the file's figures within their sds."""

LOOKED_AT = 200
"""Windows of a channel whose tolerances are drawn; of a long log every so many."""

MOST = 20.0
"""Largest limit that is looked for. [1]"""

LEAST = 2.0
"""Smallest limit: a window within two standard deviations is never flagged. [1]"""

PRECISE = 1e-3
"""How near the limit is found. [1]"""

LEAST_CHANCE, NEVER = 1e-300, 6.0
"""Chance below which there is none, and how far out in units of √2 sds noise is never:
one window in 10¹⁶. [1]"""

CAUSES = {
    "speed_mps": ("motor_torque_nm", "motor_current_a"),
    "accel_x_mps2": ("motor_torque_nm", "motor_current_a"),
    "battery_power_w": ("motor_torque_nm", "motor_current_a"),
    "battery_current_a": ("motor_torque_nm", "motor_current_a"),
    "battery_voltage_v": ("motor_torque_nm", "motor_current_a"),
}
"""Channel -> those it follows: motion and battery answer to the motor."""


def alarm_limit(
    differences: Mapping[str, Array],
    sizes: Mapping[str, Array],
    tolerances: Tolerances,
    rows: int,
) -> float:
    r"""Mean difference of a window that a sound log exceeds in one case of twenty.

    The figures of the file are drawn within their sds, which moves all windows at
    once; noise moves each by itself. The limit L solves

    .. math:: E_\delta \prod_{c, j} P(|T_{cj}(\delta) + \rho_c n| \le L) = 0.95

    with T what a draw does to the mean of window j of channel c, in units of noise
    and tolerance there, and :math:`\rho_c` the noise of a window's mean.

    Parameters
    ----------
    differences, sizes : mapping of ndarray, each of shape (n,)
        Per channel as in :func:`rcc_sim.analyse.gap_windows.windows`.
    tolerances : Tolerances
        What the file's sds do, at some rows.
    rows : int
        Rows of a window.
    """
    half = max(rows // 2, 1)
    draws = np.random.default_rng(0).standard_normal((DRAWS, len(tolerances.keys)))
    shifts, noises, counts = [], [], []
    for name, e in differences.items():
        size = np.where(sizes[name] > 0, sizes[name], np.inf)
        means = _means(np.where(np.isfinite(e), e / size, 0.0), half)
        if len(means) < 2:
            continue
        moved = tolerances.moved.get(name, np.zeros((0, len(tolerances.rows))))
        there = np.where(np.isfinite(e[tolerances.rows]), size[tolerances.rows], np.inf)
        some = _means(np.where(np.isfinite(moved), moved, 0.0) / there, half)
        some = some[:, :: max(some.shape[1] // LOOKED_AT, 1)]
        moves = draws @ some if len(moved) else np.zeros((DRAWS, some.shape[1]))
        shifts.append(moves)
        noises.append(np.full(some.shape[1], _noise(means)))
        counts.append(np.full(some.shape[1], len(means) / some.shape[1]))
    if not shifts:
        return LEAST
    return _solved(np.hstack(shifts), np.hstack(noises), np.hstack(counts))


def _means(x: Array, rows: int) -> Array:
    """Return the means of stretches of so many rows, along the last axis."""
    count = x.shape[-1] // rows
    whole = x[..., : count * rows].reshape(*x.shape[:-1], count, rows)
    return np.asarray(whole.mean(axis=-1))


def _noise(means: Array) -> float:
    """Return the sd of a window's mean, by how it changes from one to the next."""
    change = means[2:] - means[:-2] if len(means) > 4 else means
    return min(max(noise_of(change), 1e-3), 1.0)


def _solved(shifts: Array, noises: Array, counts: Array) -> float:
    def quiet(limit: float) -> float:
        return float(compiled(chance_of_quiet)(shifts, noises, counts, limit))

    if quiet(LEAST) >= 1 - FALSE:
        return LEAST
    limits = np.linspace(LEAST, MOST, round((MOST - LEAST) / PRECISE) + 1)
    return float(limits[bisect_left(limits, 1 - FALSE, hi=len(limits) - 1, key=quiet)])


@jit
def chance_of_quiet(shifts, noises, counts, limit):  # type: ignore[no-untyped-def]
    """Probability that none of n windows is beyond a limit, a mean over m draws.

    ``shifts`` (m, n) is what each draw does to the windows, ``noises`` (n,) the sd of
    their means, ``counts`` (n,) how many windows each stands for.
    """
    total = 0.0
    for i in range(shifts.shape[0]):
        log_quiet = 0.0
        for j in range(shifts.shape[1]):
            unit, shift = noises[j] * sqrt(2.0), abs(shifts[i, j])
            if limit - shift > NEVER * unit:
                continue
            above = 0.5 * erfc((limit - shift) / unit)
            below = 0.5 * erfc((limit + shift) / unit)
            if above + below < 0.5:
                log_quiet += counts[j] * log1p(-above - below)
            else:  # what is beyond on one side is not on the other
                inside = 0.5 * erfc((shift - limit) / unit)
                log_quiet += counts[j] * log(max(inside, LEAST_CHANCE))
            if log_quiet < log(LEAST_CHANCE):
                break
        total += exp(log_quiet)
    return total / shifts.shape[0]


def strongest_first(
    gaps: Sequence[ChannelGap], flagged: frozenset[str]
) -> list[ChannelGap]:
    """Return the channels in the order in which they part, causes before what follows.

    By the difference in units of noise and tolerance; but a channel that was flagged
    stands before those that follow it: a closed speed loop lets the speed follow
    whatever acts on the motor, and the battery gives what the motor takes.
    """
    ratio = {g.channel: g.ratio or 0.0 for g in gaps}

    def place(gap: ChannelGap) -> tuple[float, bool]:
        follow = [c for c in ratio if gap.channel in CAUSES.get(c, ())]
        if gap.channel in flagged and follow:
            return -max(ratio[gap.channel], *(ratio[c] for c in follow)), False
        return -ratio[gap.channel], True

    return sorted(gaps, key=place)
