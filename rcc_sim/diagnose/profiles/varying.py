"""Causes that vary over the drive: found as profiles, weighed, and made to act."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from functools import partial
from math import inf

from rcc_sim.diagnose.causes.cause import (
    BRISK_ENOUGH,
    ENOUGH,
    PROFILE_ENOUGH,
    PROFILES,
    TIED,
    WIND_ENOUGH,
    Cause,
)
from rcc_sim.diagnose.causes.profile import Profile, with_acting
from rcc_sim.diagnose.causes.strengths import RELIEF, WINDS
from rcc_sim.diagnose.fitting import descent
from rcc_sim.diagnose.fitting.engine import MEMORY, Engine
from rcc_sim.diagnose.fitting.fit import Fit
from rcc_sim.diagnose.fitting.knobs import Knob, own_key
from rcc_sim.diagnose.fitting.pulls import TOO_FAR
from rcc_sim.diagnose.profiles.gusts import WIND, in_gusts
from rcc_sim.diagnose.profiles.hidden_hill import HILL, hidden_hill
from rcc_sim.diagnose.profiles.probe import Probe, probe_size
from rcc_sim.diagnose.profiles.switched import LOAD, beside_noise
from rcc_sim.diagnose.residuals.problem import Problem
from rcc_sim.side_by_side import each

WINDOW_COUNTS = (20, 60)
FINER, SHORTEST = (120, 240, 480), 1.25
"""Windows in which a profile must hang together if it does not in fewer, and the mean
time that each takes at least. [s]

A rough road is a force, too: but one that knows nothing of itself a second ago.
"""

SHARPENED = 4
"""Times that a profile acts, each time on what the last left, at most."""


def profile_cause(
    engine: Engine, fit: Fit, named: set[str], constant: Fit | None = None
) -> tuple[Cause | None, set[str]]:
    """Return the effect that best explains as a profile what a fit leaves, if any.

    And those that something else of the same course outdoes: no later turn is to try
    them, once that is half explained by what they are as a constant.

    One that shows by the noise that it leaves alone, if no other does; a load that
    switches or grows, if it is likelier than those, each with the noise that it leaves.
    No load at all, where a drag that goes the way of the load is likelier. A hill that
    does not hang together may be hidden in the noise, if it may be in that of the best
    fit with a ``constant`` cause, too.
    """

    def one(effect: str) -> tuple[Cause | None, Cause | None]:
        found = as_profile(engine, fit, effect)
        if effect == HILL and found is None:
            found = hidden_hill(engine, held(fit, PROFILES[HILL][0]), constant)
        if effect != LOAD:
            return found, None
        at_rest = held(fit, PROFILES[LOAD][0])
        return found, beside_noise(engine, at_rest, hidden=found is None)

    tried = each(one, [e for e in PROFILES if e in named])
    every = sorted((c for c, _ in tried if c), key=lambda c: -c.gain)
    course = next((c for _, c in tried if c), None)
    outdone: set[str] = set()
    if course and beyond_drag(course) < -ENOUGH:
        outdone = {LOAD}
        every = [c for c in every if c.effect != LOAD]
    if course and beyond_drag(course) >= ENOUGH and not is_stated(engine, course):
        nats = each(partial(with_its_noise, engine, fit), every)
        rival = max(nats, default=0.0)
        if course.sharp > rival:
            return replace(course, rival=max(course.rival, rival)), outdone
    found = [c for c in every if c.sharpened == 1] or every
    if not found:
        return None, outdone
    rival = max([found[0].rival, *(c.gain for c in found[1:])])
    return replace(found[0], rival=rival), outdone


def beyond_drag(course: Cause) -> float:
    """Nats by which a load is likelier than a drag of the same course.

    Of 112 drives of the blind plant and the reference set without a cause none has 18
    more, as a load must gain; of 76 with something of no library one has, beside a
    remainder that is real. Of 29 with a load it is 60 or more in all whose load shows.
    """
    return course.sharp - course.rival


def with_its_noise(engine: Engine, fit: Fit, cause: Cause) -> float:
    """Nats of a cause's profiles, each together with the noise that it leaves."""
    if cause.weighed:
        return cause.sharp
    key, along = PROFILES[cause.effect]
    probe = Probe(engine, held(fit, key), key)
    return sum(
        probe.with_noise(p, i, engine.problems[i].coordinate(along))
        for i, p in cause.profiles.items()
    )


