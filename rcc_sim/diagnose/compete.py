"""Null, single effects, sets of effects and profiles compete for the logs."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from math import inf

import numpy as np

from rcc_sim.diagnose.candidates import Candidate
from rcc_sim.diagnose.engine import Engine, Fit
from rcc_sim.diagnose.knobs import Knob, nuisance_knobs
from rcc_sim.diagnose.noise import Whitener
from rcc_sim.diagnose.profile import Probe, Profile, probe_size
from rcc_sim.diagnose.remainder import remainder
from rcc_sim.diagnose.screen import Screen, Screened

REFINED = 6
"""Candidates that are refined after the screen."""

ENOUGH = 15.0
"""Nats that a cause must gain, by the noise before and after it alike."""

PROFILE_ENOUGH = 30.0
"""Nats that a profile must gain; it must beat a constant by half of this."""

PROFILE_MISFIT = 0.1
"""Share of what a profile gained that a further cause must: with knots some distance
apart it leaves a part of itself."""

MISFIT = 0.003
"""Share of what the first cause gained that a further one must: no model of an
effect is better than some parts in a thousand."""

TIED = 3.0
"""Nats below which two candidates cannot be told apart."""

LESS_LIKELY = {"iron_loss": 4.0}
"""Nats that an effect starts behind: one of two figures that do as another effect."""

UNLIKE = 5.0
"""Nats by which something unknown must beat a profile to stand in its place."""

MOST_CAUSES = 4
PROFILES = {
    "road_grade": ("effects.road_grade.slope", "distance_m"),
    "auxiliary_load": ("effects.auxiliary_load.power_w", "time_s"),
}
WINDOW_COUNTS = (20, 60)


@dataclass(frozen=True)
class Cause:
    """An effect that is asserted.

    Parameters
    ----------
    effect : str
        Its id.
    keys : tuple of str
        Dotted keys of the figures found.
    gain : float
        Nats it gained when it was taken in.
    rival : float
        Nats of the best candidate that is not tied with it.
    tied : tuple of str
        Effects that these logs cannot tell from it.
    profiles : dict
        Log -> profile, where it varies over the drive.
    sharpened : float
        Times more that it gained by the noise it leaves than by ``gain``.
    """

    effect: str
    keys: tuple[str, ...]
    gain: float
    rival: float
    tied: tuple[str, ...] = ()
    profiles: dict[int, Profile] = field(default_factory=dict)
    sharpened: float = 1.0


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
        Effect -> nats it gained alone, of all candidates.
    """

    engine: Engine
    null: Fit
    fit: Fit
    causes: tuple[Cause, ...]
    ranking: dict[str, float]


@dataclass(frozen=True)
class Refined:
    """A candidate refined: its fit, and its gain by the noise before and after."""

    screened: Screened
    fit: Fit
    before: float
    after: float

    @property
    def gain(self) -> float:
        """Nats that hold by either noise."""
        return min(self.before, self.after)


def compete(
    engine: Engine,
    candidates: Sequence[Candidate],
    told: Callable[[str], None] = lambda _: None,
) -> Explanation:
    """Find the smallest set of effects that the logs ask for."""
    told("tolerances")
    null = engine.fit({}, nuisance_knobs(engine.problems))
    causes: list[Cause] = []
    ranking: dict[str, float] = {}
    current = null
    for turn in range(MOST_CAUSES):
        told(f"screening for cause {turn + 1}")
        taken = {c.effect for c in causes}
        free = [c for c in candidates if c.effect not in taken]
        screen = Screen(engine, current)
        found = sorted(engine.pool.map(screen.best, free), key=lambda r: -r.gain)
        if not ranking:
            ranking = {r.candidate.effect: r.gain for r in found}
        told(f"refining cause {turn + 1}")
        refined = refine(engine, current, [r for r in found[:REFINED] if r.gain > 1])
        if not causes:
            ranking |= {r.screened.candidate.effect: r.gain for r in refined}
        best = refined[0] if refined else None
        constant = best.gain if best else 0.0
        named = {c.effect for c in candidates} - taken
        varying = profile_cause(engine, current, named)
        needed = needed_gain(causes)
        if varying and varying.gain > max(
            PROFILE_ENOUGH, constant + PROFILE_ENOUGH / 2, needed
        ):
            ranking[varying.effect] = max(ranking.get(varying.effect, 0), varying.gain)
            if varying.gain > remainder(engine, current).evidence - UNLIKE:
                engine, current = with_profile(engine, current, varying)
                causes.append(varying)
                continue
        if best is None or constant < needed:
            break
        causes.append(cause_of(best, refined))
        current = engine.fit(best.fit.values, best.fit.knobs)
    causes.sort(key=lambda c: -c.gain)
    return Explanation(engine, null, current, tuple(causes), ranking)


def needed_gain(causes: Sequence[Cause]) -> float:
    """Nats that one more cause must gain, given those already taken in."""
    misfits = (
        c.gain * (PROFILE_MISFIT if c.profiles else MISFIT * c.sharpened)
        for c in causes
    )
    return max(ENOUGH, *misfits, 0.0)


