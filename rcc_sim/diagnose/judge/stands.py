"""Which causes of an explanation stand beside what they leave unexplained."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from math import inf, isfinite

from rcc_sim.diagnose.causes.candidates import Candidate
from rcc_sim.diagnose.causes.cause import ENOUGH, Cause, left_by_stronger
from rcc_sim.diagnose.causes.profile import with_acting
from rcc_sim.diagnose.causes.sums import with_all_figures
from rcc_sim.diagnose.fitting import descent
from rcc_sim.diagnose.fitting.engine import Engine
from rcc_sim.diagnose.fitting.fit import Fit
from rcc_sim.diagnose.fitting.without import without
from rcc_sim.diagnose.judge.asserted import may_be_nil
from rcc_sim.diagnose.judge.ties import Rival, settled
from rcc_sim.diagnose.profiles.beside_losses import beside_losses
from rcc_sim.diagnose.profiles.remainder import (
    UNKNOWN_ENOUGH,
    Remainder,
    clearest,
    remainder,
    with_cut,
)
from rcc_sim.diagnose.residuals.sizes import size_of
from rcc_sim.diagnose.search.compete import Explanation
from rcc_sim.diagnose.search.winner import shares_of

WITHDRAWN = 0.2
"""Share of a cause's nats, by the noise that it leaves as the remainder's are, that a
remainder may have before the cause has to be needed beside it: of 201 drives of the
blind plant with something in them, ``LEAVES`` at most in the tracks of causes that
acted, 1.7 to 8.3 in those of causes that did not."""

UNSTEADY, UNSTEADY_ENOUGH = 0.1, 20.0
"""Share of a cause's nats, by the noise that it leaves, and nats, that its coming and
going over time may gain: the larger of the two beside something unknown that is real;
both together beside what chance may leave. Those by which stated figures go back with
it count twice, as when it is taken in: without it they would be off by as much.

In 139 of 143 drives of the blind plant in which what is named acts steadily nothing
unknown is real, and in all it gains 16 nats beyond its share at most. In 20 in which a
brake sticks or a drag warms up something is, and it gains 29 to 475. With the steering
what is named gains 13 nats at most in 175 such drives, and 40 to 1180 in the nine in
which a tyre rubs or a rack is not straight.
"""


@dataclass(frozen=True)
class Standing:
    """Causes that stand, and what they leave.

    Parameters
    ----------
    engine : Engine
        The logs, with the profiles of those causes acting on them.
    fit : Fit
        Tolerances and causes.
    causes : list of Cause
        Strongest first.
    left : Remainder
        What none of them explains.
    rivals : dict
        Cause -> other effects in its place, nearest first.
    """

    engine: Engine
    fit: Fit
    causes: list[Cause]
    left: Remainder
    rivals: Mapping[str, list[Rival]] = field(default_factory=dict)


def what_stands(
    engine: Engine,
    found: Explanation,
    candidates: Sequence[Candidate],
    stated: Mapping[str, float],
    told: Callable[[str], None] = lambda _: None,
) -> Standing:
    """Return the causes of an explanation that stand.

    Each acts all the time or is withdrawn, outlives what is left, keeps its place among
    its rivals, and is something beside a stronger one. With fewer all is fitted again.

    Parameters
    ----------
    engine : Engine
        The logs without any profile.
    found : Explanation
        What the competition ended with.
    candidates : sequence of Candidate
        Effects that could act.
    stated : mapping
        Dotted key -> what the vehicle file states.
    told : callable
        Called with what is being done.
    """
    with_fewer = partial(only, engine, found)
    told("what is left")
    left = left_by(found.engine, found.fit, found.causes)
    all_of = Standing(found.engine, found.fit, list(found.causes), left)
    steady = with_fewer(all_of, [c for c in all_of.causes if is_steady(c, left)])
    now = with_fewer(steady, standing(steady))
    now = replace(now, left=clearest((steady.left, now.left)))
    told("what these logs cannot tell apart")
    known = settled(now.engine, now.fit, now.causes, candidates)
    if known.fit is not now.fit:
        left = left_by(now.engine, known.fit, known.causes)
        now = replace(now, fit=known.fit, left=left)
    now = replace(now, causes=known.causes, rivals=known.rivals)
    if now.fit is not steady.fit:  # of that one it was asked
        now = with_fewer(now, standing(now))
    causes, fit = with_all_figures(now.engine, now.fit, now.causes, candidates)
    row = size_of(engine.problems[0], "row")
    effects = engine.problems[0].vehicle.known
    some = [c for c in causes[1:] if not may_be_nil(fit, c, stated, row, effects)]
    now = with_fewer(replace(now, causes=causes, fit=fit), [*causes[:1], *some])
    for cause in now.causes:
        now = replace(now, left=with_cut(now.left, now.engine, now.fit, cause))
    return now


def only(
    engine: Engine, found: Explanation, now: Standing, causes: list[Cause]
) -> Standing:
    """Return what stands with some of the causes alone, fitted again if with fewer.

    From where all stood; or, with none, from the tolerances. What is left is then that
    of this fit.
    """
    if len(causes) == len(now.causes):
        return replace(now, causes=causes)
    mine = {k for c in causes for k in c.keys}
    acting = varying_as(engine, found, causes)
    kept = [k for k in now.fit.knobs if k.key in mine or isfinite(k.sd)]
    keys = {k.key for k in kept} | mine  # what a profile holds is none of the fit's
    kept += [k for k in found.null.knobs if k.key not in keys]
    known = found.null.values | now.fit.values if causes else found.null.values
    start = {k.key: known.get(k.key, k.value) for k in kept}
    start |= {k: x for k, x in now.fit.values.items() if k in mine}  # some have no knob
    fit = descent.fit(acting, start, kept)
    left = left_by(acting, fit, causes)
    return replace(now, engine=acting, fit=fit, causes=causes, left=left)


def varying_as(engine: Engine, found: Explanation, causes: Sequence[Cause]) -> Engine:
    """Return the logs with the profiles of these causes acting, and of no other."""
    varying = [c for c in causes if c.profiles]
    if len(varying) == sum(bool(c.profiles) for c in found.causes):
        return found.engine
    for cause in varying:
        engine = with_acting(engine, cause.profiles)
    return engine


def left_by(engine: Engine, fit: Fit, causes: Sequence[Cause]) -> Remainder:
    """Return what causes that act leave, those that vary on the engine's logs."""
    left = remainder(engine, fit, constant(causes))
    return beside_losses(engine, fit, causes, left, acting=True)


