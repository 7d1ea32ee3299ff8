"""B, T_C and J from the log of steps with wheels free: the arithmetic of `fit_step`."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from rcc_sim.errors import InputError
from rcc_sim.identify.motion import Motion
from rcc_sim.identify.series import Array, correlation_time, r_squared
from rcc_sim.trace import integral_of

DISTINCT = 0.1
"""Spread of the steady speeds, of the highest, from which B and T_C separate. [1]"""


JUMP = 0.3
"""Change of torque from row to row, of its range in a transient, that is a step. [1]"""

SIGNIFICANT = 3.0
"""Standard deviations from 0 that 1/J must be, or J is not identifiable. [1]"""

ROWS_PER_TRANSIENT = 12
"""Rows of a transient below which J is rough: torque is not known between rows. [1]"""


@dataclass(frozen=True)
class StepFit:
    """Damping, friction and inertia from a log; NaN with infinite sd where unknown.

    Attributes
    ----------
    B, B_sd : float
        Viscous damping and its standard deviation. [N m s/rad]
    T_C, T_C_sd : float
        Coulomb torque and its standard deviation. [N m]
    J, J_sd : float
        Inertia and its standard deviation. [kg m²]
    correlation : tuple of tuple of float
        Correlation matrix of (B, T_C, J). [1]
    identifiable : bool
        B and T_C could be told apart. If not, B holds all drag, T_C is 0 and both sds
        are infinite.
    drag, drag_sd, drag_speed : float
        Drag torque at the middle steady speed, which is known either way.
        [N m], [rad/s]
    r_squared_steady, r_squared_transient : float
        Variance explained, by stage; NaN where there is none to explain. [1]
    steady_states : int
        Steady stretches. [1]
    steady_speeds : tuple of float
        Their speeds. [rad/s]
    transients : int
        Transients fitted. [1]
    below_threshold : float
        Part of the rows below the motion threshold. [1]
    converged : bool
        Every figure is finite and B and J are positive.
    warnings : tuple of str
        What a reader should know before using the figures.
    """

    B: float
    B_sd: float
    T_C: float
    T_C_sd: float
    J: float
    J_sd: float
    correlation: tuple[tuple[float, ...], ...]
    identifiable: bool
    drag: float
    drag_sd: float
    drag_speed: float
    r_squared_steady: float
    r_squared_transient: float
    steady_states: int
    steady_speeds: tuple[float, ...]
    transients: int
    below_threshold: float
    converged: bool
    warnings: tuple[str, ...]


@dataclass(frozen=True)
class _Drag:
    """B and T_C with their covariance, and the fit's quality."""

    B: float
    T_C: float
    covariance: Array
    identifiable: bool
    r_squared: float


def fit(motion: Motion, torque: Array) -> StepFit:
    """Fit B and T_C to the steady stretches, J to the transients, until both agree.

    Parameters
    ----------
    motion : Motion
        The speed, cut into stretches.
    torque : ndarray, shape (n,)
        Motor torque. [N m]

    Returns
    -------
    StepFit
        The figures, sds, correlations and warnings.

    Raises
    ------
    InputError
        If torque and speed have opposite signs in the steady stretches.
    """
    means = _steady_means(motion, torque)
    _check_sign(means)
    J = 0.0
    for _ in range(30):
        drag = _fit_drag(means, J)
        J_new, J_sd, r2, gradient = _fit_inertia(motion, torque, drag)
        change = abs(J_new - J)
        J = J_new if math.isfinite(J_new) else 0.0
        if not change > 1e-9 * abs(J):
            break
    covariance = np.zeros((3, 3))
    covariance[:2, :2] = drag.covariance
    covariance[2, :2] = covariance[:2, 2] = drag.covariance @ gradient
    covariance[2, 2] = J_sd**2 + gradient @ drag.covariance @ gradient
    middle = float(np.median(np.abs(means[:, 0])))
    to_drag = np.array([middle, 1.0])
    sds = np.sqrt(np.diag(covariance))
    scale = np.where((sds > 0) & np.isfinite(sds), sds, 1.0)
    correlation = np.where(np.isfinite(covariance), covariance, 0.0)
    correlation /= np.outer(scale, scale)
    np.fill_diagonal(correlation, 1.0)
    drag_sd = math.sqrt(max(float(to_drag @ drag.covariance @ to_drag), 0.0))
    split = np.inf if not drag.identifiable else 0.0
    if not drag.identifiable:  # J under all viscous and all Coulomb drag: half the span
        other = _Drag(0.0, drag.B * middle, drag.covariance, False, math.nan)
        span = abs(_fit_inertia(motion, torque, other)[0] - J_new) / 2
        sds[2] = math.hypot(sds[2], span) if math.isfinite(span) else math.inf
    warnings = _warnings(motion, drag, sds, J_new, np.abs(means[:, 0]))
    return StepFit(
        B=drag.B,
        B_sd=float(sds[0]) + split,
        T_C=drag.T_C,
        T_C_sd=float(sds[1]) + split,
        J=J_new,
        J_sd=float(sds[2]),
        correlation=tuple(tuple(float(c) for c in row) for row in correlation),
        identifiable=drag.identifiable,
        drag=drag.B * middle + drag.T_C,
        drag_sd=drag_sd,
        drag_speed=middle,
        r_squared_steady=drag.r_squared,
        r_squared_transient=r2,
        steady_states=len(motion.steady),
        steady_speeds=tuple(float(w) for w in means[:, 0]),
        transients=len(motion.transient),
        below_threshold=motion.below,
        converged=bool(drag.B > 0 and J_new > 0),
        warnings=warnings,
    )


