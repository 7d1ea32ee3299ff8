"""How much likelier a hill, or a wind, is than anything else of the same course."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from rcc_sim.diagnose.causes.candidates import has_needs
from rcc_sim.diagnose.causes.cause import ENOUGH, PROFILES, Cause
from rcc_sim.diagnose.fitting.engine import Engine
from rcc_sim.diagnose.fitting.fit import Fit
from rcc_sim.diagnose.profiles.forms import DRAG_OVER_TIME, FOLLOWS, carrier_of
from rcc_sim.diagnose.profiles.gusts import COUNTS, WIND, nats_of_gusts
from rcc_sim.diagnose.profiles.hidden_hill import HILL
from rcc_sim.diagnose.profiles.probe import Probe
from rcc_sim.diagnose.profiles.remainder import Remainder
from rcc_sim.diagnose.profiles.switched import LOAD
from rcc_sim.diagnose.profiles.varying import WINDOW_COUNTS, every_count, held
from rcc_sim.diagnose.residuals.shapes import FELT
from rcc_sim.physics.effects import EFFECTS
from rcc_sim.side_by_side import each


def beside_a_drag(engine: Engine, fit: Fit, cause: Cause, left: Remainder) -> Cause:
    """Return a hill, or a wind, with the nats of what may be in its place.

    That is a drag over time, a load, and in the place of a hill a wind as well: by
    motion and power alone they differ in what they run along. Where the noise of the
    fit leaves a doubt, each is weighed together with the noise that it leaves itself:
    the fit's holds the hill, and with it what an accelerometer felt. Of nine drives
    over hills, two measured ones among them, the hill is 13 nats likelier in the
    closest. Without an accelerometer that comes of what their courses happen to make
    of a course that suits all of them: the more doubtful of both counts. One that was
    hidden has been weighed so.
    """
    if cause.effect not in (HILL, WIND) or cause.weighed:
        return cause
    drags = [r for r in left.rivals if (r.acts_as, r.follows) == DRAG_OVER_TIME]
    wind = nats_of_gusts(engine, fit) if cause.effect == HILL else 0.0
    rival = max([cause.rival, wind, *(r.evidence for r in drags)])
    if cause.gain - rival < ENOUGH:
        counts = sorted({len(p.knots) for p in cause.profiles.values()})
        name, along = DRAG_OVER_TIME
        every = [
            (*PROFILES[cause.effect], counts),
            (carrier_of(engine, fit, name), along, FOLLOWS[along]),
        ]
        if wind:
            every.append((*PROFILES[WIND], COUNTS))
        if has_needs(engine.vehicle, EFFECTS[LOAD]):
            every.append((*PROFILES[LOAD], WINDOW_COUNTS))
        own, *others = each(lambda one: with_own_noise(engine, fit, *one), every)
        felt = any(FELT in p.channels for p in engine.problems)
        rival = max(cause.gain - own + max(others), 0.0 if felt else rival)
    return replace(cause, rival=rival)


def with_own_noise(
    engine: Engine, fit: Fit, key: str, along: str, counts: Sequence[int]
) -> float:
    """Nats of a figure's likeliest courses, each together with the noise it leaves.

    ``counts`` are the numbers of windows in which they are found, by the fit's noise.
    """
    probe, nats = Probe(engine, held(fit, key), key), 0.0
    for i, problem in enumerate(engine.problems):
        x = problem.coordinate(along)
        tried = [probe.profile(i, along, x, n) for n in counts]
        best = max(tried, key=lambda p: p.evidence)
        _, sharp = probe.sharpest(best, i, x, every_count(problem))
        nats += max(sharp, 0.0)
    return nats