def as_profile(engine: Engine, fit: Fit, effect: str) -> Cause | None:
    """Return an effect as a profile over each log, if it hangs together."""
    key, along = PROFILES[effect]
    found: dict[int, Profile] = {}
    coherence, sharpened = 0.0, 1.0
    probe = Probe(engine, held(fit, key), key)
    for i, problem in enumerate(engine.problems):
        x = problem.coordinate(along)
        tried = each(partial(probe.profile, i, along, x), WINDOW_COUNTS)
        found[i] = max(tried, key=lambda p: p.evidence)
        if found[i].evidence <= enough_of(found[i]):
            continue
        for n in finer(problem):
            if max(p.coherence for p in tried) >= TIED:
                break
            tried.append(probe.profile(i, along, x, n))
        coherence = max(coherence, *(p.coherence for p in tried))
    if coherence < TIED:
        sharpened = more_beside(probe, found) if along == "time_s" else 1.0
        if sharpened == 1:
            return None
    gain = sum(p.evidence for p in found.values())
    cause = Cause(
        effect,
        (key,),
        gain,
        profiles=found,
        sharpened=sharpened,
        shares=probe.shares_of(found),
    )
    return None if is_stated(engine, cause) else cause


def more_beside(probe: Probe, found: Mapping[int, Profile]) -> float:
    """Times more that profiles gain which are weighed against the noise; 1: too little.

    Those alone that hang together.
    """
    sharpened = 1.0
    for i, profile in found.items():
        if profile.evidence > 0 and profile.coherence >= TIED:
            x = probe.engine.problems[i].coordinate(profile.along)
            nats = probe.with_noise(profile, i, x)
            if nats > (WIND_ENOUGH if probe.key in WINDS else BRISK_ENOUGH):
                sharpened = max(sharpened, nats / profile.evidence)
    return sharpened


def enough_of(profile: Profile) -> float:
    """Nats that a profile must gain."""
    if profile.key in WINDS:
        return WIND_ENOUGH
    if profile.beside_drift:
        return ENOUGH
    apart = profile.knots[1] - profile.knots[0]
    brisk = profile.along == "time_s" and apart < 2 * MEMORY
    return BRISK_ENOUGH if brisk else PROFILE_ENOUGH


def finer(problem: Problem) -> list[int]:
    """Into how many windows more a log may be cut to see what hangs together."""
    time = problem.log["time_s"]
    return [n for n in FINER if n < (time[-1] - time[0]) / SHORTEST]


def every_count(problem: Problem) -> tuple[int, ...]:
    """Into how many windows a log may be cut, the fewest first."""
    return (*WINDOW_COUNTS, *finer(problem))


def is_stated(engine: Engine, cause: Cause) -> bool:
    """Tell whether profiles stay within what the file's sd of their figure allows."""
    figure = engine.vehicle.figures().get(cause.keys[0])
    size = max(p.rms for p in cause.profiles.values())
    return figure is not None and size < TOO_FAR * figure.tolerance


def held(fit: Fit, key: str) -> Fit:
    """Return a fit in which a cause, constant so far, is left to vary about its level.

    While it could move as well, a profile's own level would mean nothing.
    """
    free = any(k.key == key and k.sd == inf for k in fit.knobs)
    return fit.holding(key) if free else fit


