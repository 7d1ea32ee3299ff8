"""The equation of a coast-down, integrated, and its least-squares solution."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from rcc_sim.identify.series import Array, correlation_time, r_squared
from rcc_sim.physics.effects.road_grade import STEEPEST, rise_over_run
from rcc_sim.trace import integral_of

STEPS = 120
"""Runge-Kutta steps over a coast. [1]"""

CLUSTERS = 5
"""Fewest coasts from which the scatter between them is worth looking at. [1]"""


@dataclass(frozen=True)
class Coast:
    """One coast, resampled where the solver needs it.

    Attributes
    ----------
    t, v : ndarray, shape (n,)
        Time from its start, and measured speed. [s], [m/s]
    way : int
        Direction, +1 or −1.
    slope : ndarray, shape (2·STEPS + 1,)
        Slope at the ends and middles of the solver's steps. [1]
    """

    t: Array
    v: Array
    way: int
    slope: Array

    @classmethod
    def of(cls, t: Array, rows: dict[str, Array], way: int) -> Coast:
        """Coast of these rows, with the slope given as such or by the elevation."""
        v, slope, elevation = (
            rows.get(n) for n in ("speed_mps", "slope", "elevation_m")
        )
        assert v is not None
        x = t - t[0]
        grid = np.linspace(0.0, x[-1], 2 * STEPS + 1)
        if elevation is not None:
            way_m = integral_of(x, v)
            height, distance = np.interp(grid, x, elevation), np.interp(grid, x, way_m)
            rise = np.gradient(height, np.maximum.accumulate(distance) + 1e-9 * grid)
            on_grid = rise_over_run(np.clip(rise, -STEEPEST, STEEPEST), 1.0)
        elif slope is not None:
            on_grid = np.interp(grid, x, slope)
        else:
            on_grid = np.zeros_like(grid)
        return cls(x, v, way, on_grid)


@dataclass(frozen=True)
class Solution:
    """Least-squares solution for one set of terms.

    Attributes
    ----------
    terms, names : tuple of str
        Terms fitted; and with the slope, where it is fitted.
    p : ndarray, shape (k,)
        Values, in the order of `names`.
    covariance : ndarray, shape (k, k)
        Widened for correlated residuals.
    dof : int
        Degrees of freedom, from the independent rows. [1]
    criterion : float
        Bayesian information criterion on the independent rows; less is better.
    r_squared, residual_sd, independent_rows : float
        As in `RoadLoad`.
    converged, message : bool, str
        The solver's word.
    """

    terms: tuple[str, ...]
    names: tuple[str, ...]
    p: Array
    covariance: Array
    dof: int
    criterion: float
    r_squared: float
    residual_sd: float
    independent_rows: float
    converged: bool
    message: str

    def value(self, name: str) -> float:
        """Estimate of a parameter."""
        return float(self.p[self.names.index(name)])

    def sd(self, name: str) -> float:
        """Its standard deviation."""
        k = self.names.index(name)
        return math.sqrt(max(float(self.covariance[k, k]), 0.0))

    def correlation(self) -> tuple[tuple[float, ...], ...]:
        """Correlation matrix of the parameters."""
        sds = np.sqrt(np.maximum(np.diag(self.covariance), 1e-300))
        matrix = self.covariance / np.outer(sds, sds)
        return tuple(tuple(float(c) for c in row) for row in matrix)


def solve(
    coasts: list[Coast],
    terms: tuple[str, ...],
    inertia: tuple[float, float],
    both: bool,
) -> Solution:
    """Fit the terms, a starting speed per coast, and a slope if `both` directions.

    Parameters
    ----------
    coasts : list of Coast
        Measured speeds.
    terms : tuple of str
        Of "A", "B", "C".
    inertia : tuple of two float
        Mass with what turns [kg], and weight [N].
    both : bool
        Fit a common slope, which acts with the sign of each coast's direction.

    Returns
    -------
    Solution
        Parameters, covariance and quality.
    """
    from scipy.optimize import least_squares

    names = terms + (("slope",) if both else ())
    k = len(names)
    measured = np.concatenate([c.v for c in coasts])
    start = np.concatenate([_first_guess(coasts, terms, inertia), [0.0] * both])
    start = np.concatenate([start, [float(c.v[:3].mean()) for c in coasts]])
    top = float(measured.max())
    unit = {"A": 1.0, "B": top, "C": top**2, "slope": inertia[1] / max(start[0], 1e-9)}
    scale = np.array(
        [max(start[0], 1e-9) / unit[n] for n in names] + [top] * len(coasts)
    )

    def residual(q: Array) -> Array:
        model = _speeds(coasts, names, inertia, (q * scale)[None, :])[0]
        missed: Array = model - measured
        return missed

    def jacobian(q: Array) -> Array:
        step = 1e-6
        moved = q[None, :] + step * np.vstack([np.eye(q.size), -np.eye(q.size)])
        both_sides = _speeds(coasts, names, inertia, moved * scale)
        return (both_sides[: q.size] - both_sides[q.size :]).T / (2 * step)

    found = least_squares(residual, start / scale, jac=jacobian, method="trf")
    jac = np.asarray(found.jac, dtype=float) / scale
    ends = np.cumsum([c.v.size for c in coasts])[:-1]
    residuals = np.split(np.asarray(found.fun, dtype=float), ends)
    left = 2 * float(found.cost)
    kappa = correlation_time(residuals)
    independent = measured.size / kappa
    normal = np.linalg.pinv(jac.T @ jac)
    variance = left / max(measured.size - found.x.size, 1)
    covariance = normal * variance * kappa
    covariance = _widened(covariance, normal, jac, residuals, ends)
    free = max(independent, 2.0)
    return Solution(
        terms=terms,
        names=names,
        p=np.asarray(found.x * scale, dtype=float)[:k],
        covariance=covariance[:k, :k],
        dof=max(int(independent) - found.x.size, 1),
        criterion=free * math.log(max(left, 1e-300) / measured.size)
        + k * math.log(free),
        r_squared=r_squared([c.v for c in coasts], residuals),
        residual_sd=math.sqrt(variance),
        independent_rows=independent,
        converged=bool(found.success),
        message=str(found.message),
    )


def _widened(
    covariance: Array, normal: Array, jac: Array, residuals: list[Array], ends: Array
) -> Array:
    """Covariance no smaller than the scatter from coast to coast says (sandwich)."""
    K = len(residuals)
    if K < CLUSTERS:
        return covariance
    scores = [j.T @ e for j, e in zip(np.split(jac, ends), residuals, strict=True)]
    between = normal @ sum(np.outer(s, s) for s in scores) @ normal * K / (K - 1)
    ratio = np.diag(between) / np.maximum(np.diag(covariance), 1e-300)
    wider: Array = np.sqrt(np.maximum(1.0, ratio))
    return covariance * np.outer(wider, wider)


def _first_guess(
    coasts: list[Coast], terms: tuple[str, ...], inertia: tuple[float, float]
) -> Array:
    """Terms by linear least squares on the equation integrated along the data."""
    rows, right = [], []
    for c in coasts:
        slope = np.interp(c.t, np.linspace(0, c.t[-1], c.slope.size), c.slope)
        powers = np.column_stack([c.v ** "ABC".index(n) for n in terms] + [slope])
        area = integral_of(c.t, powers)
        area -= area.mean(axis=0)
        rows.append(area[:, :-1])
        right.append(-inertia[0] * (c.v - c.v.mean()) - inertia[1] * area[:, -1])
    guess = np.linalg.lstsq(np.vstack(rows), np.concatenate(right), rcond=None)[0]
    if guess[0] > 0 and np.all(np.isfinite(guess)):
        return np.asarray(guess, dtype=float)
    fall = sum(float(c.v[0] - c.v[-1]) for c in coasts) / sum(
        float(c.t[-1]) for c in coasts
    )
    return np.array([inertia[0] * max(fall, 1e-6)] + [0.0] * (len(terms) - 1))


def _speeds(
    coasts: list[Coast], names: tuple[str, ...], inertia: tuple[float, float], q: Array
) -> Array:
    """Speed at every measured row for many parameter sets at once, shape (sets, rows).

    Classical Runge-Kutta over all coasts and sets together, then a cubic Hermite
    polynomial between the steps.
    """
    from scipy.interpolate import CubicHermiteSpline

    by_name = {name: q[:, i, None] for i, name in enumerate(names)}
    A, B, C, extra = (
        by_name.get(n, np.zeros((1, 1))) for n in ("A", "B", "C", "slope")
    )
    way = np.array([c.way for c in coasts], dtype=float)
    stated = np.array([c.slope for c in coasts]).T
    h = np.array([c.t[-1] for c in coasts]) / STEPS
    M, weight = inertia

    def rate(v: Array, row: int) -> Array:
        slope = stated[row] + extra * way
        climb = slope / np.sqrt(1 + slope**2)
        force = A + B * v + C * v * np.abs(v) + weight * climb
        return np.asarray(-force / M, dtype=float)

    v = np.broadcast_to(q[:, len(names) :], (q.shape[0], len(coasts))).copy()
    speeds, rates = [v], [rate(v, 0)]
    for k in range(0, 2 * STEPS, 2):
        k1 = rates[-1]
        k2 = rate(v + h / 2 * k1, k + 1)
        k3 = rate(v + h / 2 * k2, k + 1)
        k4 = rate(v + h * k3, k + 2)
        v = v + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
        speeds.append(v)
        rates.append(rate(v, k + 2))
    value, slope_of = np.array(speeds), np.array(rates)
    columns = [
        CubicHermiteSpline(
            np.linspace(0, c.t[-1], STEPS + 1), value[:, :, i], slope_of[:, :, i]
        )(c.t)
        for i, c in enumerate(coasts)
    ]
    return np.concatenate(columns, axis=0).T
