"""Candidates around a fit, refined: by the noise before them and by that after."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from math import inf

import numpy as np
from numpy.typing import NDArray

from rcc_sim.diagnose.causes.cause import TIED
from rcc_sim.diagnose.fitting import descent
from rcc_sim.diagnose.fitting.engine import Engine
from rcc_sim.diagnose.fitting.fit import Fit, Tangent
from rcc_sim.diagnose.fitting.pulls import pulled
from rcc_sim.diagnose.search.pursue import (
    ANEW,
    STEPS,
    effect_knobs,
    from_nothing,
    pursued,
    with_effect,
)
from rcc_sim.diagnose.search.screen import Screened
from rcc_sim.diagnose.search.starts import FAR_BEHIND, afresh, likely
from rcc_sim.side_by_side import each

Array = NDArray[np.float64]

HOPELESS = 0.3
"""Share of what is needed below which no screened gain is worth refining."""

LESS_LIKELY = {"iron_loss": 4.0, "throttle_gain": 4.0}
"""Nats that an effect starts behind: one of two figures that do as another effect, or
one that does, where a throttle hardly changes, what its dead zone does."""

NEARLY = 0.98
"""Share of the best's nats that a plainer effect must gain to go first."""

AWAY = 2.5
"""Standard deviations that stated figures have moved from which on one of them may
stand for a part of a cause, and another for the rest."""

CLEAR = 100.0
"""Nats that a cause must gain that acts in one or two stretches alone."""

ODD = 2
"""Stretches that are left out to either side before a gain counts as steady.

Wherever a loop leaves a limit a moment sooner than the model's, whatever figure moves
that moment gains tens of nats at once: no cause, but a figure a little off.
"""


@dataclass(frozen=True)
class Refined:
    """A candidate refined.

    Parameters
    ----------
    screened : Screened
        The candidate and its figures.
    fit : Fit
        The logs' fit with it.
    before, after : float
        Nats gained, by the noise before it and by the noise after it.
    eased : float
        Nats of them by which figures of the file went back to what is stated.
    steady : float
        Nats gained outside the stretches in which it does best and worst.
    beyond : float
        Nats gained beyond those of the least strength that may be told.
    """

    screened: Screened
    fit: Fit
    before: float
    after: float
    eased: float = 0.0
    steady: float = inf
    beyond: float = inf

    @property
    def gain(self) -> float:
        """Nats that hold by either noise."""
        return min(self.before, self.after)

    @property
    def trusted(self) -> float:
        """Nats, those of stated figures twice: no error of a model is in them.

        A figure four sds off is one in sixteen thousand, for eight nats.
        """
        return self.gain + max(self.eased, 0.0)

    @property
    def matters(self) -> bool:
        """Whether any of its figures is farther from neutral than a model is exact."""
        searches = {s.key: s for s in self.screened.candidate.searches}
        return any(
            abs(self.fit.values[k] - searches[k].neutral) > searches[k].least
            for k in self.screened.values
        )

    def reaches(self, needed: float) -> bool:
        """Tell whether it gains what is needed, and all over the logs."""
        if not self.matters or self.beyond < needed:
            return False
        even = self.steady + 2 * max(self.eased, 0.0)
        return self.trusted >= needed and (self.gain > CLEAR or even >= needed)


def contenders(
    engine: Engine,
    base: Fit,
    found: Sequence[tuple[Screened, Fit]],
    needed: float,
) -> list[Refined]:
    """Refine what is worth it after the screen; best first.

    If nothing keeps what the screen promised, also what only seemed far behind: a
    threshold or a clock that promises by chance, and gains nothing once it is refined,
    is no measure for the others. And from the figures that the file states, if what
    does best beside tolerances that were pulled does not let them go.
    """
    tried = likely(found, HOPELESS * needed)
    refined = refine(engine, base, tried, needed)
    if not any(r.reaches(needed) for r in refined):
        most = max((r.before for r in refined), default=0.0)
        masked = likely(found[len(tried) :], HOPELESS * needed, most)
        refined = [*refined, *refine(engine, base, masked, needed)]
    if pulled(base, AWAY) and not lets_go(refined, needed):
        again = afresh(engine, base, [r for r, _ in found])
        refined = [*refined, *refine(engine, base, again, needed)]
    return ranked(refined)


def lets_go(refined: Sequence[Refined], needed: float) -> bool:
    """Tell whether the best is worth it, and what stood in for it is back.

    Of 105 times that candidates were sought beside the stated figures, in 116 drives,
    another came out best in none.
    """
    best = max(refined, key=lambda r: r.gain, default=None)
    return best is not None and best.reaches(needed) and not pulled(best.fit, AWAY)


