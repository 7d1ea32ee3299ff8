"""Null, single effects, sets of effects and profiles compete for the logs."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from rcc_sim.diagnose.causes.candidates import Candidate
from rcc_sim.diagnose.causes.cause import (
    ANOTHER_VEHICLE,
    BRISK_ENOUGH,
    ENOUGH,
    PROFILES,
    Cause,
)
from rcc_sim.diagnose.causes.profile import overlap
from rcc_sim.diagnose.causes.sums import with_all_figures
from rcc_sim.diagnose.fitting import descent
from rcc_sim.diagnose.fitting.engine import Engine
from rcc_sim.diagnose.fitting.fit import Fit
from rcc_sim.diagnose.fitting.knobs import BIAS
from rcc_sim.diagnose.fitting.pulls import pulled
from rcc_sim.diagnose.fitting.wake import woken
from rcc_sim.diagnose.profiles.gusts import WIND, may_blow, may_gust, nats_of_gusts
from rcc_sim.diagnose.profiles.remainder import DRAG_OVER_TIME, Remainder, remainder
from rcc_sim.diagnose.profiles.varying import (
    enough_of,
    profile_cause,
    with_profile,
)
from rcc_sim.diagnose.search.couples import coupled
from rcc_sim.diagnose.search.leave_out import one_alone, without_idle, without_outdone
from rcc_sim.diagnose.search.look import looked, shows, told_from
from rcc_sim.diagnose.search.read_late import read_late
from rcc_sim.diagnose.search.refine import Refined
from rcc_sim.diagnose.search.winner import cause_of, near_to

Array = NDArray[np.float64]

PROFILE_MISFIT = 0.1
"""Share of what a profile gained that a further cause must: with knots some distance
apart it leaves a part of itself."""

MISFIT = 0.002
"""Share of what the first cause gained that a further one must: no model of an
effect is better than some parts in a thousand. Five strong causes of the blind plant
left at most 0.0003 of what they gained to any other."""

UNLIKE = {"road_grade": 0.85, "auxiliary_load": 0.97, "headwind": 1.0}
"""Share of the nats of an unknown profile that a named one must gain to stand: a hill
and an unknown drag differ by the accelerometer alone and by their knots; a heater and
a drag differ by the speed, and in the motor's current. A wind is a drag, but for how
it grows with the speed."""

HILL = "road_grade"

TURNS = 6
"""Turns of the competition at most: causes taken in, or profiles refuted."""

SOME = 2
"""Causes from which on no more are sought if something unknown outweighs all, or a
stated figure is another vehicle's."""


@dataclass(frozen=True)
class Explanation:
    """What the competition ended with.

    Parameters
    ----------
    engine : Engine
        The logs, with the profiles found acting on them.
    null, fit : Fit
        Tolerances alone; tolerances and causes.
    causes : tuple of Cause
        Strongest first.
    ranking : dict
        Effect -> nats it gained alone, of all candidates; of two that hide each other,
        beside the other.
    least_seen : dict
        Effect -> parameter -> least strength that the logs would have told beside the
        tolerances; None where they tell none that is usual.
    hidden : frozenset
        Effects of which they would not have told a likely strength of any figure.
    """

    engine: Engine
    null: Fit
    fit: Fit
    causes: tuple[Cause, ...]
    ranking: dict[str, float]
    least_seen: dict[str, dict[str, float | None]] = field(default_factory=dict)
    hidden: frozenset[str] = frozenset()


