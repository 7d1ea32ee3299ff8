"""Which causes of a fit stand beside what it leaves unexplained."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from math import inf

from rcc_sim.diagnose import descent
from rcc_sim.diagnose.cause import ENOUGH, Cause
from rcc_sim.diagnose.engine import Engine
from rcc_sim.diagnose.fit import Fit
from rcc_sim.diagnose.remainder import UNKNOWN_ENOUGH, Remainder, remainder
from rcc_sim.diagnose.winner import shares_of

WITHDRAWN = 0.2
"""Share of a cause's nats, by the noise that it leaves as the remainder's are, that a
remainder may have before the cause has to be needed beside it: of 201 drives of the
blind plant with something in them, 0.03 at most in the tracks of causes that acted, 1.7
to 8.3 in those of causes that did not."""

UNSTEADY, UNSTEADY_ENOUGH = 0.1, 20.0
"""Share of a cause's nats, by the noise that it leaves, and nats, that its coming and
going over time may gain: the larger of the two beside something unknown that is real;
both together beside what chance may leave.

In 139 of 143 drives of the blind plant in which what is named acts steadily nothing
unknown is real, and in all it gains 16 nats beyond its share at most. In 20 in which a
brake sticks or a drag warms up something is, and it gains 29 to 475. With the steering
what is named gains 13 nats at most in 175 such drives, and 40 to 1180 in the nine in
which a tyre rubs or a rack is not straight.
"""


def standing(
    engine: Engine, causes: Sequence[Cause], left: Remainder, fit: Fit
) -> list[Cause]:
    """Return the causes of a fit that what is left does not dwarf."""
    now = [
        c
        if c.profiles
        else replace(c, shares=shares_of(engine, fit, c.keys, fit.noise))
        for c in causes
    ]
    return [c for c in now if is_steady(c, left) and outlives(engine, c, left, fit)]


def is_steady(cause: Cause, left: Remainder) -> bool:
    """Tell whether a cause that was taken as constant acts all the time."""
    share = UNSTEADY * cause.gain * cause.sharpened
    some = (share, UNSTEADY_ENOUGH)
    most = max(some) if left.is_real else sum(some)
    return left.change_of(cause.effect) <= most


def outlives(engine: Engine, cause: Cause, left: Remainder, fit: Fit) -> bool:
    """Tell whether a cause stands beside something unknown in its tracks.

    Where that is small beside it, or may be left by chance and is no likelier. Else if
    it is needed beside that, too; but not where what is real outweighs it, or would be
    real whatever it follows.
    """
    nats, gain = left.against(cause.effect, cause.shares), cause.gain * cause.sharpened
    if nats <= (WITHDRAWN * gain if left.is_real else max(gain, ENOUGH)):
        return True
    if cause.profiles or (left.is_real and nats > min(gain, UNKNOWN_ENOUGH)):
        return False
    return nats_beside(engine, cause, left, fit) >= ENOUGH


def nats_beside(engine: Engine, cause: Cause, left: Remainder, fit: Fit) -> float:
    """Nats that a constant cause gains where something unknown acts with and without.

    Of a rough road there is as much either way, and it says nothing about the cause.
    With s the scores by the noise that the cause leaves, and u the nats of what is left
    in its tracks: (s + u) - (s' + u'), the dashed ones without it.
    """
    bare = fit.without(cause.keys)
    less = engine.attempt(bare.values, bare.knobs, fit.noise)
    if less is None:
        return inf
    less = descent.improved(engine, replace(less, signals=bare.signals), descent.ROUNDS)
    u, v = (
        r.against(cause.effect, cause.shares) for r in (left, remainder(engine, less))
    )
    return fit.score - less.score + u - v
