"""Which effects could be behind a gap, and at what strengths to try them."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from math import inf, isfinite, log1p, sqrt

import numpy as np

from rcc_sim.definitions.vehicle import Vehicle
from rcc_sim.diagnose.residuals.problem import Problem
from rcc_sim.diagnose.residuals.shapes import BEYOND_SHAFT, is_shaped
from rcc_sim.diagnose.residuals.sizes import (
    size_of,
    small_changes,
    stiffest,
    tells_slip,
)
from rcc_sim.errors import InputError
from rcc_sim.physics.effect import Effect, Param, meant
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


@dataclass(frozen=True)
class Candidate:
    """An effect that may be missing from the vehicle, or not be what it states.

    Of some several figures may be off at once: each sensor has a delay of its own.
    Some are sums of others: where the file states none of it, the whole is sought.
    """

    effect: str
    searches: tuple[Search, ...]
    several: bool = False
    is_sum: bool = False

    def beside(self, keys: Collection[str]) -> tuple[Search, ...]:
        """Figures that may be off besides some that are: none of these, nor opposed."""
        undone = {o for s in self.searches if s.key in keys for o in s.opposes}
        return tuple(
            s
            for s in self.searches
            if s.key not in keys and s.key not in undone and not {*s.opposes} & {*keys}
        )

    def price(self, values: Mapping[str, float], keys: Collection[str]) -> float:
        """Nats that some of its figures cost."""
        return sum(s.price(values[s.key]) for s in self.searches if s.key in keys)


def candidates_for(
    problems: Sequence[Problem],
    only: Sequence[str] = (),
    withheld: Sequence[str] = (),
) -> list[Candidate]:
    """Return the effects that these logs could show.

    Some are where they were withheld, or asked for, alone; a sum of others that was
    withheld stands for its parts.

    Raises
    ------
    InputError
        If ``only`` names an effect that is not known or cannot act here.
    """
    vehicle = problems[0].vehicle
    known = vehicle.known
    parts = {part for name in withheld for part in known[name].sums}
    found = []
    for name, effect in known.items():
        if name in parts and name not in only:
            continue  # it was in the sum that was taken out
        if only and name not in only:
            continue
        able = [p for p in problems if applies(p, effect)]
        asked = name in withheld or name in only
        if not (asked or all(is_usual(p, effect) for p in able)):
            continue
        searches = searches_in(able, effect)
        if searches:
            is_sum = bool(effect.sums)
            whole = is_sum and name not in vehicle.effects
            found.append(Candidate(name, searches, effect.sensor or is_sum, whole))
    missing = [name for name in only if name not in {c.effect for c in found}]
    if missing:
        if missing[0] in known:
            raise InputError(f"--candidates: {missing[0]}: cannot show in this log")
        what = f"--candidates: {missing[0]}: no such effect"
        raise InputError(what, meant(missing[0], known))
    return found


def searches_in(problems: Sequence[Problem], effect: Effect) -> tuple[Search, ...]:
    """Return where to look for an effect's figures, each in the first log that may."""
    found = []
    for param in effect.params:
        able = (p for p in problems if is_fitted(p, effect, param))
        search = next((search_of(p, effect, param) for p in able), None)
        if search and search.opens:
            found.append(search)
    return tuple(found)


def applies(problem: Problem, effect: Effect) -> bool:
    """Tell whether an effect could act, and show, in a log."""
    vehicle, known = problem.vehicle, problem.vehicle.known
    stated = vehicle.effects
    if any(other in stated for other in effect.excludes):
        return False
    if any(effect.id in known[other].excludes for other in stated):
        return False
    return shows_in(problem, effect.shows_in) and has_needs(vehicle, effect)


def is_usual(problem: Problem, effect: Effect) -> bool:
    """Tell whether an effect is sought where nobody asks for it.

    A slip is not where the motion drives the model and its speed was smoothed: what
    that leaves of the noise looks like less behind softer tyres, whatever is missing.
    """
    if effect.rare or not is_whole(problem.vehicle, effect):
        return False
    slips = any(p.acts == "slip" for p in effect.params)
    return not (slips and problem.drive.imposed and problem.drive.smear > 0)


def is_whole(vehicle: Vehicle, effect: Effect) -> bool:
    """Tell whether an effect is no sum of others, or one that a vehicle may well be.

    One that the file states; or, of a single figure, of whose parts it states none.
    """
    if not effect.sums or effect.id in vehicle.effects:
        return True
    return len(effect.params) == 1 and not set(effect.sums) & set(vehicle.effects)