def compete(
    engine: Engine,
    candidates: Sequence[Candidate],
    told: Callable[[str], None] = lambda _: None,
    null: Fit | None = None,
    other: Callable[[Engine], Engine] | None = None,
) -> Explanation:
    """Find the smallest set of effects that the logs ask for.

    ``null`` is what tolerances alone leave, where that is known; ``other`` another way
    to drive the model: all is begun anew so where it is likelier with the first cause.
    """
    base = engine
    told("tolerances")
    null = null or descent.of_tolerances(engine)
    null = woken(engine, null)
    causes: list[Cause] = []
    ranking: dict[str, float] = {}
    outdone: set[str] = set()
    close: list[Refined] = []
    current = null
    late = read_late(engine, null, candidates)
    if late:
        current, causes = late.fit, [cause_of(engine, late, late.fit.noise)]
    look = looked(engine, current, candidates, causes, told)
    current = look.fit
    null = null if causes else current
    ranking |= look.alone
    for _ in range(TURNS):
        if len(causes) >= SOME and (
            is_another(current) or outweighed(causes, remainder(engine, current))
        ):
            break
        if look.fit is not current:  # a profile that did not stand has changed nothing
            look = looked(engine, current, candidates, causes, told)
            current = look.fit
        if not causes:
            ranking |= {r.screened.candidate.effect: r.gain for r in look.refined}
            close = look.close
        best, one = look.best, look.one
        enough = best and one and best.trusted >= needed_gain(causes, one.shares)
        named = may_vary(engine, candidates, causes) - outdone
        varying, refuted = profile_cause(engine, current, named)
        outdone |= refuted
        if varying and not is_clear(varying, one, look.gains, causes):
            varying = None
        with_best: Fit | None = None
        if varying and best and one and enough:
            with_best = before_profile(engine, current, best, one, varying)
        if varying and with_best is None:
            ranking[varying.effect] = max(ranking.get(varying.effect, 0), varying.gain)
            left = remainder(engine, current)
            if stands_out(varying, left):
                wind = nats_of_gusts(engine, current) if varying.effect == HILL else 0.0
                varying = beside_a_drag(varying, left, wind)
                after = acting(engine, current, causes, varying)
                if may_blow(after[2][-1]):
                    engine, current, causes = after
                else:
                    outdone.add(varying.effect)
                continue
            if best is None:  # another may vary in other channels
                outdone.add(varying.effect)
                continue
        if best and one and enough:
            causes = taken_in(causes, near_to(one, look.gains, look.known))
            current = with_best or fitted(engine, best)
            causes, current = with_all_figures(engine, current, causes, candidates)
            if other and is_likelier(other(engine), current):
                return compete(other(base), candidates, told)
            other = None
            continue
        told(f"two causes at once, {len(causes) + 1}")
        both = coupled(engine, current, look.known)
        two = [cause_of(engine, r, r.fit.noise) for r in both]
        if not two or any(c.gain < needed_gain(causes, c.shares) for c in two):
            break
        current = both[0].fit
        for one in two:
            ranking[one.effect] = max(ranking.get(one.effect, 0.0), one.gain)
            causes = taken_in(causes, near_to(one, look.gains, look.known))
        causes, current = with_all_figures(engine, current, causes, candidates)
    if late:
        effect = late.screened.candidate.effect
        ranking[effect] = max(ranking.get(effect, 0.0), late.gain)
    told("leaving out what is not needed")
    engine, causes, current = without_outdone(engine, causes, current)
    causes, current = without_idle(engine, causes, current)
    causes, current = one_alone(engine, causes, current, close)
    causes.sort(key=lambda c: -c.gain)
    # beside all the causes; what took a tolerance's place was not tried at strengths
    tried = {r.candidate.effect: r for r in look.known if r.shown}
    seen = {effect: told_from(r) for effect, r in tried.items()}
    hidden = frozenset(e for e, r in tried.items() if not shows(r, seen[e]))
    return Explanation(engine, null, current, tuple(causes), ranking, seen, hidden)


def is_likelier(engine: Engine, fit: Fit) -> bool:
    """Tell whether logs driven another way are likelier by the same figures."""
    return descent.fit(engine, fit.values, fit.knobs).score > fit.score


def acting(
    engine: Engine, fit: Fit, causes: Sequence[Cause], varying: Cause
) -> tuple[Engine, Fit, list[Cause]]:
    """Let a cause that varies act, in the place of the same held constant.

    Once one that was weighed beside the noise does, what it leaves is the noise.
    """
    gain = varying.gain
    if varying.weighed:
        gain *= varying.sharpened
        varying = replace(varying, sharpened=1.0)
    gain += sum(c.gain for c in causes if c.effect == varying.effect)
    engine, fit, varying = with_profile(engine, fit, replace(varying, gain=gain))
    return engine, fit, [*(c for c in causes if c.effect != varying.effect), varying]


def may_vary(
    engine: Engine, candidates: Sequence[Candidate], causes: Sequence[Cause]
) -> set[str]:
    """Return the candidates that may vary: none that does already, nor vain gusts."""
    varying = {c.effect for c in causes if c.profiles}
    vain = set() if may_gust(engine, causes) else {WIND}
    return {c.effect for c in candidates} - varying - vain


def taken_in(causes: Sequence[Cause], one: Cause) -> list[Cause]:
    """Return the causes with one more, or with more figures of one they hold."""
    same = [c for c in causes if c.effect == one.effect]
    for c in same:
        one = replace(
            one,
            keys=c.keys + one.keys,
            gain=c.gain + one.gain,
            eased=c.eased + one.eased,
        )
    return [*(c for c in causes if c not in same), one]


