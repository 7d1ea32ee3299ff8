"""How sure a cause is."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import exp, inf

from rcc_sim.diagnose.causes.cause import (
    ANOTHER_VEHICLE,
    DRAGS,
    ENOUGH,
    Cause,
    left_by_stronger,
)
from rcc_sim.diagnose.fitting.fit import Fit
from rcc_sim.diagnose.profiles.remainder import Remainder
from rcc_sim.physics.effect import Effect

LEAST_SURE, EVEN, SUREST = 0.01, 0.5, 0.995
"""Least and largest probability that is stated: nats are surer than any model; and the
largest of a cause that needs another vehicle."""

SOFT = 4.0
"""Nats by which odds grow by e: model error blunts a likelihood by about so much."""

EQUAL = 1.0
"""Nats within which two are equally likely."""


def chances_of(
    causes: Sequence[Cause],
    left: Remainder,
    farthest: float,
    doubtful: Sequence[bool],
) -> list[float]:
    """Return the probability of each cause; of a ``doubtful`` one even at most.

    A drag is no surer than a hill, or a wind, that it stands beside: if that is another
    drag that changes, this one may be no more than what the two do not share.
    """
    chances = [
        probability(
            c, left, farthest, doubtful=doubt, spared=left_by_stronger(c, causes)
        )
        for c, doubt in zip(causes, doubtful, strict=True)
    ]
    both = [*zip(causes, chances, strict=True)]
    least = min((x for c, x in both if c.profiles and c.effect in DRAGS), default=1.0)
    return [
        min(x, least) if c.effect in DRAGS and not c.profiles else x for c, x in both
    ]


def probability(
    cause: Cause,
    left: Remainder,
    farthest: float = 0.0,
    *,
    doubtful: bool = False,
    spared: float = 0.0,
) -> float:
    """Return the probability that a cause, or one tied with it, acts.

    An even chance at most where it is ``doubtful``, as where it ends as its search
    does, or beside stated figures that are ``farthest`` off by as many sds as another
    vehicle's: one of them stands for what is not known. Of what is left so many nats
    are ``spared``, that stronger causes may leave. Nats by which stated figures go back
    count twice against no effect at all, as where it was taken in.
    """
    clear = cause.gain - cause.rival if cause.rival else inf  # no other gains a nat
    margin = min(cause.gain + cause.eased - 0.5 * ENOUGH, clear)
    if abs(margin) < EQUAL:
        margin = 0.0
    chance = 1 / (1 + exp(-min(margin, 200.0) / SOFT))
    if cause.profiles:  # something unknown of the same course is no likelier
        chance = max(chance, EVEN)
    if left.is_real:
        unknown = max(left.against(cause.effect, cause.shares) - spared, 0.0)
        chance *= cause.gain / (cause.gain + unknown)
    most = EVEN if doubtful or farthest > ANOTHER_VEHICLE else SUREST
    return min(max(chance, LEAST_SURE), most)


def ends_early(cause: Cause, fit: Fit, known: Mapping[str, Effect]) -> bool:
    """Tell whether a figure ends where its search does, short of the effect's bounds.

    What asks for more is not that figure.
    """
    for knob in (k for k in fit.knobs if k.key in cause.keys):
        _, effect, name = knob.key.split(".")
        x = fit.values[knob.key]
        if x in (knob.low, knob.high) and x not in known[effect].param(name).bounds:
            return True
    return False
