"""Where a figure is sought: between which bounds, and what strengths are tried."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf, isfinite, log1p, sqrt

import numpy as np

from rcc_sim.diagnose.residuals.lateness import clear_delay
from rcc_sim.diagnose.residuals.problem import Problem
from rcc_sim.diagnose.residuals.sizes import (
    LIMITED,
    lost_at_stops,
    reached,
    size_of,
    small_changes,
    stiffest,
)
from rcc_sim.diagnose.residuals.terminals import BEYOND_SHAFT
from rcc_sim.physics.effect import Effect, Param
from rcc_sim.units import unit_of

LIKELY = 5.0
"""Strength that is tried first, in small changes of its unit."""

USUAL = 50.0
"""Largest strength that is usual, in small changes of its unit."""

WITHIN_ROW = 0.5
"""Rows by which it is not known when a command acts: what is late, or slow, by less is
no more than that."""

WEATHER = "m/s"
"""Unit of a figure that does not grow with the vehicle: a wind is as it is."""

SLIGHT = 0.05
"""Share of its typical departure from 1 that a scale must have to be told: a wheel's
radius is no better defined than by what its tyre slips."""

SAME = 0.02
"""Share of itself by which a first strength has to differ from what is stated."""

BEYOND = 2.5
"""Times its typical departure from neutral that a scale may have."""

FREEDOM, T_90 = 4.0, 2.132
"""Degrees of freedom of what strengths are likely, and the t within which nine in ten
are."""

LIMITS = 6
"""Strengths that are tried of a limit."""

BLURRED = 0.5
"""Times the smear of a noisy speed over which the acceleration of an imposed drive is
not known: delays of 0.2 to 0.45 times that were named where there was none."""

WITHIN = 5.0
"""Factor within which a stated figure of the car itself lies: what asks for more is not
that figure."""

MEASURED = frozenset(
    ("N", "N s/m", "N s²/m²", "N m", "N m s/rad", "kg m²", "m²", "Ω", "1")
)
"""Units of such figures; a load, in W or kg, may be any times what was stated."""


@dataclass(frozen=True)
class Search:
    """One figure of a candidate.

    Parameters
    ----------
    key : str
        Dotted key of the vehicle file.
    neutral : float
        What the file states, else the value at which the effect vanishes.
    low, high : float
        Bounds.
    first : float
        Strength that is tried first.
    grid : tuple of float
        Strengths that are all tried: for thresholds, limits and clocks.
    acts : str
        How the model changes as it moves.
    same_as : str
        Figure of the file that it adds to, or multiplies.
    opposes : tuple of str
        Dotted keys of figures that undo it.
    least : float
        Distance from neutral below which a model is no better than its effect.
    most : float
        Largest distance from neutral that is usual.
    likely : float
        The likeliest one: of what runs over decades the middle of them, else ``most``.
    measured : bool
        Whether the strength of the grid is a delay that the log itself shows.
    sd : float
        Standard deviation that the file states of it, where it is the car's own.
    """

    key: str
    neutral: float
    low: float
    high: float
    first: float
    grid: tuple[float, ...] = ()
    acts: str = ""
    same_as: str = ""
    opposes: tuple[str, ...] = ()
    least: float = 0.0
    most: float = inf
    likely: float = inf
    measured: bool = False
    sd: float = inf

    @property
    def clocked(self) -> bool:
        """Whether it is a period, whose signal has no slope: found by trying alone."""
        return self.acts == "clock"

    @property
    def stepped(self) -> bool:
        """Whether it acts where a command passes it, and between two not at all."""
        return self.acts == "steps"

    @property
    def weakest(self) -> float | None:
        """Strength of which no weaker one may be told, a bound of it; None: any may."""
        if self.acts == "slip" and isfinite(self.high):
            return self.high
        return self.low if self.low > self.neutral else None

    @property
    def opens(self) -> bool:
        """Whether its bounds leave anything to look for."""
        return self.low < self.high

    def price(self, x: float) -> float:
        """Nats that a strength costs: nine of ten are no larger than is usual.

        Student's t on the distance from neutral, because what is usual is known
        roughly, and so is the sd of what the file states; a limit, which has no such
        distance, is free.
        """
        if not isfinite(self.neutral):
            return 0.0
        t = (x - self.neutral) / min(self.most / T_90, self.sd)
        return 0.5 * (FREEDOM + 1) * log1p(t**2 / FREEDOM)


def search_of(problem: Problem, effect: Effect, param: Param) -> Search:
    """Return where to look for a figure."""
    key = f"effects.{effect.id}.{param.name}"
    stated = problem.vehicle.figures().get(key)
    neutral = stated.value if stated else param.neutral
    low, high = bounds_in(problem, param)
    late = clearly_late(problem, param)
    measured = late > max(low, 0.0)
    grid = (late,) if measured else strengths_in(problem, param, low, high)
    a, b = param.typical
    sd = inf
    if stated and neutral and not grid and unit_of(param.name) in MEASURED:
        ends = sorted((neutral / WITHIN, neutral * WITHIN))
        low, high = max(low, ends[0]), min(high, ends[1])
        sd = stated.tolerance or inf
    if is_factor(param):
        low = max(low, 1 - BEYOND * (1 - a))
        high = min(high, 1 + BEYOND * max(b - 1, 0.0))
    small = small_changes(problem).get(unit_of(param.name))
    first = first_of(param, stated.value if stated else None, small)
    if abs(first - neutral) < SAME * abs(first):  # else the search ends as it begins
        first = 0.5 * (neutral + (a if neutral - a > b - neutral else b))
    most = max(abs(a - param.neutral), abs(b - param.neutral))
    if small is not None and unit_of(param.name) != WEATHER:
        most = USUAL * small
    decades = param.neutral == 0.0 < a and not (stated and neutral)
    return Search(
        key,
        neutral,
        low,
        high,
        first,
        grid,
        acts=param.acts,
        same_as=param.sought.same_as,
        opposes=tuple(f"effects.{effect.id}.{x}" for x in param.sought.opposes),
        least=least_of(problem, param),
        most=most,
        likely=first if decades else most,
        measured=measured,
        sd=sd,
    )


def is_factor(param: Param) -> bool:
    """Tell whether a figure multiplies what it acts on."""
    return param.neutral == 1.0 and param.typical[0] >= 0.0


def bounds_in(problem: Problem, param: Param) -> tuple[float, float]:
    """Return between which a figure is sought in a log, whatever is stated of it."""
    low, high = param.bounds if param.acts == "slip" else param.search
    if param.sought.of in LIMITED:
        low = max(low, reached(problem, param.sought.of))
    if param.sought.limits:
        per, (least, most) = size_of(problem, param.sought.of), param.sought.limits
        low, high = max(low, per * least), min(high, per * most)
        if param.acts == "rows":
            low = max(low, BLURRED * problem.drive.smear)
    if not problem.drive.imposed:
        return low, high
    if param.acts == "steps" and unit_of(param.name) == "m/s":
        low = max(low, lost_at_stops(problem))  # a row passes all that is less at once
    if param.acts == "slip":
        high = stiffest(problem)
        low = min(low, high)
    return low, high


def strengths_in(
    problem: Problem, param: Param, low: float, high: float
) -> tuple[float, ...]:
    """Return the strengths that are all tried within bounds; none: it has a slope."""
    grid = grid_of(problem, param)
    late = param.acts == "rows" and param.sought.limits
    if late or (grid and param.sought.of in LIMITED):
        return tuple(x for x in grid if x >= low) or (low,)
    if param.acts == "slip" and problem.drive.imposed:
        return tuple(x for x in grid if x < high) or (high,)
    return grid


def first_of(param: Param, stated: float | None, small: float | None) -> float:
    """Return the strength that is tried first: a likely one.

    Of one that is ``stated`` a tenth more; ``small`` is what is a small change of such
    a figure in a log.
    """
    a, b = param.typical
    if param.neutral == inf:
        return b
    if a < 0:
        return param.neutral + 0.3 * b
    if is_factor(param):
        return 0.5 * (1 + (a if a < 1 else b))
    if stated:
        return 1.1 * stated
    return sqrt(max(a, 1e-9) * b) if small is None else LIKELY * small


def least_of(problem: Problem, param: Param) -> float:
    """Return the distance from neutral below which its model is not as good."""
    if unit_of(param.name) == "s" and param.acts == "":
        return WITHIN_ROW * problem.row
    a, b = param.typical
    return SLIGHT * max(1 - a, b - 1) if is_factor(param) else 0.0


def clearly_late(problem: Problem, param: Param) -> float:
    """Return the delay [s] that courses show of a reading; none above 0 if not."""
    if param.acts != "rows":
        return 0.0
    if of_battery(param):
        return problem.late
    return -clear_delay(problem) if param.sought.of == "speed" else 0.0


def of_battery(param: Param) -> bool:
    """Tell whether a figure is of the battery's readings alone."""
    sought = param.sought
    return {*sought.columns} <= {*BEYOND_SHAFT} and bool(sought.columns)


def grid_of(problem: Problem, param: Param) -> tuple[float, ...]:
    """Strengths to try for a figure that has no slope at neutral; else none.

    One at least, where all would be too long. Of a limit that says nothing of them, its
    typical range's.
    """
    sought = param.sought
    if param.neutral == inf and not sought.tried:
        least, most = param.typical
        return tuple(np.geomspace(max(least, 0.01 * most), most, LIMITS).tolist())
    per = size_of(problem, sought.of)
    if not (sought.tried and per > 0):
        return ()
    grid = tuple(per * x for x in sought.tried)
    return tuple(x for x in grid if x <= sought.longest) or grid[:1]
