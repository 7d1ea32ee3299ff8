"""Uncertainty of a figure that is computed from a few others, in plain arithmetic.

Nothing here loads numpy, so that a command that only evaluates a formula starts at
once.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from rcc_sim.errors import InputError

ONE_SD = math.erf(math.sqrt(0.5))
"""Share of a normal distribution within one standard deviation. [1]"""

DOF_MAX = 300
"""Degrees of freedom beyond which Student's distribution is taken at this many. [1]"""


@dataclass(frozen=True)
class Propagated:
    """A computed figure, its standard deviation, and where that comes from.

    Attributes
    ----------
    value, sd : float
        The figure and its standard deviation, in its own unit.
    budget : Mapping of str to float
        Share of the variance by input; sums to 1, or is empty where sd is 0. [1]
    """

    value: float
    sd: float
    budget: Mapping[str, float]


TINY = 1e-150
"""Smallest step of a derivative: below it arithmetic loses its digits."""


def propagate(
    function: Callable[..., float],
    values: Mapping[str, float],
    sds: Mapping[str, float],
) -> Propagated:
    r"""First-order propagation of independent uncertainties.

    .. math:: \sigma_f^2 = \sum_i (\partial f / \partial x_i)^2 \sigma_i^2

    The derivatives are central differences. [1]_

    Parameters
    ----------
    function : callable
        Takes the inputs by keyword, returns the figure.
    values : Mapping of str to float
        The inputs, each in its own unit.
    sds : Mapping of str to float
        Their standard deviations, in the same units; absent means exact.

    Returns
    -------
    Propagated
        Value, sd and budget.

    Raises
    ------
    InputError
        If a standard deviation is negative or not finite.

    References
    ----------
    .. [1] JCGM 100:2008, "Guide to the expression of uncertainty in
       measurement," 5.1.2.
    """
    variance: dict[str, float] = {}
    for name, sd in sds.items():
        require_sd(**{f"{name}_sd": sd})
        if sd == 0:
            continue
        step = max(1e-5 * abs(values[name]), 1e-2 * sd, TINY)
        above = function(**{**values, name: values[name] + step})
        below = function(**{**values, name: values[name] - step})
        variance[name] = ((above - below) / (2 * step) * sd) ** 2
    total = math.fsum(variance.values())
    budget = {name: v / total for name, v in variance.items()} if total > 0 else {}
    return Propagated(function(**values), math.sqrt(total), budget)


def require_sd(**sds: float) -> None:
    """Raise unless every standard deviation is finite and not negative.

    Raises
    ------
    InputError
        Naming the first that is not, and the number found.
    """
    for name, sd in sds.items():
        if not (math.isfinite(sd) and sd >= 0):
            raise InputError(f"{name}: should be finite and not negative: {sd:g}")


def student_quantile(probability: float, dof: int) -> float:
    r"""Half-width t of the central interval of Student's distribution.

    Solves :math:`P(|t| < x) = p` for x by bisection of the closed form for a whole
    number of degrees of freedom. [1]_

    Parameters
    ----------
    probability : float
        Probability inside the interval, between 0 and 1. [1]
    dof : int
        Degrees of freedom, at least 1; taken as `DOF_MAX` beyond that. [1]

    Returns
    -------
    t : float
        In units of the estimated standard deviation. [1]

    References
    ----------
    .. [1] M. Abramowitz and I. A. Stegun, Handbook of Mathematical Functions, 26.7.3-4.
    """
    dof = max(1, min(dof, DOF_MAX))
    low, high = 0.0, 1.0
    while _student_inside(high, dof) < probability:
        high *= 2
    for _ in range(60):
        middle = (low + high) / 2
        if _student_inside(middle, dof) < probability:
            low = middle
        else:
            high = middle
    return (low + high) / 2


def _student_inside(t: float, dof: int) -> float:
    """Probability that Student's variable lies within ±t."""
    angle = math.atan(t / math.sqrt(dof))
    sine, cosine2 = math.sin(angle), math.cos(angle) ** 2
    if dof % 2:
        term, total = math.cos(angle), 0.0
        for k in range(3, dof + 1, 2):
            total += term
            term *= cosine2 * (k - 1) / k
        return 2 / math.pi * (angle + sine * total)
    term, total = 1.0, 0.0
    for k in range(2, dof + 1, 2):
        total += term
        term *= cosine2 * (k - 1) / k
    return sine * total


@dataclass(frozen=True)
class Mean:
    """Mean of repeats and its standard deviation.

    Attributes
    ----------
    value, sd : float
        Mean and the standard deviation of the mean, in the repeats' unit.
    scatter : float
        Standard deviation of one repeat about the mean; 0 for a single one.
    excess : bool
        The scatter is far beyond what the stated sds allow (p < 0.001).
    """

    value: float
    sd: float
    scatter: float
    excess: bool


def mean_of_repeats(values: Sequence[float], sds: Sequence[float]) -> Mean:
    r"""Mean of repeats, with an sd that is honest for few of them.

    The sd is the larger of what the stated sds give, :math:`\sqrt{\sum\sigma_i^2}/n`,
    and what the scatter s gives, :math:`k\,s/\sqrt n`, with k Student's factor for one
    standard deviation (1.84 for two repeats, 1.32 for three). [1]_

    Parameters
    ----------
    values : sequence of float
        The repeats.
    sds : sequence of float, of the same length
        Their stated standard deviations; 0 where none is stated.

    Returns
    -------
    Mean
        Mean, sd, scatter, and whether the scatter contradicts the stated sds.

    References
    ----------
    .. [1] JCGM 100:2008, "Guide to the expression of uncertainty in measurement," G.3.
    """
    n = len(values)
    mean = math.fsum(values) / n
    stated = math.sqrt(math.fsum(sd**2 for sd in sds)) / n
    if n == 1:
        return Mean(mean, stated, 0.0, excess=False)
    scatter = math.sqrt(math.fsum((v - mean) ** 2 for v in values) / (n - 1))
    seen = student_quantile(ONE_SD, n - 1) * scatter / math.sqrt(n)
    excess = False
    if all(sd > 0 for sd in sds):
        dof = n - 1
        chi2 = math.fsum(
            ((v - mean) / sd) ** 2 for v, sd in zip(values, sds, strict=True)
        )
        width = math.sqrt(2 / (9 * dof))
        # Wilson and Hilferty's chi-squared quantile at 1 - 0.001
        excess = chi2 / dof > (1 - width**2 + 3.09 * width) ** 3
    return Mean(mean, max(stated, seen), scatter, excess)
