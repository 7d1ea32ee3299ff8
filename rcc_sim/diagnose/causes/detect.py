"""What a log could have shown: the least strength of each effect that it would tell."""

from __future__ import annotations

from collections.abc import Sequence
from math import inf, isfinite, sqrt
from typing import NamedTuple

from rcc_sim.diagnose.causes.sought import Search


class Shown(NamedTuple):
    """What a log would show of a figure of some strength.

    Attributes
    ----------
    strength : float
        [the figure's unit]
    nats : float
        |s|²/2, s being what it would change in the log, whitened, beyond the reach of
        the tolerances.
    """

    strength: float
    nats: float


def least_seen(search: Search, tried: Sequence[Shown], enough: float) -> float | None:
    """Return the least strength of a figure that a log would tell, if it tells any.

    What a change of it shows grows as its square. A figure with a grid is only told
    between the strengths tried; any other by that law, up to the largest that is usual.

    Parameters
    ----------
    search : Search
        The figure.
    tried : sequence of Shown
        Strengths that were simulated.
    enough : float
        Nats that a cause needs.

    Returns
    -------
    float or None
        Change from what the file states; of a limit, the highest that would show. [the
        figure's unit]
    """
    if search.neutral == inf:
        return max((s.strength for s in tried if s.nats >= enough), default=None)
    changes = sorted((abs(s.strength - search.neutral), s.nats) for s in tried)
    change, nats = 0.0, 0.0
    for next_change, next_nats in changes:
        if next_nats >= enough:
            share = (sqrt(enough) - sqrt(nats)) / (sqrt(next_nats) - sqrt(nats))
            return change + share * (next_change - change)
        if next_nats > nats:
            change, nats = next_change, next_nats
    if search.grid or nats <= 0:
        return None
    change *= sqrt(enough / nats)
    return change if change <= search.most else None


def shows_likely(search: Search, least: float | None) -> bool:
    """Tell whether a log would tell a figure at the strength that is likeliest.

    Parameters
    ----------
    search : Search
        The figure.
    least : float or None
        As by :func:`least_seen`.
    """
    if least is None or not isfinite(search.neutral):
        return least is not None
    return least <= search.likely
