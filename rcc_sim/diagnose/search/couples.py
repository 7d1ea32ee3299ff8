"""Two effects at once, neither of which gains without the other.

Where a loop holds the speed, a sensor that reads too little and a bearing's drag hide
each other: either alone makes speed or current fit worse, and a search that takes one
cause after the other begins with neither.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from rcc_sim.diagnose.causes.cause import ENOUGH
from rcc_sim.diagnose.fitting import descent
from rcc_sim.diagnose.fitting.engine import Engine
from rcc_sim.diagnose.fitting.fit import Fit
from rcc_sim.diagnose.fitting.without import refitted_without
from rcc_sim.diagnose.search.pursue import effect_knobs
from rcc_sim.diagnose.search.refine import Refined, handicap
from rcc_sim.diagnose.search.screen import Screened

Array = NDArray[np.float64]

APART = 0.99
"""Square of the correlation of two signals beyond which no log tells them apart."""


def coupled(engine: Engine, base: Fit, found: Sequence[Screened]) -> list[Refined]:
    """Return two effects, each with what it gains beside the other, if any two do.

    Parameters
    ----------
    engine, base
        The logs, and their fit without the two.
    found : sequence of Screened
        Candidates with the signals that the screen took of their figures.

    Returns
    -------
    list of Refined
        Both, with the fit that holds both; none where one of them is not needed, or no
        further from neutral than any model is exact.
    """
    nats, two = most_promising(base, found)
    if nats < 2 * ENOUGH:
        return []
    values = {key: x for one in two for key, x in one.values.items()}
    knobs = [k for k in base.knobs if k.key not in values]
    knobs += [k for one in two for k in effect_knobs(one)]
    now = engine.attempt(base.values | values, knobs, base.noise)
    if now is None:
        return []
    now = descent.fit(engine, now.values, now.knobs, base.noise)
    refined = []
    for one in two:
        less = refitted_without(engine, now, one.values)
        if less is None:
            return []
        gain = now.score - less.score - handicap(one, now.values)
        refined.append(Refined(one, now, gain, gain))
    return refined if all(r.reaches(ENOUGH) for r in refined) else []


def most_promising(
    base: Fit, found: Sequence[Screened]
) -> tuple[float, tuple[Screened, ...]]:
    r"""Return what two effects promise most together, and them, a figure of each.

    With signals d (whitened, beyond the knobs' reach) and what is left r,

    .. math:: x = -(D^T D)^{-1} D^T r, \quad \tfrac12 x^T D^T D x

    less what each starts behind; 0 and none if no two lie within their bounds.
    """
    sloped = [
        (r, s, r.slopes[s.key])
        for r in found
        for s in r.candidate.searches
        if s.key in r.slopes
    ]
    best: tuple[float, tuple[Screened, ...]] = (0.0, ())
    if len(sloped) < 2:
        return best
    D = np.stack([slope.signal for *_, slope in sloped])
    lean = np.array([slope.lean for *_, slope in sloped])
    G = D @ D.T
    for i, j in combinations(range(len(sloped)), 2):
        (one, a, _), (other, b, _) = sloped[i], sloped[j]
        alike = one.candidate.effect == other.candidate.effect
        if alike or G[i, j] ** 2 >= APART * G[i, i] * G[j, j]:
            continue
        step = np.linalg.solve(G[np.ix_([i, j], [i, j])], lean[[i, j]])
        values = {
            s.key: base.values.get(s.key, s.neutral) + float(x)
            for s, x in zip((a, b), step, strict=True)
        }
        if not all(s.low <= values[s.key] <= s.high for s in (a, b)):
            continue
        two = (
            replace(one, values={a.key: values[a.key]}),
            replace(other, values={b.key: values[b.key]}),
        )
        nats = 0.5 * float(lean[[i, j]] @ step)
        nats -= sum(handicap(r, values) for r in two)
        best = max(best, (nats, two), key=lambda pair: pair[0])
    return best
