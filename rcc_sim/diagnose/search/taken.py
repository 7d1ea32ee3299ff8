"""What a competition has taken in, and what it takes in next."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

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
from rcc_sim.diagnose.fitting.engine import Engine
from rcc_sim.diagnose.fitting.fit import Fit
from rcc_sim.diagnose.fitting.knobs import BIAS
from rcc_sim.diagnose.fitting.pulls import pulled
from rcc_sim.diagnose.profiles.beside_losses import beside_losses
from rcc_sim.diagnose.profiles.drag_or_hill import beside_a_drag
from rcc_sim.diagnose.profiles.forms import DRAG_OVER_TIME
from rcc_sim.diagnose.profiles.gusts import WIND, may_blow, may_gust
from rcc_sim.diagnose.profiles.remainder import Remainder, remainder
from rcc_sim.diagnose.profiles.varying import (
    enough_of,
    profile_cause,
    with_profile,
)
from rcc_sim.diagnose.search.couples import coupled
from rcc_sim.diagnose.search.give_way import (
    CLOSE,
    beside_courses,
    fitted,
    give_way,
)
from rcc_sim.diagnose.search.look import Look, looked
from rcc_sim.diagnose.search.refine import Refined
from rcc_sim.diagnose.search.screen import Screened
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

SOME = 2
"""Causes from which on no more are sought if something unknown outweighs all, or a
stated figure is another vehicle's."""


VARYING, CONSTANT, TWO, NOTHING = "varying", "constant", "two", ""
"""What a turn has taken in."""


@dataclass(frozen=True)
class KeptOut:
    """A cause that gains enough alone, and too little beside so strong ones.

    Parameters
    ----------
    effect : str
        Its id.
    values : dict
        Dotted key -> its figure.
    nats, needed : float
        What it gains, and what is asked of it.
    """

    effect: str
    values: dict[str, float]
    nats: float
    needed: float


