"""Time constant of steps of which only the speed was logged."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from rcc_sim.errors import InputError
from rcc_sim.identify.motion import TRANSIENT, Motion
from rcc_sim.identify.series import Array, correlation_time, r_squared, usual_step
from rcc_sim.identify.uncertainty import mean_of_repeats

UNDER_WAY = 0.1
"""Part of a step after which the exponential is taken to have begun. [1]"""

OVERSHOOT = 0.05
"""Speed beyond its final value, of the step, that no first-order lag shows. [1]"""

OPEN_OR_NOT = (
    "T is J/B only if the step was in the torque (open loop); after a step of the speed"
    " reference it is the speed loop's"
)
"""The trap in a time constant."""


@dataclass(frozen=True)
class TimeConstant:
    """Time constant of steps of which only the speed was logged.

    Attributes
    ----------
    T, T_sd : float
        Time constant and its standard deviation. [s]
    inertia_over_damping : float or None
        J/B, which is T if the loop is known to have been open. [s]
    overshoot : float
        Largest excess over the final speed, of the step. [1]
    transients : int
        Transients fitted. [1]
    r_squared : float
        Variance explained. [1]
    warnings : tuple of str
        What a reader should know before using the figures.
    """

    T: float
    T_sd: float
    inertia_over_damping: float | None
    overshoot: float
    transients: int
    r_squared: float
    warnings: tuple[str, ...]


def fit_steps(motion: Motion, closed_loop: bool | None) -> TimeConstant:
    """Fit an exponential to every transient that ends in a steady stretch.

    Raises
    ------
    InputError
        If there is none.
    """
    found, residuals, speeds, overshoots = [], [], [], [0.0]
    for part in motion.transient:
        steady = [s for s in motion.steady if part.start < s.start <= part.stop]
        if not steady:
            continue
        final = float(np.mean(motion.omega[steady[0]]))
        omega = motion.omega[part.start : steady[0].stop]
        # rows before the step are no exponential; any later row starts the same one
        moved = np.abs(omega - omega[0]) > UNDER_WAY * abs(final - omega[0])
        rows = slice(part.start + int(np.argmax(moved)), steady[0].stop)
        t, omega = motion.t[rows] - motion.t[rows.start], motion.omega[rows]
        step = final - omega[0]
        if abs(step) < TRANSIENT * float(np.max(np.abs(motion.omega))):
            continue
        noise = float(np.std(motion.omega[steady[0]]))
        over = (float(np.max((omega - final) * np.sign(step))) - 4 * noise) / abs(step)
        overshoots.append(max(over, 0.0))
        T, T_sd, residual = _exponential(t, omega, final)
        found.append((T, T_sd))
        residuals.append(residual)
        speeds.append(omega)
    if not found:
        raise InputError(
            f"omega: none of {len(motion.transient)} transient(s) ends in a steady"
            " speed without a gap",
            "log the step from rest until the speed settles, at ten rows a second or"
            " more",
        )
    mean = mean_of_repeats([T for T, _ in found], [sd for _, sd in found])
    warnings = _loop_warnings(closed_loop, max(overshoots))
    if mean.excess:
        warnings += (f"the steps' time constants scatter by {mean.scatter:.2g} s",)
    step_s = usual_step(motion.t)
    if mean.value < 2 * step_s:
        warnings += (
            f"T is within two rows of the log, {step_s:.2g} s apart: log faster",
        )
    return TimeConstant(
        T=mean.value,
        T_sd=mean.sd,
        inertia_over_damping=mean.value if closed_loop is False else None,
        overshoot=float(max(overshoots)),
        transients=len(found),
        r_squared=r_squared(speeds, residuals),
        warnings=warnings,
    )


def _loop_warnings(closed_loop: bool | None, overshoot: float) -> tuple[str, ...]:
    """Whether the time constant says anything of the motor."""
    found: tuple[str, ...] = ()
    if closed_loop:
        found += (
            "the step was in the speed reference: T is the speed loop's, not J/B",
        )
    elif closed_loop is None:
        found += (OPEN_OR_NOT,)
    if overshoot > OVERSHOOT:
        seen = f"the speed overshoots by {100 * overshoot:.0f} %"
        found += (f"{seen}, as J ω̇ + B ω = τ cannot: a speed loop was closed",)
    return found


def _exponential(t: Array, omega: Array, final: float) -> tuple[float, float, Array]:
    """Time constant, its sd and the residuals of one exponential. [s], [s], [rad/s]"""
    from scipy.optimize import least_squares

    start = float(omega[0])

    def residual(p: Array) -> Array:
        model: Array = p[1] + (p[0] - p[1]) * np.exp(-t / np.exp(p[2]))
        return model - omega

    part = (omega - start) / (final - start)
    guess = float(t[np.argmax(part > 1 - math.exp(-1))]) or float(t[1])
    fitted = least_squares(residual, [start, final, math.log(guess)], x_scale="jac")
    e = np.asarray(fitted.fun, dtype=float)
    T = math.exp(fitted.x[2])
    variance = float(e @ e) / max(e.size - 3, 1) * correlation_time([e])
    jacobian = np.asarray(fitted.jac, dtype=float)
    normal = np.linalg.pinv(jacobian.T @ jacobian)
    return T, T * math.sqrt(max(variance * normal[2, 2], 0.0)), e
