"""The bifilar pendulum's equation: inertia from period and period from inertia."""

from __future__ import annotations

import math

from rcc_sim.errors import InputError, require_positive
from rcc_sim.units import G

QUADRATURE = 64
"""Points of the mid-point rule over a quarter swing; it converges exponentially. [1]"""


def small_swing_inertia(
    m: float, T: float, d: float, h: float, d_below: float | None = None
) -> float:
    r"""Yaw inertia from the period of a small swing; equation in `bifilar.yaw_inertia`.

    Parameters
    ----------
    m, T : float
        Mass on the wires and full period. [kg], [s]
    d, h : float
        Distance between the wires above, and their length. [m]
    d_below : float, optional
        Distance between the wires below, where it differs. [m]

    Returns
    -------
    I_z : float
        Yaw inertia. [kg m²]

    Raises
    ------
    InputError
        If the wires are too short to span the two spacings.
    """
    below = d if d_below is None else d_below
    return m * G * d * below * T**2 / (16 * math.pi**2 * _height(d, below, h))


def finite_swing_inertia(
    m: float,
    T: float,
    d: float,
    h: float,
    amplitude: float,
    d_below: float | None = None,
) -> float:
    """Yaw inertia whose exact period at this amplitude is T: `swing_period` inverted.

    Parameters
    ----------
    m, T, d, h, d_below : float
        As in `small_swing_inertia`.
    amplitude : float
        Largest angle of the swing. [rad]

    Returns
    -------
    I_z : float
        Yaw inertia. [kg m²]

    Raises
    ------
    InputError
        If the wires cannot reach that angle.
    """
    I_z = small_swing_inertia(m, T, d, h, d_below)
    per_square = I_z / T**2  # nearly dI/d(T²), as T² is all but linear in I
    for _ in range(100):
        change = per_square * (
            T**2 - swing_period(I_z, m, d, h, amplitude, d_below) ** 2
        )
        I_z = max(I_z + change, I_z / 2)
        if abs(change) < 1e-13 * I_z:
            break
    return I_z


def swing_period(
    I_z: float,
    m: float,
    d: float,
    h: float,
    amplitude: float,
    d_below: float | None = None,
) -> float:
    r"""Exact period of a bifilar pendulum of any amplitude.

    The body rises as it turns: :math:`z(\theta)^2 = z_0^2 - ab\,(2 - 2\cos\theta)` with
    a, b half the spacings above and below and z₀ the height at rest. Energy gives

    .. math::
        T = 4 \int_0^{\theta_0}
            \sqrt{\frac{I_z + m (ab \sin\theta / z)^2}{2 m g (z - z(\theta_0))}} d\theta

    which falls to the small-swing formula as θ₀ → 0. [1]_

    Parameters
    ----------
    I_z, m : float
        Yaw inertia and mass on the wires. [kg m²], [kg]
    d, h : float
        Distance between the wires above, and their length. [m]
    amplitude : float
        Largest angle θ₀. [rad]
    d_below : float, optional
        Distance between the wires below, where it differs. [m]

    Returns
    -------
    T : float
        Full period. [s]

    Raises
    ------
    InputError
        If an argument is not positive or the wires cannot reach that angle.

    References
    ----------
    .. [1] T. R. Kane and G.-T. Tseng, "Dynamics of the bifilar pendulum," International
       Journal of Mechanical Sciences, vol. 9, pp. 83-96, 1967.
    """
    below = d if d_below is None else d_below
    require_positive(I_z=I_z, m=m, d=d, h=h, amplitude=amplitude, d_below=below)
    ab = d * below / 4
    z0_squared = _height(d, below, h) ** 2
    end_squared = z0_squared - 4 * ab * math.sin(amplitude / 2) ** 2
    if end_squared <= 0:
        raise InputError(
            f"amplitude: wires {h:g} m long cannot turn by {amplitude:g} rad"
        )
    end = math.sqrt(end_squared)
    total = 0.0
    for k in range(QUADRATURE):
        phi = (k + 0.5) * math.pi / (2 * QUADRATURE)  # theta = amplitude · sin(phi)
        theta = amplitude * math.sin(phi)
        short = 2 * amplitude * math.sin((math.pi / 2 - phi) / 2) ** 2
        z = math.sqrt(z0_squared - 4 * ab * math.sin(theta / 2) ** 2)
        fall = (
            4 * ab * math.sin((amplitude + theta) / 2) * math.sin(short / 2) / (z + end)
        )
        moving = I_z + m * (ab * math.sin(theta) / z) ** 2
        total += math.sqrt(moving / (2 * m * G * fall)) * amplitude * math.cos(phi)
    return 4 * total * math.pi / (2 * QUADRATURE)


def _height(d: float, below: float, h: float) -> float:
    """Height between the attachments at rest. [m]"""
    squared = h**2 - ((d - below) / 2) ** 2
    if squared <= 0:
        raise InputError(f"h: wires {h:g} m long do not span from {d:g} to {below:g} m")
    return math.sqrt(squared)