class Taken:
    """What a competition has taken in by some turn.

    Parameters
    ----------
    engine : Engine
        The logs, with the profiles found acting on them.
    fit : Fit
        Tolerances and causes.
    candidates : sequence of Candidate
        Effects that could act.
    told : callable
        Called with what is being done.
    """

    def __init__(
        self,
        engine: Engine,
        fit: Fit,
        candidates: Sequence[Candidate],
        told: Callable[[str], None],
    ) -> None:
        self.engine, self.fit = engine, fit
        self.candidates, self.told = candidates, told
        self.causes: list[Cause] = []
        self.ranking: dict[str, float] = {}
        self.kept_out: KeptOut | None = None
        self.outdone: set[str] = set()
        """Effects that are not to vary: something else of the same course outdid it."""
        self.displaced: list[Refined] = []
        """Candidates that gained enough before what was taken in last."""

    def looked(self, found: list[tuple[Screened, Fit]] | None = None) -> Look:
        """Return what candidates gain, the fit as far down as was seen."""
        now = self.engine, self.fit, self.candidates, self.causes
        look = looked(*now, self.told, found)
        self.fit = look.fit
        return look

    def rank(self, effect: str, gain: float) -> None:
        """Keep the most that an effect gained."""
        self.ranking[effect] = max(self.ranking.get(effect, 0.0), gain)

    def are_enough(self) -> bool:
        """Tell whether no more is sought, for the car or the effect is another."""
        return len(self.causes) >= SOME and (
            is_another(self.fit)
            or outweighed(self.causes, remainder(self.engine, self.fit))
        )

    def take_in(self, look: Look) -> str:
        """Take in what gains most: one that varies, a constant one, or two at once.

        Return which; nothing if nothing gains enough.
        """
        look = beside_courses(self.engine, look, self.causes, self.displaced)
        self.displaced = []
        best, one = look.best, look.one
        self.kept_out = None
        if best and one:
            needed = needed_gain(self.causes, one.shares)
            if best.trusted < needed:
                values = {key: best.fit.values[key] for key in one.keys}
                self.kept_out = KeptOut(one.effect, values, best.trusted, needed)
                one = None
        varying = self.varying(look, best.fit if best and one else None)
        with_one: Fit | None = None
        if varying and best and one:
            first = self.hidden_by(varying, look, best, one)
            with_one = before_profile(self.engine, self.fit, *first, varying)
            best, one = (best, one) if with_one is None else first
        if varying and with_one is None and self.may_act(varying, look):
            return VARYING
        if best and one:
            self.causes = taken_in(self.causes, near_to(one, look.gains, look.known))
            self.fit = with_one or fitted(self.engine, best.fit)
            self.settle()
            return CONSTANT
        self.told(f"two causes at once, {len(self.causes) + 1}")
        both = coupled(self.engine, self.fit, look.known)
        two = [cause_of(self.engine, r, r.fit.noise) for r in both]
        if not two or any(c.gain < needed_gain(self.causes, c.shares) for c in two):
            return NOTHING
        self.fit = both[0].fit
        for c in two:
            self.rank(c.effect, c.gain)
            self.causes = taken_in(self.causes, near_to(c, look.gains, look.known))
        self.settle()
        return TWO

    def varying(self, look: Look, constant: Fit | None) -> Cause | None:
        """Return what explains most as a profile, if it goes before the best constant.

        That is asked of what was seen, whether it gains enough or not; if it does,
        ``constant`` is the fit with it.
        """
        named = may_vary(self.engine, self.candidates, self.causes) - self.outdone
        varying, refuted = profile_cause(self.engine, self.fit, named, constant)
        self.outdone |= refuted
        if varying and is_clear(varying, look.one, look.gains, self.causes):
            return varying
        return None

    def hidden_by(
        self, varying: Cause, look: Look, best: Refined, one: Cause
    ) -> tuple[Refined, Cause]:
        """Return the best constant cause, which a profile may have taken in.

        That of another effect, if there is one that comes near the best: a load over
        time takes in a drag that goes with the speed, as a hill does.
        """
        if best.screened.candidate.effect != varying.effect:
            return best, one
        least = max(ENOUGH, CLOSE * best.gain)
        for r in look.refined:
            if r.screened.candidate.effect != varying.effect and r.reaches(least):
                other = cause_of(self.engine, r, look.fit.noise)
                if r.trusted >= needed_gain(self.causes, other.shares):
                    return r, other
        return best, one

    def may_act(self, varying: Cause, look: Look) -> bool:
        """Let a profile act if it stands; tell whether the turn is done with it.

        It is not where it does not stand and a constant cause may be what it is.
        """
        self.rank(varying.effect, varying.gain)
        left = remainder(self.engine, self.fit)
        left = beside_losses(self.engine, self.fit, [varying], left, acting=False)
        if stands_out(varying, left):
            varying = beside_a_drag(self.engine, self.fit, varying, left)
            engine, fit, causes = acting(self.engine, self.fit, self.causes, varying)
            if may_blow(causes[-1]):
                self.engine, self.fit, self.causes = engine, fit, causes
                self.displaced = [r for r in look.refined if r.reaches(ENOUGH)]
            else:
                self.outdone.add(varying.effect)
            return True
        if look.best is None:  # another may vary in other channels
            self.outdone.add(varying.effect)
        return look.best is None

    def settle(self) -> None:
        """Let all figures of a cause be off where several may, and courses give way."""
        self.causes, self.fit = with_all_figures(
            self.engine, self.fit, self.causes, self.candidates
        )
        self.engine, self.fit, self.causes = give_way(
            self.engine, self.fit, self.causes
        )


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
    fit_one = fitted(engine, best.fit)
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


def needed_gain(causes: Sequence[Cause], where: Array) -> float:
    """Nats that one more cause must gain, given those that act in the same tracks."""
    misfits = [
        c.gain
        * (PROFILE_MISFIT if c.profiles else MISFIT * c.sharpened)
        * overlap(c.shares, where)
        for c in causes
    ]
    return max([ENOUGH, *misfits])
