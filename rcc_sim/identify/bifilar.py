"""Yaw inertia from a bifilar pendulum: from periods, or from the log of a gyro."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from rcc_sim.errors import InputError, require_metres, require_positive
from rcc_sim.identify.pendulum import (
    finite_swing_inertia,
    small_swing_inertia,
    swing_period,
)
from rcc_sim.identify.uncertainty import mean_of_repeats, propagate, require_sd

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from rcc_sim.identify.oscillation import Lengthening, OscillationPeriod

LONGEST_PERIOD = 20.0
"""Longest period of one swing that is believable. [s]"""

WIDEST = 1.0
"""Amplitude up to which a log's swings are followed. [rad]"""

LARGE_SWING = math.radians(20)
"""Amplitude from which a swing is worth a warning. [rad]"""

UNEQUAL = 0.01
"""Relative difference of the two wires (or spacings) worth a warning. [1]"""


@dataclass(frozen=True)
class YawInertia:
    """Yaw inertia about the centre of mass, and what its uncertainty is made of.

    Attributes
    ----------
    I_z, sd : float
        Yaw inertia of the car and its standard deviation. [kg m²]
    I_total, I_tare : float
        Inertia of all that hung on the wires, and of the carrier alone. [kg m²]
    T, T_sd : float
        Mean period and its standard deviation. [s]
    repeats : int
        Number of periods. [1]
    budget : Mapping of str to float
        Share of the variance by input: "m", "T", "d", "h", "tare_mass", ... [1]
    warnings : tuple of str
        What a reader should know before using the figure.
    """

    I_z: float
    sd: float
    I_total: float
    I_tare: float
    T: float
    T_sd: float
    repeats: int
    budget: Mapping[str, float]
    warnings: tuple[str, ...]


def yaw_inertia(
    m: float,
    T: float | Sequence[float],
    d: float | Sequence[float],
    h: float | Sequence[float],
    *,
    m_sd: float = 0.0,
    T_sd: float | Sequence[float] = 0.0,
    d_sd: float = 0.0,
    h_sd: float = 0.0,
    cycles: int = 1,
    amplitude: float | None = None,
    tare_mass: float | None = None,
    tare_period: float | None = None,
    tare_mass_sd: float = 0.0,
    tare_period_sd: float = 0.0,
) -> YawInertia:
    r"""Yaw inertia from the period of a bifilar pendulum.

    .. math:: I_z = m g d^2 T^2 / (16 \pi^2 h)

    Holds for small swings on two equal wires, one each side of the centre of mass and
    equally far from it. [1]_ With two spacings, d² is their product and h the height
    between the attachments. With an amplitude, the period of the exact equation is
    used instead, see `pendulum.swing_period`. With a carrier, its inertia is taken off:
    I_z = I_total − I_tare, both about the same axis.

    Parameters
    ----------
    m : float
        Mass on the wires, any carrier included. [kg]
    T : float or sequence of float
        Full period of each repeat (or time of `cycles` full swings). [s]
    d : float or sequence of two
        Distance between the wires; or above and below, where they differ. [m]
    h : float or sequence of two
        Length of the wires; or of each, where they differ (their mean is used). [m]
    m_sd, d_sd, h_sd : float, optional
        Standard deviations. [kg], [m], [m]
    T_sd : float or sequence of float, optional
        Standard deviation of each entry of `T`, independent between repeats. [s]
    cycles : int, optional
        Full swings that each entry of `T` spans. [1]
    amplitude : float, optional
        Mean amplitude of the swing, to correct for its being finite. [rad]
    tare_mass, tare_period : float, optional
        Mass and period of the carrier alone on the same wires. [kg], [s]
    tare_mass_sd, tare_period_sd : float, optional
        Their standard deviations. [kg], [s]

    Returns
    -------
    YawInertia
        Inertia, sd, budget and warnings.

    Raises
    ------
    InputError
        If an argument is not finite and positive, or the carrier is not lighter and
        easier to turn than what hung on the wires with it.

    References
    ----------
    .. [1] M. R. Jardin and E. R. Mueller, "Optimized measurements of UAV mass moment
       of inertia with a bifilar pendulum," AIAA paper 2007-6822, 2007.
    """
    periods = [p / cycles for p in _several("T", T)]
    period_sds = _like(periods, T_sd, cycles)
    spacings, lengths = _one_or_two("d", d), _one_or_two("h", h)
    require_positive(
        mass=m, period=periods, spacing=spacings, length=lengths, cycles=cycles
    )
    require_metres(spacing=spacings, length=lengths)
    if max(periods) > LONGEST_PERIOD:
        raise InputError(
            f"period: should be below {LONGEST_PERIOD:g} s: {max(periods):g}",
            "the time of several swings? --cycles says of how many",
        )
    if amplitude is not None and not 0 < amplitude < math.pi / 2:
        raise InputError(
            f"amplitude: should be between 0 and π/2 rad: {amplitude:g}",
            "the amplitude is in radians: 10° is 0.175",
        )
    repeats = mean_of_repeats(periods, period_sds)
    ratio = spacings[-1] / spacings[0]

    def total(m: float, T: float, d: float, h: float) -> float:
        if amplitude is None:
            return small_swing_inertia(m, T, d, h, ratio * d)
        return finite_swing_inertia(m, T, d, h, amplitude, ratio * d)

    values = {
        "m": m,
        "T": repeats.value,
        "d": spacings[0],
        "h": sum(lengths) / len(lengths),
    }
    sds = {"m": m_sd, "T": repeats.sd, "d": d_sd, "h": h_sd}
    require_sd(**{f"{name}_sd": sd for name, sd in sds.items()})
    I_total = total(**values)
    tare = _tare(m, tare_mass, tare_period)
    if tare is not None:
        values |= tare
        sds |= {"tare_mass": tare_mass_sd, "tare_period": tare_period_sd}

    def car(tare_mass: float = 0.0, tare_period: float = 0.0, **on: float) -> float:
        if tare is None:
            return total(**on)
        d, h = on["d"], on["h"]
        return total(**on) - small_swing_inertia(
            tare_mass, tare_period, d, h, ratio * d
        )

    result = propagate(car, values, sds)
    if result.value <= 0:
        raise InputError(
            f"tare_period: the carrier alone should be easier to turn than carrier and"
            f" car together: {I_total - result.value:g} against {I_total:g} kg m²",
            "give the mass of car and carrier together as the mass on the wires",
        )
    return YawInertia(
        I_z=result.value,
        sd=result.sd,
        I_total=I_total,
        I_tare=I_total - result.value,
        T=repeats.value,
        T_sd=repeats.sd,
        repeats=len(periods),
        budget=result.budget,
        warnings=_warnings(
            spacings, lengths, amplitude, repeats.excess, repeats.scatter
        )
        + (("no uncertainty was stated: sd is 0",) if result.sd == 0 else ()),
    )