def with_profile(engine: Engine, fit: Fit, cause: Cause) -> tuple[Engine, Fit, Cause]:
    """Let a profile act on the logs, by the noise it leaves; fit the knobs anew.

    Under less noise more of it shows: it is sharpened as long as it gains. It takes in
    what the same effect was found to be as a constant.
    """
    if cause.effect == WIND:
        return in_gusts(engine, fit, cause)
    key, along = PROFILES[cause.effect]
    about = held(fit, key)
    probe = Probe(engine, about, key)
    found = {}
    for i, profile in cause.profiles.items():
        problem = engine.problems[i]
        x = problem.coordinate(along)
        found[i] = probe.sharper(profile, i, x, every_count(problem))
    values = dict(about.values)
    if about is not fit:
        level = values.pop(key) - engine.stated(key)
        found = {i: p.raised(level) for i, p in found.items()}
    start, profiles = engine, dict[int, Profile]()
    for _ in range(SHARPENED):
        if not found:
            break
        engine = with_acting(engine, found)
        for i, more in found.items():
            profiles[i] = profiles[i].plus(more) if i in profiles else more
        fit = descent.fit(engine, values, about.knobs)
        values = fit.values
        found = more_of(engine, fit, key, along, profiles)
    if cause.effect == LOAD:
        engine, fit, profiles = levelled(start, fit, key, profiles)
        return cut(start, engine, fit, replace(cause, profiles=profiles))
    return engine, fit, replace(cause, profiles=profiles)


def anew(engine: Engine, fit: Fit, cause: Cause) -> tuple[Engine, Fit, Cause] | None:
    """Return a cause that varies with its course found anew, if that gains enough.

    It was found while what has been taken in since was missing: a hill is climbed by
    force, and holds a part of what the motor loses with it. Now that gives way, too.
    """
    counts = {i: every_count(engine.problems[i]) for i in cause.profiles}
    start, now, more, found = instead(engine, fit, cause, counts)
    if more.score - fit.score < ENOUGH:
        return None
    if cause.effect == LOAD:
        now, more, found = levelled(start, more, cause.keys[0], found)
        whole = replace(cause, profiles=found, cut={}, cut_nats=0.0)
        return cut(start, now, more, whole)
    return now, more, replace(cause, profiles=found)


def with_another(engine: Engine, fit: Fit, cause: Cause) -> Fit:
    """Return the fit with a course found anew.

    What it gains is to be held against the same of another fit: in as many windows, for
    more of them would be likelier whatever acts.
    """
    return instead(engine, fit, cause, as_many(cause))[2]


def as_many(cause: Cause) -> dict[int, tuple[int, ...]]:
    """Return the number of windows that each course of a cause has."""
    return {i: (len(p.knots),) for i, p in cause.profiles.items()}


def instead(
    engine: Engine, fit: Fit, cause: Cause, counts: Mapping[int, tuple[int, ...]]
) -> tuple[Engine, Engine, Fit, dict[int, Profile]]:
    """Return logs without a course, and with another found in its place.

    In as many windows as is likeliest of some ``counts``. With the fit, and the course.
    """
    found = {}
    probe = Probe(engine, fit, cause.keys[0]).as_if_none(cause.profiles)
    for i, p in cause.profiles.items():
        x = engine.problems[i].coordinate(p.along)
        tried = each(partial(probe.profile, i, p.along, x), counts[i])
        likeliest = max(tried, key=lambda one: one.evidence)
        found[i] = probe.sharper(likeliest, i, x, counts[i])
    start = with_acting(engine, {i: p.reversed for i, p in cause.profiles.items()})
    now = with_acting(start, found)
    return start, now, descent.refit(now, fit), found


