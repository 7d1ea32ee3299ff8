"""Which effects could be behind a gap, and at what strengths to try them."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass

from rcc_sim.definitions.vehicle import Vehicle
from rcc_sim.diagnose.causes.sought import Search, of_battery, search_of
from rcc_sim.diagnose.residuals.problem import Problem
from rcc_sim.diagnose.residuals.shapes import is_shaped
from rcc_sim.diagnose.residuals.sizes import tells_slip
from rcc_sim.errors import InputError
from rcc_sim.physics.effect import Effect, Param, meant
from rcc_sim.simulate.drive import whole


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
    """Tell whether an effect may be asked for as a whole.

    Most sum up no others. One that does is asked for if the file states it; or if it
    has a single figure, and the file states none of its parts.
    """
    if not effect.sums or effect.id in vehicle.effects:
        return True
    return len(effect.params) == 1 and not set(effect.sums) & set(vehicle.effects)


def shows_in(problem: Problem, drives: Collection[str]) -> bool:
    """Tell whether a drive is all that it must be for a figure to show in it."""
    vehicle, drive = problem.vehicle, problem.drive
    asked: dict[str, Callable[[], bool]] = {  # the last two go through a whole column
        "commanded": lambda: not drive.imposed,
        "imposed": lambda: drive.imposed,
        "speed_loop": lambda: vehicle.mode == "speed",
        "throttle": lambda: vehicle.mode == "throttle",
        "steered": lambda: drive.steered,
        "turning": lambda: not drive.turns_as_measured,
        "unsurveyed": lambda: not problem.surveyed,
        "metered": lambda: bool(whole(problem.log, "aux_power_w").any()),
    }
    return all(asked[what]() for what in drives)


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
