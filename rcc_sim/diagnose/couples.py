"""Two effects at once, neither of which gains without the other.

Where a loop holds the speed, a sensor that reads too little and a bearing's drag hide
each other: either alone makes speed or current fit worse, and a search that takes one
cause after the other begins with neither.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from rcc_sim.diagnose import descent
from rcc_sim.diagnose.cause import ENOUGH
from rcc_sim.diagnose.engine import Engine
from rcc_sim.diagnose.fit import Fit
from rcc_sim.diagnose.refine import LESS_LIKELY, effect_knobs
from rcc_sim.diagnose.screen import Screened

Array = NDArray[np.float64]

APART = 0.99
"""Square of the correlation of two signals beyond which no log tells them apart."""


class Couple(NamedTuple):
    """Two effects, each at a strength that the signals of both ask for.

    Parameters
    ----------
    nats : float
        What they promise together, less their prices.
    effects : tuple of str
        Their ids.
    values : dict
        A figure of each, in the same order -> its strength.
    """

    nats: float
    effects: tuple[str, str]
    values: dict[str, float]


def coupled(
    engine: Engine, base: Fit, found: Sequence[Screened]
) -> tuple[Fit, dict[str, tuple[str, float]]] | None:
    """Return a fit with two effects and what each gains beside the other, if any do.

    Parameters
    ----------
    engine, base
        The logs, and their fit without the two.
    found : sequence of Screened
        Candidates with the signals that the screen took of their figures.

    Returns
    -------
    fit, gains
        The fit, and effect -> dotted key and nats; None where one of them is not
        needed, or no further from neutral than any model is exact.
    """
    found = [r for r in found if r.slopes]  # each once, as the screen left it
    best = most_promising(base, found)
    if best is None or best.nats < 2 * ENOUGH:
        return None
    searches = {s.key: s for r in found for s in r.candidate.searches}
    mine = [k for r in found for k in effect_knobs(with_values(r, best.values))]
    knobs = [*(k for k in base.knobs if k.key not in best.values), *mine]
    now = engine.attempt(base.values | best.values, knobs, base.noise)
    if now is None:
        return None
    now = descent.fit(engine, now.values, now.knobs, base.noise)
    gains: dict[str, tuple[str, float]] = {}
    for effect, key in zip(best.effects, best.values, strict=True):
        less = descent.under_its_noise(engine, now.without([key]))
        far = abs(now.values[key] - searches[key].neutral) > searches[key].least
        price = searches[key].price(now.values[key]) + LESS_LIKELY.get(effect, 0.0)
        if less is None or not far or now.score - less.score - price < ENOUGH:
            return None
        gains[effect] = (key, now.score - less.score - price)
    return now, gains


def with_values(screened: Screened, values: dict[str, float]) -> Screened:
    """Return a candidate with those of some strengths that are its own."""
    own = {s.key for s in screened.candidate.searches}
    mine = {k: x for k, x in values.items() if k in own}
    return Screened(screened.candidate, 0.0, mine)


def most_promising(base: Fit, found: Sequence[Screened]) -> Couple | None:
    r"""Return the two figures whose signals together promise most.

    With signals d (whitened, beyond the knobs' reach) and what is left r,

    .. math:: x = -(D^T D)^{-1} D^T r, \quad \tfrac12 x^T D^T D x

    less the price of each strength; None if no two lie within their bounds.
    """
    sloped = [
        (r.candidate.effect, s, r.slopes[s.key])
        for r in found
        for s in r.candidate.searches
        if s.key in r.slopes
    ]
    if len(sloped) < 2:
        return None
    D = np.stack([slope.signal for *_, slope in sloped])
    lean = np.array([slope.lean for *_, slope in sloped])
    G = D @ D.T
    best: Couple | None = None
    for i, j in combinations(range(len(sloped)), 2):
        (one, a, _), (other, b, _) = sloped[i], sloped[j]
        if one == other or G[i, j] ** 2 >= APART * G[i, i] * G[j, j]:
            continue
        step = np.linalg.solve(G[np.ix_([i, j], [i, j])], lean[[i, j]])
        values = {
            s.key: base.values.get(s.key, s.neutral) + float(x)
            for s, x in zip((a, b), step, strict=True)
        }
        if not all(s.low <= values[s.key] <= s.high for s in (a, b)):
            continue
        prices = sum(s.price(values[s.key]) for s in (a, b))
        behind = sum(LESS_LIKELY.get(effect, 0.0) for effect in (one, other))
        nats = 0.5 * float(lean[[i, j]] @ step) - prices - behind
        if best is None or nats > best.nats:
            best = Couple(nats, (one, other), values)
    return best
