"""Damping B and inertia J at the motor shaft: from three figures or a step's log."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

from rcc_sim.errors import require_positive
from rcc_sim.identify.uncertainty import propagate

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from rcc_sim.identify.step_log import StepFit
    from rcc_sim.identify.time_constant import TimeConstant

LOOP_NOTE = (
    "J = B T holds for a step of torque (open loop); after a step of the speed"
    " reference T is the speed loop's time constant, and this J is not the rotor's"
)
"""The trap in three figures from a speed-controlled step."""


@dataclass(frozen=True)
class DampingAndInertia:
    """Viscous damping and inertia at the motor shaft from three figures.

    Attributes
    ----------
    B, B_sd : float
        Viscous damping and its standard deviation. [N m s/rad]
    J, J_sd : float
        Inertia and its standard deviation. [kg m²]
    B_budget, J_budget : Mapping of str to float
        Share of the variance by input. [1]
    warnings : tuple of str
        What a reader should know before using the figures.
    """

    B: float
    B_sd: float
    J: float
    J_sd: float
    B_budget: Mapping[str, float]
    J_budget: Mapping[str, float]
    warnings: tuple[str, ...]


def damping_and_inertia(
    speed: float,
    torque: float,
    time_constant: float,
    *,
    speed_sd: float = 0.0,
    torque_sd: float = 0.0,
    time_constant_sd: float = 0.0,
    closed_loop: bool | None = None,
) -> DampingAndInertia:
    r"""Damping and inertia from a step's end and its time constant.

    .. math:: B = \tau_s / \omega_s, \qquad J = B\,T_s

    from :math:`J \dot\omega + B \omega = \tau` with the wheels free. [1]_ All drag is
    taken for viscous: with Coulomb friction B is too large. J = B T_s holds for a step
    of *torque*; in a closed speed loop T_s is the loop's.

    Parameters
    ----------
    speed, torque : float
        Steady motor speed and torque. [rad/s], [N m]
    time_constant : float
        Time to 63.2 % of the step. [s]
    speed_sd, torque_sd, time_constant_sd : float, optional
        Standard deviations. [rad/s], [N m], [s]
    closed_loop : bool, optional
        Whether the step was in the speed reference; None where that is not known.

    Returns
    -------
    DampingAndInertia
        B and J with sds, and a note unless the loop was open.

    Raises
    ------
    InputError
        If a figure is not finite and positive.

    References
    ----------
    .. [1] S. Kumari, Anand Ronald K., S. Mukhopadhyay and A. R. Hota, "Development of a
       scaled setup for experimental study of the effect of lateral dynamics on energy
       consumption in electric vehicles: an extension," appendix. It prints 1.17e-5 and
       2.2e-6; its own figures give 1.271e-5 and 2.492e-6.
    """
    require_positive(speed=speed, torque=torque, time_constant=time_constant)
    values = {"speed": speed, "torque": torque}
    sds = {"speed": speed_sd, "torque": torque_sd}
    B = propagate(lambda speed, torque: torque / speed, values, sds)
    J = propagate(
        lambda speed, torque, time_constant: torque / speed * time_constant,
        values | {"time_constant": time_constant},
        sds | {"time_constant": time_constant_sd},
    )
    return DampingAndInertia(
        B=B.value,
        B_sd=B.sd,
        J=math.nan if closed_loop else J.value,
        J_sd=math.inf if closed_loop else J.sd,
        B_budget=B.budget,
        J_budget=J.budget,
        warnings=() if closed_loop is False else (LOOP_NOTE,),
    )


def fit_step(
    time_s: ArrayLike,
    omega: ArrayLike,
    torque: ArrayLike,
    *,
    motion_threshold: float = 5.0,
    steady_s: float | None = None,
) -> StepFit:
    r"""Damping, Coulomb friction and inertia from the log of steps with wheels free.

    .. math:: J \dot\omega + B \omega + T_C\,\mathrm{sgn}\,\omega = \tau

    B and T_C come from the steady stretches, by weighted least squares on their means;
    J from the transients, by least squares on the integrated equation

    .. math::
        \omega(t) - \omega_0 = \frac{1}{J}
            \int (\tau - B \omega - T_C\,\mathrm{sgn}\,\omega)\, dt

    which differentiates nothing. [1]_ The two steps are repeated until they agree,
    since a stretch may still drift a little. As torque is measured, the loop may be
    closed.

    Parameters
    ----------
    time_s : array_like, shape (n,)
        Time, strictly increasing; may jitter and miss rows. [s]
    omega, torque : array_like, shape (n,)
        Motor speed and torque; NaN where missing. [rad/s], [N m]
    motion_threshold : float, optional
        Speed below which the motor counts as standing. [rad/s]
    steady_s : float, optional
        Shortest stretch that may count as steady; 0.2 s or 8 rows unless given. [s]

    Returns
    -------
    StepFit
        B, T_C, J with sds and correlations. With one steady speed only, B and T_C
        cannot be told apart: `identifiable` is False and their sds are infinite.

    Raises
    ------
    InputError
        If hardly anything moves, nothing is steady, or torque drives against motion;
        says what was found.

    References
    ----------
    .. [1] R. Isermann and M. Münchhof, Identification of Dynamic Systems, Springer,
       2011, ch. 15 (integral form) and ch. 19 (friction of drives).
    """
    from rcc_sim.identify.motion import in_motion
    from rcc_sim.identify.series import finite_rows
    from rcc_sim.identify.step_log import fit

    require_positive(motion_threshold=motion_threshold)
    t, (speed, tau) = finite_rows(time_s, omega=omega, torque=torque)
    return fit(in_motion(t, speed, motion_threshold, steady_s), tau)


def fit_time_constant(
    time_s: ArrayLike,
    omega: ArrayLike,
    *,
    closed_loop: bool | None = None,
    motion_threshold: float = 5.0,
    steady_s: float | None = None,
) -> TimeConstant:
    r"""Time constant of steps where only the speed was logged.

    .. math:: \omega(t) = \omega_\infty + (\omega_0 - \omega_\infty)\, e^{-t/T}

    fitted to every transient that ends in a steady stretch. Without a torque only
    T = J/B can be had, and only if the step was in the torque (open loop); after a
    step of the speed reference T is the loop's and says nothing of J.

    Parameters
    ----------
    time_s, omega : array_like, shape (n,)
        Time and motor speed. [s], [rad/s]
    closed_loop : bool, optional
        Whether the step was in the speed reference; None where that is not known.
    motion_threshold, steady_s : float, optional
        As in `fit_step`. [rad/s], [s]

    Returns
    -------
    TimeConstant
        T with sd, and J/B where the loop is known to have been open.

    Raises
    ------
    InputError
        If hardly anything moves or no transient ends in a steady speed.
    """
    from rcc_sim.identify.motion import in_motion
    from rcc_sim.identify.series import finite_rows
    from rcc_sim.identify.time_constant import fit_steps

    require_positive(motion_threshold=motion_threshold)
    t, (speed,) = finite_rows(time_s, omega=omega)
    return fit_steps(in_motion(t, speed, motion_threshold, steady_s), closed_loop)