def refine(
    engine: Engine,
    base: Fit,
    found: Sequence[tuple[Screened, Fit]],
    needed: float = 0.0,
) -> list[Refined]:
    """Refine candidates, by the noise of the base and by that of the best; best first.

    The noise that the base leaves holds what it misses; that of the best candidate
    shows the others in a sharper light. A gain counts if it holds by both; where none
    by the first comes near what is needed, it is not asked for the second.
    """
    found = [(r, start) for r, start in found if r.gain > 1]
    if not found:
        return []
    signals = {id(start.signals): start.signals for _, start in found}
    along = {i: engine.whitened(J, base.noise) for i, J in signals.items()}

    def one(pair: tuple[Screened, Fit]) -> Fit | None:
        r, start = pair
        fit = with_effect(engine, start, r, base.noise, along[id(start.signals)])
        if fit is None or fit.score >= start.score or r.gain < needed:
            return fit
        return from_nothing(engine, start, r, fit)

    fits = each(one, found)
    every = []
    for (r, _), fit in zip(found, fits, strict=True):
        if fit is None:
            continue
        every.append(beside(base, r, fit))
    best = max(every, key=lambda r: r.before, default=None)
    if best is None or best.before <= 0:
        return []
    close = [r for r in every if r.before > FAR_BEHIND * best.before]
    if any(r.trusted + max(r.eased, TIED) >= needed for r in close):
        close = by_its_noise(engine, base, close, best)
    return ranked(close)


def beside(base: Fit, screened: Screened, fit: Fit) -> Refined:
    """Return a candidate with its fit, and what that gains over a base by its noise."""
    moved = replace(screened, values={k: fit.values[k] for k in screened.values})
    gain = fit.score - base.score - handicap(screened, fit.values)
    return Refined(moved, fit, gain, gain, fit.prior - base.prior)


def ranked(refined: Sequence[Refined]) -> list[Refined]:
    """Return refined candidates, best first, each effect once, the plainest first."""
    close = sorted(refined, key=lambda r: -r.gain)
    names = [r.screened.candidate.effect for r in close]
    return plainest_first([r for i, r in enumerate(close) if names[i] not in names[:i]])


def handicap(screened: Screened, values: Mapping[str, float]) -> float:
    """Nats that an effect starts behind, and those that its strength costs."""
    one = screened.candidate
    less = LESS_LIKELY.get(one.effect, 0.0)
    return less + one.price(values, screened.values)


def beyond_least(engine: Engine, base: Fit, found: Refined, along: Tangent) -> float:
    """Nats that a candidate gains beyond the least strength that may be told.

    The acceleration of an imposed drive is smeared over a row or two: what a delay of
    as many gains there, or a slip that comes to one, it gains by smoothing, and by any
    longer one as well. Judged by the noise of the base, which is to be that of the fit.
    """
    weakest = {s.key: s.weakest for s in found.screened.candidate.searches}
    held = {k: x for k in found.screened.values if (x := weakest[k]) is not None}
    if not (held and engine.problems[0].drive.imposed):
        return inf
    knobs = [k for k in base.knobs if k.key not in held]
    gone = [i for i, k in enumerate(base.knobs) if k.key in held]
    least = engine.attempt(found.fit.values | held, knobs, base.noise)
    if least is None:
        return inf
    least = descent.improve(
        engine, least, along=along.but(gone), fixed=True, rounds=STEPS
    )
    return found.fit.score - least.score


def by_its_noise(
    engine: Engine, base: Fit, found: Sequence[Refined], best: Refined
) -> list[Refined]:
    """Refine candidates on, by the noise that the best of them leaves."""
    noise = engine.learn_noise(best.fit.residuals)
    along = engine.whitened(base.signals, noise)
    again = engine.judged(base, noise)
    again = descent.improve(engine, again, along=along, fixed=True, rounds=3)

    def one(r: Refined) -> Refined:
        # of a gain that holds, how far beyond matters of the best alone
        holds = again.score + r.before + handicap(r.screened, r.fit.values)
        enough = inf if r is best else holds
        fit = engine.judged(r.fit, noise)
        if fit.score < enough:
            keys = {k.key for k in effect_knobs(r.screened)}
            others = zip(fit.signals, fit.knobs, strict=True)
            kept = engine.whitened([J for J, k in others if k.key not in keys], noise)
            fit = pursued(engine, fit, keys, kept, enough)
        if r is best and fit.score < holds:
            # its signals have bent on the way: find them anew
            fit = descent.improve(engine, fit, rounds=ANEW)
        after = fit.score - again.score - handicap(r.screened, fit.values)
        even = steady(engine.gains(again, fit))
        eased = fit.prior - again.prior
        done = replace(r, fit=fit, after=after, eased=eased, steady=even)
        return replace(done, beyond=beyond_least(engine, again, done, along))

    return each(one, found)


def steady(gains: Array) -> float:
    """Sum of what stretches gain, but for the best and the worst of them."""
    return float(np.sort(gains)[ODD:-ODD].sum())


def plainest_first(refined: list[Refined]) -> list[Refined]:
    """Put the best of the plainer effects first, if it gains nearly what the best does.

    Nearly is two percent, and what two effects alike may differ by.
    """
    if not refined or refined[0].screened.candidate.effect not in LESS_LIKELY:
        return refined
    least = NEARLY * refined[0].gain - TIED
    for i, r in enumerate(refined):
        if r.screened.candidate.effect not in LESS_LIKELY and r.gain > least:
            return [r, *refined[:i], *refined[i + 1 :]]
    return refined