def refine(engine: Engine, base: Fit, found: Sequence[Screened]) -> list[Refined]:
    """Refine candidates, by the noise of the base and by that of the best; best first.

    The noise that the base leaves holds what it misses; that of the best candidate
    shows the others in a sharper light. A gain counts if it holds by both.
    """
    if not found:
        return []

    def fitted(base: Fit, noise: list[Whitener]) -> Callable[[Screened], Fit]:
        return lambda r: with_effect(engine, base, r, noise)

    fits = list(engine.pool.map(fitted(base, base.noise), found))
    handicap = [LESS_LIKELY.get(r.candidate.effect, 0.0) for r in found]
    before = [f.score - base.score - h for f, h in zip(fits, handicap, strict=True)]
    noise = engine.learn_noise(fits[int(np.argmax(before))].residuals)
    again = engine.fit(
        base.values, base.knobs, noise=noise, signals=base.signals, rounds=3
    )
    moved = [
        replace(r, values={k: f.values[k] for k in r.values})
        for r, f in zip(found, fits, strict=True)
    ]
    fits = list(engine.pool.map(fitted(again, noise), moved))
    after = [f.score - again.score - h for f, h in zip(fits, handicap, strict=True)]
    every = zip(moved, fits, before, after, strict=True)
    return sorted((Refined(*one) for one in every), key=lambda r: -r.after)


def with_effect(
    engine: Engine, base: Fit, screened: Screened, noise: list[Whitener]
) -> Fit:
    """Refine one candidate under given noise, the knobs of the base giving way."""
    mine = effect_knobs(screened)
    keys = {k.key for k in mine}
    kept = [(j, k) for j, k in zip(base.signals, base.knobs, strict=True)]
    kept = [(j, k) for j, k in kept if k.key not in keys]
    knobs = [k for _, k in kept] + mine
    now = engine.evaluate(base.values | screened.values, knobs, noise)
    for _ in range(6):
        own = engine.signals(now.values, mine, now.residuals)
        signals = [j for j, _ in kept] + own
        new = engine.fit(now.values, knobs, noise=noise, signals=signals, rounds=1)
        gain = new.score - now.score
        now = new
        if gain < 0.5:
            break
    return now


def effect_knobs(screened: Screened) -> list[Knob]:
    """The figures of a candidate, free to move from where the screen left them."""
    knobs = []
    for s in screened.candidate.searches:
        if s.key not in screened.values:
            continue
        x = screened.values[s.key]
        moved = abs(x - s.neutral) if s.neutral < inf else abs(x)
        step = 0.02 * (moved or abs(s.first) or 1.0)
        knobs.append(Knob(s.key, x, inf, s.low, s.high, step))
    return knobs


def cause_of(best: Refined, refined: Sequence[Refined]) -> Cause:
    """Return the winner as a cause, with those that are tied with it."""
    others = [r for r in refined if r is not best]
    name = best.screened.candidate.effect
    slack = LESS_LIKELY.get
    tied = [
        r
        for r in others
        if best.after - r.after
        < TIED + slack(r.screened.candidate.effect, 0.0) + 0.001 * best.after
    ]
    rival = max((r.after for r in others if r not in tied), default=0.0)
    return Cause(
        name,
        tuple(best.screened.values),
        best.gain,
        best.gain - (best.after - rival),
        tuple(r.screened.candidate.effect for r in tied),
        sharpened=max(best.after / best.gain, 1.0) if best.gain > 0 else 1.0,
    )


def profile_cause(engine: Engine, fit: Fit, named: set[str]) -> Cause | None:
    """Return the effect that best explains as a profile what a fit leaves, if any."""
    best: Cause | None = None
    for effect, (key, along) in PROFILES.items():
        if effect not in named:
            continue
        found: dict[int, Profile] = {}
        probe = Probe(engine, fit, key, probe_size(engine, key))
        for i, problem in enumerate(engine.problems):
            x = problem.distance if along == "distance_m" else problem.log["time_s"]
            tried = [probe.profile(i, along, x, n) for n in WINDOW_COUNTS]
            found[i] = max(tried, key=lambda p: p.evidence)
        gain = sum(p.evidence for p in found.values())
        if best is None or gain > best.gain:
            best = Cause(effect, (key,), gain, best.gain if best else 0.0, (), found)
        elif best:
            best = replace(best, rival=max(best.rival, gain))
    return best


def with_profile(engine: Engine, fit: Fit, cause: Cause) -> tuple[Engine, Fit]:
    """Let a profile act on the logs, and fit the knobs anew."""
    problems = list(engine.problems)
    for i, profile in cause.profiles.items():
        p = problems[i]
        if profile.along == "distance_m":
            problems[i] = p.on_road(profile.knots, profile.value)
        else:
            problems[i] = p.with_load(profile.at(p.log["time_s"]))
    moved = Engine(problems)
    return moved, moved.fit(fit.values, fit.knobs)