def lengthening(
    m: float,
    T: float,
    d: float | Sequence[float],
    h: float | Sequence[float],
) -> Lengthening:
    """Return how much longer a swing takes than a small one, by its amplitude.

    Parameters
    ----------
    m, T : float
        Mass on the wires, and period, about. [kg], [s]
    d, h : float or sequence of two
        As in `yaw_inertia`. [m]

    Returns
    -------
    longer : callable
        Of amplitudes [rad]; exact (`pendulum.swing_period`) up to ``WIDEST``, or to
        nearly what the wires reach.
    """
    import numpy as np

    spacings, lengths = _one_or_two("d", d), _one_or_two("h", h)
    wires = spacings[0], sum(lengths) / len(lengths)
    I_z = small_swing_inertia(m, T, *wires, spacings[-1])
    reach = 2 * math.asin(min(wires[1] / math.sqrt(wires[0] * spacings[-1]), 1.0))
    some = np.linspace(0.0, min(WIDEST, 0.9 * reach), 31)[1:]
    periods = [swing_period(I_z, m, *wires, x, spacings[-1]) for x in some.tolist()]
    ratios = np.array([1.0, *periods]) / np.array([1.0, *[T] * len(periods)])
    squares = np.array([0.0, *some**2])
    return lambda amplitude: np.interp(amplitude**2, squares, ratios)