def levelled(
    engine: Engine, fit: Fit, key: str, profiles: Mapping[int, Profile]
) -> tuple[Engine, Fit, dict[int, Profile]]:
    """Return a fit in which the mean of each profile was as free as a constant cause.

    What a profile found first is what the tolerances had left of it; no prior says that
    a load is small, nor that it is the same in two logs. ``engine`` is the one on which
    no profile acts.
    """
    level, size = engine.stated(key), probe_size(engine, key)
    low, high = engine.vehicle.effect_bounds(key)
    means = {
        i: Knob(own_key(i, key), level + p.mean, inf, low, high, size)
        for i, p in profiles.items()
    }
    means = {i: replace(k, value=k.within(k.value)) for i, k in means.items()}
    about = {i: p.raised(level - means[i].value) for i, p in profiles.items()}
    knobs = [*(k for k in fit.knobs if k.key != key), *means.values()]
    fit = descent.fit(with_acting(engine, about), fit.values, knobs)
    told = raised_by(fit, level, means, about)
    fit = fit.without([key, *(k.key for k in means.values())])
    return with_acting(engine, told), fit, told


def evened(engine: Engine, fit: Fit, cause: Cause) -> tuple[Engine, Fit, Cause] | None:
    """Return a hill whose mean was fitted beside all else, if that gains anything.

    Its course stays. A mean is a drag: what was found while tolerances stood in for the
    hill leaves both off. A climb is no likelier than ``RELIEF`` says, in each log.
    """
    key = cause.keys[0]
    level, size = engine.stated(key), probe_size(engine, key)
    low, high = engine.vehicle.effect_bounds(key)
    means, before = {}, fit.score
    for i, p in cause.profiles.items():
        sd = RELIEF / max(float(p.knots[-1] - p.knots[0]), 1.0)
        means[i] = Knob(own_key(i, key), level - p.mean, sd, low, high, size)
        before -= 0.5 * (p.mean / sd) ** 2
    rise = {k.key: level for k in means.values()}
    knobs = [*(k for k in fit.knobs if k.key != key), *means.values()]
    found = descent.fit(engine, fit.values | rise, knobs)
    if found.score < before + descent.SETTLED:
        return None
    told = raised_by(found, level, means, cause.profiles)
    engine = with_acting(engine, {i: p.reversed for i, p in cause.profiles.items()})
    engine, found = with_acting(engine, told), found.without([key, *rise])
    now = engine.at(found, found.values)
    return None if now is None else (engine, now, replace(cause, profiles=told))


def raised_by(
    fit: Fit, level: float, means: Mapping[int, Knob], profiles: Mapping[int, Profile]
) -> dict[int, Profile]:
    """Return profiles on top of what a fit found of a mean of each, over a level."""
    told = {}
    for i, knob in means.items():
        raised = profiles[i].raised(fit.values[knob.key] - level)
        told[i] = replace(raised, mean_sd=max(raised.mean_sd, fit.sd(knob.key)))
    return told


def cut(
    start: Engine, engine: Engine, fit: Fit, cause: Cause
) -> tuple[Engine, Fit, Cause]:
    """Leave unexplained what a load would have to be below nil, or beyond its bounds.

    No load feeds the battery: where one would have to, something else does, or a meter
    is off. ``start`` is the engine on which no profile acts.
    """
    key = cause.keys[0]
    low, high = (
        bound - start.stated(key) for bound in start.vehicle.effect_bounds(key)
    )
    possible, beyond = {}, {}
    for i, profile in cause.profiles.items():
        possible[i], beyond[i] = profile.cut_to(low, high)
    if not any(p.value.any() for p in beyond.values()):
        return engine, fit, cause
    engine = with_acting(start, possible)
    less = descent.refit(engine, fit)
    nats = fit.score - less.score
    return engine, less, replace(cause, profiles=possible, cut=beyond, cut_nats=nats)


def more_of(
    engine: Engine, fit: Fit, key: str, along: str, profiles: Iterable[int]
) -> dict[int, Profile]:
    """Return what a fit leaves of profiles that are known to act, log by log."""
    found = {}
    probe = Probe(engine, fit, key)
    for i in profiles:
        problem = engine.problems[i]
        x = problem.coordinate(along)
        tried = each(partial(probe.profile, i, along, x), every_count(problem))
        clear = [p for p in tried if p.coherence >= TIED and p.evidence > enough_of(p)]
        if clear:
            found[i] = max(clear, key=lambda p: p.evidence)
    return found