def constant(causes: Sequence[Cause]) -> dict[str, tuple[str, ...]]:
    """Return the figures of the causes that were taken as constant, by effect."""
    return {c.effect: c.keys for c in causes if not c.profiles}


def standing(now: Standing) -> list[Cause]:
    """Return the causes that what they leave does not dwarf."""
    engine, fit, left = now.engine, now.fit, now.left
    causes = [
        c
        if c.profiles
        else replace(c, shares=shares_of(engine, fit, c.keys, fit.noise))
        for c in now.causes
    ]
    spared = [left_by_stronger(c, causes) for c in causes]
    return [
        c
        for c, nats in zip(causes, spared, strict=True)
        if is_steady(c, left) and outlives(engine, c, left, fit, nats)
    ]


def is_steady(cause: Cause, left: Remainder) -> bool:
    """Tell whether a cause that was taken as constant acts all the time."""
    share = UNSTEADY * cause.trusted
    some = (share, UNSTEADY_ENOUGH)
    most = max(some) if left.is_real else sum(some)
    return left.change_of(cause.effect) <= most


def outlives(
    engine: Engine, cause: Cause, left: Remainder, fit: Fit, spared: float = 0.0
) -> bool:
    """Tell whether a cause stands beside something unknown in its tracks.

    Where that is small beside it, or may be left by chance and is no likelier, or by
    stronger causes, of which so many nats are ``spared``. Else if it is needed beside
    that, too; but not where what is real outweighs it, or would be real whatever it
    follows. Stated figures that go back count against what chance may leave, which lets
    none go.
    """
    nats = left.against(cause.effect, cause.shares) - spared
    gain = cause.sharp if left.is_real else cause.trusted
    if nats <= (WITHDRAWN * gain if left.is_real else max(gain, ENOUGH)):
        return True
    if cause.profiles or (left.is_real and nats > min(gain, UNKNOWN_ENOUGH)):
        return False
    return nats_beside(engine, cause, left, fit) >= ENOUGH


def nats_beside(engine: Engine, cause: Cause, left: Remainder, fit: Fit) -> float:
    """Nats that a constant cause gains where something unknown acts with and without.

    Of a rough road there is as much either way, and it says nothing about the cause.
    With s the scores by the noise that the cause leaves, p the nats of stated figures
    in them and u those of what is left in its tracks: (s + p + u) - (s' + p' + u'), the
    dashed ones without it.
    """
    less = without(engine, fit, cause.keys)
    if less is None:
        return inf
    less = descent.improved(engine, less, descent.ROUNDS)
    other = replace(remainder(engine, less), apart=left.apart)
    u, v = (r.against(cause.effect, cause.shares) for r in (left, other))
    return fit.score + fit.prior - less.score - less.prior + u - v