def is_clear(
    varying: Cause,
    one: Cause | None,
    held: dict[str, float],
    causes: Sequence[Cause],
) -> bool:
    """Tell whether a profile is to be taken in before the best constant cause.

    It must also beat the best constant cause, and the same effect held constant, if
    there is one that would be taken in. All gains are by the same noise. One that shows
    by the noise that it leaves alone is weighed so, against its own effect at most; one
    that was weighed together with that noise, against any other: its own goes first,
    and it may vary about that.
    """
    if varying.weighed or varying.sharpened > 1:
        if one and varying.weighed and one.effect == varying.effect:
            return False
        if one and not varying.weighed and one.effect not in PROFILES:
            return False
        gain = varying.sharp
        rival = one.sharp + BRISK_ENOUGH if one else 0.0
        return gain > max(rival, needed_gain(causes, varying.shares))
    enough = min(enough_of(p) for p in varying.profiles.values())
    same = held.get(varying.effect, 0.0) + enough / 2 if one else 0.0
    needed = max(enough, needed_gain(causes, varying.shares), same)
    if varying.gain <= needed or one is None:
        return varying.gain > needed
    rival = held.get(one.effect, one.gain) * overlap(one.shares, varying.shares)
    return varying.gain > rival + enough / 2


def fitted(engine: Engine, best: Refined) -> Fit:
    """Return the fit with a candidate, from where it was refined."""
    return descent.fit(engine, best.fit.values, best.fit.knobs, best.fit.noise)


def before_profile(
    engine: Engine, fit: Fit, best: Refined, one: Cause, varying: Cause
) -> Fit | None:
    """Return the fit with a constant cause, if it is to be taken in before a profile.

    A hill takes in what a drag does at the speeds at which it is climbed, and holds it.
    With the drag, and what is then left of the hill, more has to be explained than by
    the hill alone: as much as any further cause must.
    """
    enough = needed_gain([varying], one.shares)
    if one.effect == varying.effect or varying.weighed or one.gain < enough:
        return None
    fit_one = fitted(engine, best)
    rest, _ = profile_cause(engine, fit_one, {varying.effect})
    both = engine.judged(fit_one, fit.noise).score - fit.score
    both += rest.gain if rest else 0.0
    return fit_one if both - varying.gain > enough else None


def is_another(fit: Fit) -> bool:
    """Tell whether a stated figure of the car, no sensor's, is another vehicle's."""
    return any(not k.startswith(BIAS) for k in pulled(fit, ANOTHER_VEHICLE))


def outweighed(causes: Sequence[Cause], left: Remainder) -> bool:
    """Tell whether something unknown is likelier than each cause, where that shows.

    The strongest of the causes there are is found first: what then is left of them is
    less, and what is more is none.
    """
    return left.is_real and all(
        left.against(c.effect, c.shares) > c.sharp for c in causes
    )


def stands_out(varying: Cause, left: Remainder) -> bool:
    """Tell whether nothing unknown is as likely as a profile, by the same noise.

    One that was weighed beside the noise may not show by it; nothing else may be real
    then, but for a drag over time, against which it was weighed likewise.
    """
    if varying.weighed:
        if not left.is_real:
            return True
        others = (r for r in left.rivals if (r.acts_as, r.follows) != DRAG_OVER_TIME)
        left = replace(left, rivals=tuple(others))
    unknown = left.against(varying.effect, varying.shares)
    return varying.gain > UNLIKE[varying.effect] * unknown


def beside_a_drag(varying: Cause, left: Remainder, wind: float = 0.0) -> Cause:
    """Return a hill, or a wind, with the nats of the drag over time in its place.

    In the place of a hill a ``wind`` may be as well. By motion and power alone the two
    differ in what they run along. Of nine drives over hills, two measured ones among
    them, the hill is 13 nats likelier in the closest.
    """
    if varying.effect not in (HILL, WIND):
        return varying
    drags = (r for r in left.rivals if (r.acts_as, r.follows) == DRAG_OVER_TIME)
    nats = max([wind, *(r.evidence for r in drags)])
    return replace(varying, rival=max(varying.rival, nats))


def needed_gain(causes: Sequence[Cause], where: Array) -> float:
    """Nats that one more cause must gain, given those that act in the same tracks."""
    misfits = [
        c.gain
        * (PROFILE_MISFIT if c.profiles else MISFIT * c.sharpened)
        * overlap(c.shares, where)
        for c in causes
    ]
    return max([ENOUGH, *misfits])