def shows_in(problem: Problem, drives: Collection[str]) -> bool:
    """Tell whether a drive is all that it must be for a figure to show in it."""
    vehicle, drive = problem.vehicle, problem.drive
    found = {
        "commanded": not drive.imposed,
        "imposed": drive.imposed,
        "speed_loop": vehicle.mode == "speed",
        "throttle": vehicle.mode == "throttle",
        "steered": drive.steered,
        "turning": not drive.turns_as_measured,
        "unsurveyed": not problem.surveyed,
    }
    return all(found[what] for what in drives)


def has_needs(vehicle: Vehicle, effect: Effect) -> bool:
    """Tell whether a vehicle states what an effect is computed from."""
    figures = vehicle.figures()

    def has(key: str) -> bool:
        return vehicle.states(key) and (key not in figures or figures[key].value > 0)

    return all(map(has, effect.needs)) and (
        not effect.needs_any or any(map(has, effect.needs_any))
    )


def is_fitted(problem: Problem, effect: Effect, param: Param) -> bool:
    """Tell whether a figure of an effect is one to be found."""
    sought, given = param.sought, problem.vehicle.effects.get(effect.id, {})
    if effect.either and given:
        return param.name in given
    if not sought.fitted or not shows_in(problem, sought.shows_in):
        return False
    if param.acts == "rows" and of_battery(param) and is_shaped(problem):
        # a delay beside what may shift by rows would smooth what noise foresees: it is
        # one where the course shows it
        return problem.late > 0
    if param.acts == "slip" and param.name in given:
        stated = problem.stated(f"effects.{effect.id}.{param.name}")
        if not tells_slip(problem, stated):
            return False
    return not sought.columns or any(c in problem.channels for c in sought.columns)


def search_of(problem: Problem, effect: Effect, param: Param) -> Search:
    """Return where to look for a figure."""
    key = f"effects.{effect.id}.{param.name}"
    stated = problem.vehicle.figures().get(key)
    neutral = stated.value if stated else param.neutral
    low, high = param.bounds if param.acts == "slip" else param.search
    grid = grid_of(problem, param)
    if param.sought.limits:
        per, (least, most) = size_of(problem, param.sought.of), param.sought.limits
        low, high = max(low, per * least), min(high, per * most)
        if param.acts == "rows":
            low = max(low, BLURRED * problem.drive.smear)
            grid = tuple(x for x in grid if x >= low) or (low,)
    late = clearly_late(problem, param)
    measured = late > low
    grid = (late,) if measured else grid
    if param.acts == "slip" and problem.drive.imposed:
        high = stiffest(problem)
        low = min(low, high)
        grid = tuple(x for x in grid if x < high) or (high,)
    a, b = param.typical
    small = small_changes(problem).get(unit_of(param.name))
    least, sd = 0.0, inf
    if stated and neutral and not grid and unit_of(param.name) in MEASURED:
        ends = sorted((neutral / WITHIN, neutral * WITHIN))
        low, high = max(low, ends[0]), min(high, ends[1])
        sd = stated.tolerance or inf
    if param.neutral == inf:
        first = b
    elif a < 0:
        first = param.neutral + 0.3 * b
    elif param.neutral == 1.0:
        first = 0.5 * (1 + (a if a < 1 else b))
        least = SLIGHT * max(1 - a, b - 1)
        low = max(low, 1 - BEYOND * (1 - a))
        high = min(high, 1 + BEYOND * max(b - 1, 0.0))
    elif stated and neutral:
        first = 1.1 * neutral
    else:
        first = sqrt(max(a, 1e-9) * b) if small is None else LIKELY * small
    if abs(first - neutral) < SAME * abs(first):  # else the search ends as it begins
        first = 0.5 * (neutral + (a if neutral - a > b - neutral else b))
    if unit_of(param.name) == "s" and param.acts == "":
        least = WITHIN_ROW * problem.row
    most = max(abs(a - param.neutral), abs(b - param.neutral))
    if small is not None and unit_of(param.name) != WEATHER:
        most = USUAL * small
    decades = param.neutral == 0.0 < a and not (stated and neutral)
    likely = first if decades else most
    opposes = tuple(f"effects.{effect.id}.{name}" for name in param.sought.opposes)
    how = (param.acts, param.sought.same_as, opposes)
    return Search(
        key, neutral, low, high, first, grid, *how, least, most, likely, measured, sd
    )


def clearly_late(problem: Problem, param: Param) -> float:
    """Return the delay [s] that courses show of a reading; 0 if none is clear."""
    if param.acts == "rows" and of_battery(param):
        return problem.late
    if param.acts == "rows" and param.sought.of == "speed":
        return problem.early
    return 0.0


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
