"""Whether a cause that varies stands beside an efficiency that varies as well."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from rcc_sim.diagnose.causes.cause import ENOUGH, Cause
from rcc_sim.diagnose.causes.profile import Profile
from rcc_sim.diagnose.causes.strengths import prior_of, windows
from rcc_sim.diagnose.fitting.engine import Engine
from rcc_sim.diagnose.fitting.fit import Fit
from rcc_sim.diagnose.profiles.forms import EFFICIENT
from rcc_sim.diagnose.profiles.probe import Probe
from rcc_sim.diagnose.profiles.remainder import Remainder
from rcc_sim.diagnose.profiles.varying import held

MOSTLY = 0.5
"""Share of what a course gains that it must gain beside the other, too."""


def beside_losses(
    engine: Engine,
    fit: Fit,
    causes: Sequence[Cause],
    left: Remainder,
    *,
    acting: bool,
) -> Remainder:
    """Return what is left, with the effects that stand beside an efficiency in it.

    What a motor loses goes by its torque, or its speed, and neither goes by the hour:
    a course over time or distance and that may both be there. It stands if it gains
    most of its nats, and as many as a cause must, where the efficiency may take its
    part as well. ``acting``: the courses act on the engine's logs already.
    """
    losses = [r.profile for r in left.rivals if r.acts_as == EFFICIENT and r.profile]
    stand = {
        c.effect
        for c in causes
        if c.profiles and losses and stands_beside(engine, fit, c, losses, acting)
    }
    return replace(left, apart=frozenset(stand))


def stands_beside(
    engine: Engine, fit: Fit, cause: Cause, losses: Sequence[Profile], acting: bool
) -> bool:
    """Tell whether a cause's courses gain most of their nats beside any of some."""
    key = cause.keys[0]
    alone = Probe(engine, held(fit, key), key)
    if acting:
        alone = alone.as_if_none(cause.profiles)
    least = max(ENOUGH, MOSTLY * nats_of(alone, cause))
    return all(nats_of(alone.giving_way(p), cause) >= least for p in losses)


def nats_of(probe: Probe, cause: Cause) -> float:
    """Nats of courses at the knots of those of a cause."""
    nats = 0.0
    for i, p in cause.profiles.items():
        if not probe.shows_in(i):
            continue
        H = windows(probe.engine.problems[i].coordinate(p.along), p.knots)
        prior = prior_of(p.key, p.along, p.knots)
        if p.weighed:
            nats += probe.beside_noise(i, H, prior.shape).evidence
        else:
            nats += probe.evidence(i, H, prior.shape)
    return nats