def oscillation_period(
    time_s: ArrayLike, yaw_rate: ArrayLike, longer: Lengthening | None = None
) -> OscillationPeriod:
    r"""Period of the free swings in the log of a gyro.

    Each swing is found by its regular zero crossings and fitted by least squares with

    .. math:: r(t) = A e^{-\sigma t} \sin(2 \pi t / T_d + \varphi) + c

    Rows before the release and after the stop are left out; rows may jitter or miss.
    The natural period is :math:`T = T_d \sqrt{1 - \zeta^2}` with
    :math:`\zeta = \sigma / \sqrt{\sigma^2 + (2\pi/T_d)^2}`. [1]_ The sd comes from the
    fit's covariance, enlarged by the correlation of the residuals.

    Parameters
    ----------
    time_s : array_like, shape (n,)
        Time, strictly increasing. [s]
    yaw_rate : array_like, shape (n,)
        Yaw rate in any one unit; NaN where missing. [rad/s]
    longer : callable, optional
        How much longer a swing of an amplitude [rad] takes than a small one
        (`lengthening`): the periods are then those of small swings. The rate must be
        in rad/s for it.

    Returns
    -------
    OscillationPeriod
        Mean period, sd, and each swing.

    Raises
    ------
    InputError
        If there is no regular oscillation; says what was found.

    References
    ----------
    .. [1] D. J. Inman, Engineering Vibration, 4th ed., Pearson, 2014, sect. 1.3.
    """
    from rcc_sim.identify.oscillation import OscillationPeriod, find_swings
    from rcc_sim.identify.series import finite_rows

    t, (rate,) = finite_rows(time_s, yaw_rate=yaw_rate)
    swings, warnings = find_swings(t, rate, longer)
    widest = max(s.angle_start for s in swings)
    if longer is not None and widest > LARGE_SWING:
        warnings += (
            f"a swing starts at {math.degrees(widest):.2g}°: followed exactly to "
            f"{math.degrees(LARGE_SWING):.2g}°, a little less so beyond",
        )
    mean = mean_of_repeats([s.T for s in swings], [s.T_sd for s in swings])
    if mean.excess:
        warnings += (
            f"the swings' periods scatter by {mean.scatter:.2g} s, > their sds",
        )
    return OscillationPeriod(
        T=mean.value,
        T_sd=mean.sd,
        damping_ratio=sum(s.damping_ratio for s in swings) / len(swings),
        n_cycles=sum(s.n_cycles for s in swings),
        r_squared=min(s.r_squared for s in swings),
        swings=tuple(swings),
        warnings=warnings,
    )


def _several(name: str, value: float | Sequence[float]) -> list[float]:
    """Return the value as a list of floats, at least one."""
    numbers = (
        [float(v) for v in value] if hasattr(value, "__iter__") else [float(value)]
    )
    if not numbers:
        raise InputError(f"{name}: at least one value is needed: none given")
    return numbers


def _one_or_two(name: str, value: float | Sequence[float]) -> list[float]:
    """Return a length, or those of both ends or wires; more of them are none."""
    numbers = _several(name, value)
    if len(numbers) > 2:
        raise InputError(
            f"{name}: should be one length, or two where they differ: {len(numbers)}",
            "give the mean of what was measured several times",
        )
    return numbers


def _like(
    periods: list[float], T_sd: float | Sequence[float], cycles: int
) -> list[float]:
    """One standard deviation per period. [s]"""
    sds = [sd / cycles for sd in _several("T_sd", T_sd)]
    for sd in sds:
        require_sd(T_sd=sd)
    if len(sds) == 1:
        sds *= len(periods)
    if len(sds) != len(periods):
        raise InputError(
            f"T_sd: should be one value, or one per period ({len(periods)}): {len(sds)}"
        )
    return sds


def _tare(
    m: float, tare_mass: float | None, tare_period: float | None
) -> dict[str, float] | None:
    """Carrier's inputs, or None without a carrier."""
    if tare_mass is None and tare_period is None:
        return None
    if tare_mass is None or tare_period is None:
        missing = "tare_mass" if tare_mass is None else "tare_period"
        raise InputError(
            f"{missing}: mass and period of the carrier go together: missing"
        )
    require_positive(tare_mass=tare_mass, tare_period=tare_period)
    if tare_mass >= m:
        raise InputError(
            f"tare_mass: should be less than the mass on the wires, {m:g} kg:"
            f" {tare_mass:g}",
            "the mass on the wires is car and carrier together",
        )
    return {"tare_mass": tare_mass, "tare_period": tare_period}


def _warnings(
    spacings: list[float],
    lengths: list[float],
    amplitude: float | None,
    excess: bool,
    scatter: float,
) -> tuple[str, ...]:
    """What a reader should know before using the figure."""
    found = []
    if abs(lengths[0] / lengths[-1] - 1) > UNEQUAL:
        found.append(
            f"the wires differ, {lengths[0]:g} and {lengths[-1]:g} m: the car hangs"
            " tilted, and the formula holds for equal wires"
        )
    if abs(spacings[0] / spacings[-1] - 1) > UNEQUAL:
        found.append(
            f"the wires are not parallel, {spacings[0]:g} m apart above and"
            f" {spacings[-1]:g} m below: both were used"
        )
    if amplitude is not None and amplitude > LARGE_SWING:
        found.append(
            f"amplitude {math.degrees(amplitude):.0f}° is above 20°: corrected, but"
            " damping then changes it over the swing"
        )
    if excess:
        found.append(
            f"the periods scatter by {scatter:.2g} s, far beyond their stated sd: the"
            " scatter was used"
        )
    return tuple(found)
