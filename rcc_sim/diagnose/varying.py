"""Causes that vary over the drive: found as profiles, weighed, and made to act."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace

import numpy as np

from rcc_sim.diagnose import descent
from rcc_sim.diagnose.cause import ENOUGH, Cause
from rcc_sim.diagnose.engine import MEMORY, Engine
from rcc_sim.diagnose.fit import Fit
from rcc_sim.diagnose.problem import Problem
from rcc_sim.diagnose.profile import Probe, Profile, acted_on, probe_size
from rcc_sim.diagnose.refine import TIED, TOO_FAR

PROFILES = {
    "road_grade": ("effects.road_grade.slope", "distance_m"),
    "auxiliary_load": ("effects.auxiliary_load.power_w", "time_s"),
}
"""Effect that may vary -> its figure, and what it varies along."""

PROFILE_ENOUGH, BRISK_ENOUGH = 60.0, 30.0
"""Nats that a profile must gain; and a load that changes within twice the time that
noise remembers, which nothing that is slow by chance looks like, or that hangs together
and is weighed against the noise that passes for it. Of 264 drives of the blind plant
without a cause, 6 had a slope that gained 46 to 69 (a rough road is a force, too), none
a load that gained more than 26, and none of the 140 short ones a load that gained 1; of
110 others none had a load that hangs together in as many windows as are tried first. It
must beat a constant by half of this. One that is weighed together with a sensor's drift
needs no more than a constant cause: noise alone gained 10 once in 100 draws."""

WINDOW_COUNTS = (20, 60)
FINER, SHORTEST = (120, 240, 480), 1.25
"""Windows in which a profile must hang together if it does not in fewer, and the mean
time that each takes at least. [s]

A rough road is a force, too: but one that knows nothing of itself a second ago.
"""

SHARPENED = 4
"""Times that a profile acts, each time on what the last left, at most."""

ROOM = 2e7
"""Largest number of windows times rows: each is a number to be kept, for each track."""


def profile_cause(engine: Engine, fit: Fit, named: set[str]) -> Cause | None:
    """Return the effect that best explains as a profile what a fit leaves, if any.

    One that shows by the noise that it leaves alone, if no other does.
    """
    wanted = [effect for effect in PROFILES if effect in named]
    tried = engine.each(lambda effect: as_profile(engine, fit, effect), wanted)
    every = sorted((c for c in tried if c), key=lambda c: -c.gain)
    found = [c for c in every if c.sharpened == 1] or every
    if not found:
        return None
    return replace(found[0], rival=max((c.gain for c in found[1:]), default=0.0))


def as_profile(engine: Engine, fit: Fit, effect: str) -> Cause | None:
    """Return an effect as a profile over each log, if it hangs together."""
    key, along = PROFILES[effect]
    found: dict[int, Profile] = {}
    coherence, sharpened = 0.0, 1.0
    probe = Probe(engine, fit, key, probe_size(engine, key))
    for i, problem in enumerate(engine.problems):
        x = problem.coordinate(along)
        tried = [probe.profile(i, along, x, n) for n in WINDOW_COUNTS]
        found[i] = max(tried, key=lambda p: p.evidence)
        if found[i].evidence <= enough_of(found[i]):
            continue
        for n in finer(problem):
            if max(p.coherence for p in tried) >= TIED:
                break
            tried.append(probe.profile(i, along, x, n))
        coherence = max(coherence, *(p.coherence for p in tried))
    if coherence < TIED:
        sharpened = beside_noise(probe, found) if along == "time_s" else 1.0
        if sharpened == 1:
            return None
    if is_stated(engine, key, found.values()):
        return None
    gain = sum(p.evidence for p in found.values())
    return Cause(
        effect,
        (key,),
        gain,
        profiles=found,
        sharpened=sharpened,
        shares=probe.shares,
    )


def beside_noise(probe: Probe, found: Mapping[int, Profile]) -> float:
    """Times more that profiles gain which are weighed against the noise; 1: too little.

    Those alone that hang together.
    """
    sharpened = 1.0
    for i, profile in found.items():
        if profile.evidence > 0 and profile.coherence >= TIED:
            x = probe.engine.problems[i].coordinate(profile.along)
            nats = probe.with_noise(profile, i, x)
            if nats > BRISK_ENOUGH:
                sharpened = max(sharpened, nats / profile.evidence)
    return sharpened


def enough_of(profile: Profile) -> float:
    """Nats that a profile must gain."""
    if profile.beside_drift:
        return ENOUGH
    apart = profile.knots[1] - profile.knots[0]
    brisk = profile.along == "time_s" and apart < 2 * MEMORY
    return BRISK_ENOUGH if brisk else PROFILE_ENOUGH


def finer(problem: Problem) -> list[int]:
    """Into how many windows more a log may be cut to see what hangs together."""
    time = problem.log["time_s"]
    most = min((time[-1] - time[0]) / SHORTEST, ROOM / len(time))
    return [n for n in FINER if n < most]


def is_stated(engine: Engine, key: str, profiles: Iterable[Profile]) -> bool:
    """Tell whether profiles stay within what the file's sd of their figure allows."""
    figure = engine.problems[0].vehicle.figures().get(key)
    size = np.sqrt(np.mean(np.concatenate([p.value for p in profiles]) ** 2))
    return figure is not None and bool(size < TOO_FAR * figure.sd)


def with_profile(engine: Engine, fit: Fit, cause: Cause) -> tuple[Engine, Fit, Cause]:
    """Let a profile act on the logs, by the noise it leaves; fit the knobs anew.

    Under less noise more of it shows: it is sharpened as long as it gains.
    """
    key, along = PROFILES[cause.effect]
    probe = Probe(engine, fit, key, probe_size(engine, key))
    found = {
        i: probe.sharper(p, i, engine.problems[i].coordinate(along))
        for i, p in cause.profiles.items()
    }
    profiles: dict[int, Profile] = {}
    for _ in range(SHARPENED):
        if not found:
            break
        problems = list(engine.problems)
        for i, more in found.items():
            problems[i] = acted_on(problems[i], more)
            profiles[i] = profiles[i].plus(more) if i in profiles else more
        engine = Engine(problems)
        fit = descent.fit(engine, fit.values, fit.knobs)
        found = more_of(engine, fit, key, along, profiles)
    return engine, fit, replace(cause, profiles=profiles)


def more_of(
    engine: Engine, fit: Fit, key: str, along: str, profiles: Iterable[int]
) -> dict[int, Profile]:
    """Return what a fit leaves of profiles that are known to act, log by log."""
    found = {}
    probe = Probe(engine, fit, key, probe_size(engine, key))
    for i in profiles:
        problem = engine.problems[i]
        x = problem.coordinate(along)
        counts = (*WINDOW_COUNTS, *finer(problem))
        tried = [probe.profile(i, along, x, n) for n in counts]
        clear = [p for p in tried if p.coherence >= TIED and p.evidence > enough_of(p)]
        if clear:
            found[i] = max(clear, key=lambda p: p.evidence)
    return found