def _steady_means(motion: Motion, torque: Array) -> Array:
    """Per steady stretch: mean speed, torque and acceleration, variance of torque."""
    rows = []
    for part in motion.steady:
        t, omega, tau = motion.t[part], motion.omega[part], torque[part]
        span = t[-1] - t[0]
        weight = np.gradient(t)  # rows lost must not shift the mean
        weight /= weight.sum()
        mean = float(weight @ tau)
        rest = tau - mean
        variance = float(rest @ rest) / max(rest.size - 1, 1)
        variance *= correlation_time([rest]) / rest.size
        slope = float(np.polyfit(t - t[0], omega, 1)[0]) if span > 0 else 0.0
        rows.append((float(weight @ omega), mean, slope, variance))
    return np.asarray(rows)


def _check_sign(means: Array) -> None:
    """Raise where the torque drives against the motion in the steady stretches."""
    against = means[:, 0] * means[:, 1] < 0
    if against.mean() > 0.5:
        raise InputError(
            f"torque: {against.sum()} of {against.size} steady stretches have a torque"
            f" against the motion: {means[0, 1]:.3g} N m at {means[0, 0]:.4g} rad/s",
            "turn the sign of the torque (or of the current), or of the speed",
        )


def _fit_drag(means: Array, J: float) -> _Drag:
    """B and T_C from tau − J·slope = B ω + T_C sgn ω over the steady stretches."""
    omega, tau, slope, variance = means.T
    way = np.sign(omega)
    speed, drag = np.abs(omega), (tau - J * slope) * way
    floor = (1e-6 * float(np.max(np.abs(drag)))) ** 2
    weight = 1 / np.maximum(variance, max(floor, 1e-300))
    split = bool(np.ptp(speed) > DISTINCT * speed.max())
    X = np.column_stack([speed, np.ones_like(speed)]) if split else speed[:, None]
    normal = np.linalg.inv((X * weight[:, None]).T @ X)
    p = normal @ (X.T @ (weight * drag))
    residual = drag - X @ p
    dof = drag.size - p.size
    if dof > 0:
        normal = normal * max(1.0, float(residual @ (weight * residual)) / dof)
    covariance = np.zeros((2, 2))
    covariance[: p.size, : p.size] = normal
    r2 = r_squared([drag], [residual]) if dof > 0 and split else math.nan
    return _Drag(float(p[0]), float(p[1]) if split else 0.0, covariance, split, r2)


