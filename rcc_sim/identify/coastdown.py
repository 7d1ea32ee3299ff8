"""Road-load coefficients from the log of one or several coast-downs."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from rcc_sim.channel import sensor_noise
from rcc_sim.errors import InputError, require_positive
from rcc_sim.identify.coast_model import Coast, Solution, solve
from rcc_sim.identify.coasting import find_coasts
from rcc_sim.identify.series import Array, finite_rows
from rcc_sim.identify.uncertainty import require_sd, student_quantile
from rcc_sim.units import RHO_AIR, G

COVERAGE = 0.90
"""Probability of every interval. [1]"""

EXACT = 1e-6
"""Force that rounding alone may leave, as a share of that at the highest speed. [1]"""

TERMS = ("A", "B", "C")
"""Names of the terms of F = A + B v + C v²."""

LADDER = (
    ("A", "B", "C"),
    ("A", "C"),
    ("A", "B"),
    ("B", "C"),
    ("B",),
    ("C",),
    ("A",),
)
"""Sets of terms that are tried, from the fullest; the last where none is told apart."""

MISSED = 10.0
"""Times the noise of the speed by which a fit may miss it without a word. [1]"""


@dataclass(frozen=True)
class Coefficient:
    """A fitted figure with its interval.

    Attributes
    ----------
    value, sd : float
        Estimate and standard deviation; 0 if the term was left out.
    low, high : float
        90 % interval; that of the fit with all terms if the term was left out.
    fitted : bool
        Whether the term is in the reported fit.
    """

    value: float
    sd: float
    low: float
    high: float
    fitted: bool


@dataclass(frozen=True)
class RoadLoad:
    """Road load F = A + B v + C v² from coast-downs.

    Attributes
    ----------
    A, B, C : Coefficient
        In [N], [N s/m], [N s²/m²].
    C_rr : Coefficient or None
        A/(m g), None unless A is positive. [1]
    C_dA : Coefficient or None
        2 C/ρ, None unless C is in the fit and positive. [m²]
    slope : Coefficient or None
        Slope of the road in the + direction, where both directions were driven. [1]
    terms : tuple of str
        Terms in the reported fit.
    correlation : tuple of tuple of float
        Correlation of the fitted terms. [1]
    r_squared, residual_sd : float
        Variance explained, and what is left of the speed. [1], [m/s]
    independent_rows : float
        Rows, divided by the residuals' correlation time. [1]
    speed_low, speed_high : float
        Range of speed that the fit has seen. [m/s]
    stretches : tuple of tuple of float
        Start and end of each coast. [s]
    converged : bool
        The solver converged and the force is positive over that range of speed.
    message, warnings : str, tuple of str
        The solver's word; what a reader should know before using the figures.
    """

    A: Coefficient
    B: Coefficient
    C: Coefficient
    C_rr: Coefficient | None
    C_dA: Coefficient | None
    slope: Coefficient | None
    terms: tuple[str, ...]
    correlation: tuple[tuple[float, ...], ...]
    r_squared: float
    residual_sd: float
    independent_rows: float
    speed_low: float
    speed_high: float
    stretches: tuple[tuple[float, float], ...]
    converged: bool
    message: str
    warnings: tuple[str, ...]


def fit_coastdown(
    time_s: ArrayLike,
    speed_mps: ArrayLike,
    mass_kg: float,
    *,
    equivalent_inertia_kg: float = 0.0,
    mass_sd_kg: float = 0.0,
    drive: ArrayLike | None = None,
    drive_threshold: float | None = None,
    slope: ArrayLike | float | None = None,
    elevation_m: ArrayLike | None = None,
    direction: Sequence[int] | None = None,
    min_speed_mps: float | None = None,
    terms: Sequence[str] | None = None,
    rho: float = RHO_AIR,
) -> RoadLoad:
    r"""Road load from coast-downs, by fitting speed over time.

    .. math:: (m + m_e)\,\dot v = -(A + B v + C v^2) - m g \sin(\arctan s)

    is integrated from a fitted starting speed of each coast, and its parameters found
    by least squares on the measured speed; nothing is differentiated. [1]_ Intervals
    are widened by the correlation of the residuals and by the scatter between coasts.
    Unless `terms` is given, terms that the data cannot tell from 0, or that come out
    negative, are left out and a warning says which; the rest then holds if they are 0.

    Parameters
    ----------
    time_s, speed_mps : array_like, shape (n,)
        Time and speed; NaN where missing. [s], [m/s]
    mass_kg : float
        Mass m. [kg]
    equivalent_inertia_kg : float, optional
        What turns, as a mass m_e: J (N_d/r_w)² + wheels. [kg]
    mass_sd_kg : float, optional
        Standard deviation of m + m_e. [kg]
    drive : array_like, shape (n,), optional
        Torque, current or throttle; coasting is where it is near 0. Without it the
        longest decelerations count, and a brake could not be told from drag.
    drive_threshold : float, optional
        Size of `drive` up to which it is near 0; 2 % of its largest, or four standard
        deviations of its noise, unless given.
    slope : array_like or float, optional
        Slope of the road in the direction of travel, positive uphill. [1]
    elevation_m : array_like, shape (n,), optional
        Height of the road, instead of `slope`. [m]
    direction : sequence of int, optional
        +1 or −1 for each coast (or each row): with both, a common slope is fitted too.
    min_speed_mps : float, optional
        Speed at which a coast ends; 5 % of the top speed unless given. [m/s]
    terms : sequence of str, optional
        Terms to fit, of "A", "B", "C", whatever they come out as.
    rho : float, optional
        Density of air. [kg/m³]

    Returns
    -------
    RoadLoad
        Coefficients with 90 % intervals, and what was found.

    Raises
    ------
    InputError
        If there is no coast, or inputs contradict each other; says what was found.

    References
    ----------
    .. [1] SAE J2263, "Road load measurement using onboard anemometry and coastdown
       techniques," 2008; ISO 10521-1:2006, 5.3 (coast-down in both directions).
    """
    require_positive(mass_kg=mass_kg, rho=rho)
    require_sd(equivalent_inertia_kg=equivalent_inertia_kg, mass_sd_kg=mass_sd_kg)
    chosen = _check_terms(terms)
    t, rows = _rows(
        time_s, speed_mps, drive=drive, slope=slope, elevation_m=elevation_m
    )
    parts, warnings = find_coasts(
        t, rows["speed_mps"], rows.get("drive"), drive_threshold, min_speed_mps
    )
    ways = _ways(direction, np.asarray(time_s, dtype=float), t, parts)
    coasts = [
        Coast.of(t[part], {name: c[part] for name, c in rows.items()}, way)
        for part, way in zip(parts, ways, strict=True)
    ]
    both = len(set(ways)) == 2
    if not both and slope is None and elevation_m is None:
        warnings += ("one direction only: a slope of the road would be inside A",)
    inertia = (mass_kg + equivalent_inertia_kg, mass_kg * G)
    full = solve(coasts, LADDER[0], inertia, both)
    if chosen is None:
        best, why = _choose(coasts, full, inertia, both)
        warnings += why
    else:
        best = full if chosen == LADDER[0] else solve(coasts, chosen, inertia, both)
    relative = mass_sd_kg / inertia[0]
    fitted = {name: _coefficient(name, best, full, relative) for name in TERMS}
    low, high = (f([f(c.v) for c in coasts]) for f in (np.min, np.max))
    force = [
        sum(fitted[n].value * v**k for k, n in enumerate(TERMS)) for v in (low, high)
    ]
    if min(force) <= 0:
        warnings += (f"the force is not positive from {low:.3g} to {high:.3g} m/s",)
    noise = sensor_noise(rows["speed_mps"])
    if best.residual_sd > MISSED * noise > 0:
        warnings += (
            f"the fit misses the speed by {best.residual_sd:.2g} m/s, whose noise is "
            f"{noise:.1g}: coasts that disagree (a slope: give --direction 1 or -1 for "
            "each, or the elevation), or a brake",
        )
    if fitted["B"].fitted and fitted["B"].value != 0:
        warnings += ("C_rr and C_dA leave out the term B v",)
    return RoadLoad(
        **fitted,
        C_rr=_scaled(fitted["A"], 1 / inertia[1]),
        C_dA=_scaled(fitted["C"], 2 / rho),
        slope=_coefficient("slope", best, full, 0.0) if both else None,
        terms=best.terms,
        correlation=best.correlation(),
        r_squared=best.r_squared,
        residual_sd=best.residual_sd,
        independent_rows=best.independent_rows,
        speed_low=float(low),
        speed_high=float(high),
        stretches=tuple((float(t[p][0]), float(t[p][-1])) for p in parts),
        converged=bool(best.converged and min(force) > 0),
        message=best.message,
        warnings=warnings,
    )


def _choose(
    coasts: list[Coast],
    full: Solution,
    inertia: tuple[float, float],
    both: bool,
) -> tuple[Solution, tuple[str, ...]]:
    """Fullest set of terms that the data can tell from 0, and why not a fuller one."""
    fastest = max(float(np.max(c.v)) for c in coasts)
    if _told_apart(full, fastest):
        return full, ()
    others = [solve(coasts, terms, inertia, both) for terms in LADDER[1:]]
    good = [s for s in others if _told_apart(s, fastest)]
    best = min(good, key=lambda s: s.criterion) if good else others[-1]
    why = []
    for name in full.terms:
        if name in best.terms:
            continue
        value, sd = full.value(name), full.sd(name)
        if value < -student_quantile(COVERAGE, full.dof) * sd:
            cause = f"it comes out negative, {value:.3g} ± {sd:.2g}"
        else:
            cause = f"not told from 0 in this range of speed: {value:.3g} ± {sd:.2g}"
        why.append(f"{name} was left out ({cause}); the others hold if it is 0")
    return best, tuple(why)


def _told_apart(solution: Solution, fastest: float) -> bool:
    """Every term is positive by more than its interval's half-width, and than rounding.

    The force of each counts at the highest speed [m/s].
    """
    factor = student_quantile(COVERAGE, solution.dof)
    force = {n: solution.value(n) * fastest ** TERMS.index(n) for n in solution.terms}
    least = EXACT * sum(force.values())
    return all(
        solution.value(n) > factor * solution.sd(n) and force[n] > least
        for n in solution.terms
    )


def _coefficient(
    name: str, best: Solution, full: Solution, relative: float
) -> Coefficient:
    """Estimate and interval of a term, widened by the relative sd of the inertia."""
    fitted = name in best.names
    value = best.value(name) if fitted else 0.0
    source = best if fitted else full
    centre = source.value(name)
    sd = math.hypot(source.sd(name), relative * centre)
    half = student_quantile(COVERAGE, source.dof) * sd
    return Coefficient(
        value, sd if fitted else 0.0, centre - half, centre + half, fitted
    )


def _scaled(term: Coefficient, factor: float) -> Coefficient | None:
    """Return the coefficient times a factor, or None unless fitted and positive."""
    if not (term.fitted and term.value > 0):
        return None
    return Coefficient(
        value=factor * term.value,
        sd=factor * term.sd,
        low=factor * term.low,
        high=factor * term.high,
        fitted=True,
    )


def _check_terms(terms: Sequence[str] | None) -> tuple[str, ...] | None:
    """Return the wanted terms in order, or None where the data are to choose."""
    if terms is None:
        return None
    unknown = [name for name in terms if name not in TERMS]
    if unknown or not terms:
        raise InputError(f"terms: should be of A, B, C: {', '.join(terms) or 'none'}")
    return tuple(name for name in TERMS if name in terms)


def _rows(
    time_s: ArrayLike,
    speed_mps: ArrayLike,
    *,
    drive: ArrayLike | None,
    slope: ArrayLike | float | None,
    elevation_m: ArrayLike | None,
) -> tuple[Array, dict[str, Array]]:
    """Time, and the channels that were given, in rows where all are finite."""
    if slope is not None and elevation_m is not None:
        raise InputError("slope, elevation_m: only one of the two: both given")
    channels: dict[str, ArrayLike] = {"speed_mps": speed_mps}
    if drive is not None:
        channels["drive"] = drive
    if elevation_m is not None:
        channels["elevation_m"] = elevation_m
    if slope is not None:
        given = np.asarray(slope, dtype=float)
        one = given.ndim == 0
        channels["slope"] = np.full(np.shape(speed_mps), given) if one else given
    t, columns = finite_rows(time_s, **channels)
    return t, dict(zip(channels, columns, strict=True))


def _ways(
    direction: Sequence[int] | None, time_s: Array, t: Array, parts: list[slice]
) -> list[int]:
    """Direction of each coast, +1 or −1, from one entry per coast or per row."""
    if direction is None:
        return [1] * len(parts)
    if len(direction) == len(parts):
        ways = [float(way) for way in direction]
    elif len(direction) == time_s.size:
        way = np.asarray(direction, dtype=float)[np.searchsorted(time_s, t)]
        ways = [float(np.median(way[part])) for part in parts]
    else:
        raise InputError(
            f"direction: should have one entry per coast ({len(parts)} found) or per"
            f" row: {len(direction)}"
        )
    if any(way not in (-1, 1) for way in ways):
        raise InputError(f"direction: should be +1 or -1 throughout: {ways}")
    return [int(way) for way in ways]
