"""What every fit to a log needs: clean rows, stretches, honest standard deviations."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rcc_sim.errors import InputError

Array = NDArray[np.float64]

GAP = 5.0
"""A step in time this many times the usual one counts as a gap. [1]"""


def finite_rows(time_s: ArrayLike, **channels: ArrayLike) -> tuple[Array, list[Array]]:
    """Rows in which the time and every channel are finite.

    Parameters
    ----------
    time_s : array_like, shape (n,)
        Time, increasing. [s]
    **channels : array_like, shape (n,)
        By the name that an error should call them.

    Returns
    -------
    t : ndarray, shape (k,)
        Time. [s]
    columns : list of ndarray, shape (k,)
        The channels, in the order given.

    Raises
    ------
    InputError
        If lengths differ, time does not increase, or fewer than 8 rows are left.
    """
    t = np.asarray(time_s, dtype=float)
    columns = {name: np.asarray(c, dtype=float) for name, c in channels.items()}
    for name, column in columns.items():
        if column.shape != t.shape or t.ndim != 1:
            raise InputError(
                f"{name}: should have one value per row of time_s, {t.shape}:"
                f" {column.shape}"
            )
    keep = np.isfinite(t)
    for column in columns.values():
        keep &= np.isfinite(column)
    if keep.sum() < 8:
        raise InputError(
            f"{', '.join(columns)}: at least 8 rows with finite values are needed:"
            f" {keep.sum()} of {t.size}",
            "is the column empty, or logged under another name?",
        )
    t = t[keep]
    back = np.flatnonzero(np.diff(t) <= 0)
    if back.size:
        raise InputError(
            f"time_s: should be strictly increasing: {t[back[0] + 1]:g} after"
            f" {t[back[0]]:g}",
            "sort the rows and drop repeated ones, or cut the log where it restarts",
        )
    return t, [column[keep] for column in columns.values()]


def stretches(mask: NDArray[np.bool_], t: Array, gap_s: float) -> list[slice]:
    """Runs of rows where `mask` holds, cut wherever time jumps by more than `gap_s`."""
    rows = np.flatnonzero(mask)
    if rows.size == 0:
        return []
    cut = np.flatnonzero((np.diff(rows) > 1) | (np.diff(t[rows]) > gap_s)) + 1
    return [slice(int(run[0]), int(run[-1]) + 1) for run in np.split(rows, cut)]


def usual_step(t: Array) -> float:
    """Median step of the time base. [s]"""
    return float(np.median(np.diff(t)))


def correlation_time(residuals: list[Array]) -> float:
    r"""Integrated autocorrelation time of residuals, in samples, at least 1.

    .. math:: \kappa = 1 + 2 \sum_{k=1}^{K} \rho_k

    summed to the first lag K with :math:`\rho_{K+1} \le 0`. Of n samples only n/κ are
    independent, so that for slowly varying regressors a covariance that assumes white
    residuals is too small by κ. [1]_ Lags never cross from one stretch to the next.

    Parameters
    ----------
    residuals : list of ndarray
        Measured minus fitted, one array per stretch, each in order of time.

    Returns
    -------
    kappa : float
        Samples per independent one. [1]

    References
    ----------
    .. [1] C. J. Geyer, "Practical Markov chain Monte Carlo," Statistical Science,
       vol. 7, no. 4, 1992, sect. 3.
    """
    total = sum(float(e @ e) for e in residuals)
    count = sum(e.size for e in residuals)
    longest = max(e.size for e in residuals)
    if total <= 0 or count < 4:
        return 1.0
    kappa = 1.0
    for lag in range(1, longest):
        pairs = sum(max(e.size - lag, 0) for e in residuals)
        if pairs < 4:
            break
        products = sum(float(e[:-lag] @ e[lag:]) for e in residuals if e.size > lag)
        rho = (products / pairs) / (total / count)
        if rho <= 0:
            break
        kappa += 2 * rho
    return min(kappa, count / 2)


def r_squared(measured: list[Array], residuals: list[Array]) -> float:
    """Share of the variance about each stretch's own mean that the fit explains."""
    spread = sum(float(np.sum((y - y.mean()) ** 2)) for y in measured)
    left = sum(float(e @ e) for e in residuals)
    return 1 - left / spread if spread > 0 else float("nan")