def _fit_inertia(
    motion: Motion, torque: Array, drag: _Drag
) -> tuple[float, float, float, Array]:
    """J, its sd, R² and dJ/d(B, T_C), from the integrated equation."""
    if not motion.transient:
        return math.nan, math.inf, math.nan, np.zeros(2)
    speeds, parts = [], []
    for rows in _between_jumps(motion.transient, torque):
        t, omega, tau = motion.t[rows], motion.omega[rows], torque[rows]
        columns = np.column_stack([tau, -omega, -np.sign(omega)])
        area = integral_of(t, columns)
        speeds.append(omega - omega.mean())
        parts.append(area - area.mean(axis=0))
    omega, area = np.concatenate(speeds), np.concatenate(parts)

    def inertia(B: float, T_C: float) -> float:
        y = area @ np.array([1.0, B, T_C])
        against = float(y @ omega)
        return float(y @ y) / against if against != 0 else math.nan

    J = inertia(drag.B, drag.T_C)
    if not (math.isfinite(J) and J != 0):
        return math.nan, math.inf, math.nan, np.zeros(2)
    drive = np.array([1.0, drag.B, drag.T_C])
    residuals = [w - a @ drive / J for w, a in zip(speeds, parts, strict=True)]
    y = area @ drive
    left = sum(float(e @ e) for e in residuals)
    dof = max(omega.size - len(parts) - 1, 1)
    variance = left / dof * correlation_time(residuals) / float(y @ y)
    if len(parts) > 2:  # errors that integrate are alike within a transient: sandwich
        scores = [float((a @ drive) @ e) for a, e in zip(parts, residuals, strict=True)]
        between = sum(score**2 for score in scores) / float(y @ y) ** 2
        variance = max(variance, between * len(parts) / (len(parts) - 1))
    slope_sd = math.sqrt(variance)
    if slope_sd * abs(J) > 1 / SIGNIFICANT:
        return math.nan, math.inf, r_squared(speeds, residuals), np.zeros(2)
    steps2 = np.array(
        [1e-4 * abs(drag.B) + 1e-12, 1e-4 * drag.B * motion.threshold + 1e-12]
    )
    gradient = np.array(
        [
            (inertia(drag.B + s * d[0], drag.T_C + s * d[1]) - J) / s
            for s, d in zip(steps2, np.eye(2), strict=True)
        ]
    )
    return J, J**2 * slope_sd, r_squared(speeds, residuals), gradient


def _between_jumps(transients: list[slice], torque: Array) -> list[slice]:
    """Cut transients where the torque jumps: the log hides when between two rows."""
    pieces = []
    for rows in transients:
        change = np.abs(np.diff(torque[rows]))
        limit = max(JUMP * float(np.ptp(torque[rows])), 8 * float(np.median(change)))
        cuts = [0, *(np.flatnonzero(change > limit) + 1).tolist(), change.size + 1]
        pieces += [
            slice(rows.start + a, rows.start + b)
            for a, b in pairwise(cuts)
            if b - a >= 4
        ]
    return pieces or transients


def _warnings(
    motion: Motion, drag: _Drag, sds: Array, J: float, speeds: Array
) -> tuple[str, ...]:
    """What a reader should know before using the figures."""
    found = []
    if not drag.identifiable:
        found.append(
            f"B and T_C are not identifiable: all {speeds.size} steady stretch(es) are"
            f" near {np.median(speeds):.4g} rad/s; B holds all drag. Log a second"
            " speed, half as high or less"
        )
    elif drag.T_C < -2 * sds[1]:
        found.append(
            f"T_C is negative, {drag.T_C:.3g} ± {sds[1]:.2g} N m: drag grows faster"
            " than the speed, or the torque has an offset"
        )
    if drag.B <= 0:
        found.append(
            f"B is not positive, {drag.B:.3g}: is the torque's sign or scale right?"
        )
    if not motion.transient:
        found.append("J is not identifiable: no transient in the log")
    elif math.isnan(J):
        found.append("J is not identifiable: the transients do not follow the torque")
    elif not J > 0:
        found.append(
            f"J is not positive, {J:.3g}: speed falls where the torque drives it"
        )
    rows = [part.stop - part.start for part in motion.transient]
    if rows and np.median(rows) < ROWS_PER_TRANSIENT:
        found.append(
            f"a transient has {np.median(rows):.0f} rows: J is rougher than its sd"
            " says; log faster"
        )
    if motion.below > 0.5:
        found.append(
            f"{100 * motion.below:.0f} % of the samples are below the motion threshold"
            f" {motion.threshold:g} rad/s"
        )
    return tuple(found)
