"""Candidates around a fit: screened, and the best of them refined."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from math import inf

import numpy as np
from numpy.typing import NDArray

from rcc_sim.diagnose import descent
from rcc_sim.diagnose.candidates import Candidate
from rcc_sim.diagnose.descent import MUCH, SETTLED
from rcc_sim.diagnose.engine import Engine
from rcc_sim.diagnose.fit import Fit, Tangent
from rcc_sim.diagnose.knobs import BIAS, Knob
from rcc_sim.diagnose.noise import Whitener
from rcc_sim.diagnose.screen import Screen, Screened

Array = NDArray[np.float64]

REFINED = 6
"""Candidates that are refined after the screen."""

AFRESH = 10
"""Candidates that are screened once more beside the figures that the file states."""

FAR_BEHIND = 0.2
"""Share of the best gain below which a candidate is not refined."""

HOPELESS = 0.3
"""Share of what is needed below which no screened gain is worth refining."""

TIED = 3.0
"""Nats below which two candidates cannot be told apart: odds of 20 to 1 (Jeffreys'
"strong" begins there)."""

LESS_LIKELY = {"iron_loss": 4.0}
"""Nats that an effect starts behind: one of two figures that do as another effect."""

TOO_FAR = 3.0
"""Standard deviations beyond which a tolerance that is pulled stands for a cause."""

AWAY = 2.5
"""Those beyond which one may stand for a part of a cause, and another for the rest."""

PROMISING, FOLLOWED = 18.0, 2
"""Nats that a slope must promise for a candidate to be followed along its curve; and
how many are, those that promise most."""

CLEAR = 100.0
"""Nats that a cause must gain that acts in one or two stretches alone."""

STEPS, ANEW = 6, 4
"""Steps of a candidate along the signals of the base, and rounds with signals found
anew where it has not settled by then."""

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


def screened(
    engine: Engine, fit: Fit, candidates: Sequence[Candidate]
) -> list[tuple[Screened, Fit]]:
    """Screen candidates around a fit; best first, each with where to refine from."""
    screen = Screen(engine, fit)
    found = [(r, fit) for r in engine.each(screen.best, candidates)]
    found += released(engine, fit, candidates)
    found += bent(engine, fit, [r for r, _ in found])
    return sorted(found, key=lambda pair: -pair[0].gain)


def released(
    engine: Engine, fit: Fit, candidates: Sequence[Candidate]
) -> list[tuple[Screened, Fit]]:
    """Candidates in place of tolerances that were pulled too far.

    A figure that is far from what the file states is an effect that acts on it: the
    figure goes back and the effect takes its part over. One that is the effect's own,
    as a motor's lag or a rolling resistance, stays where it is: no strength on a grid
    comes nearer, and no slope tells that its tolerance is what holds it.
    """
    sought = {s.key: (c, s) for c in candidates for s in c.searches}
    pulls = pulled(fit, TOO_FAR)
    found = []
    for key, (candidate, _) in sought.items():
        if key in pulls:
            one = Screened(candidate, 0.5 * pulls[key] ** 2, {key: fit.values[key]})
            found.append((one, fit))
    knobs = {k.key: k for k in fit.knobs if k.key in pulls}
    for key, (candidate, search) in sought.items():
        knob = knobs.get(search.same_as)
        if knob is None:
            continue
        now, pull = fit.values[knob.key], pulls[knob.key]
        much = now / knob.value if search.acts == "factor" else now - knob.value
        values = {key: min(max(much, search.low), search.high)}
        start = engine.attempt(
            fit.values | values | {knob.key: knob.value}, fit.knobs, fit.noise
        )
        if start is None:
            continue
        start = replace(start, signals=fit.signals, information=fit.information)
        found.append((Screened(candidate, 0.5 * pull**2, values), start))
    return found


def pulled(fit: Fit, far: float) -> dict[str, float]:
    """Tolerances of the file that were pulled farther -> by how many sds."""
    pulls = {k.key: (fit.values[k.key] - k.value) / k.sd for k in fit.knobs}
    return {key: pull for key, pull in pulls.items() if abs(pull) > far}


def bent(
    engine: Engine, fit: Fit, found: Sequence[Screened]
) -> list[tuple[Screened, Fit]]:
    """Candidates whose slope promises far more than any strength gained, followed.

    Tolerances that stand in for an effect must go back as it grows. Over so long a way
    their signals are no straight lines, by which alone the screen lets them move. A
    strength of a grid, as that of a delay, may lie in a hollow of its own.
    """
    least = max([PROMISING, *(r.gain for r in found)])
    gained = {r.candidate.effect: r.gain for r in sorted(found, key=lambda r: r.gain)}
    worth = [
        r for r in found if r.promised.nats > max(least, 2 * gained[r.candidate.effect])
    ]
    pairs: list[tuple[Screened, Fit]] = []
    for r in sorted(worth, key=lambda r: -r.promised.nats)[:FOLLOWED]:
        most, key, x = r.promised
        if any(most < moved.gain for moved, _ in pairs):
            break  # what did better than this promises may well be its twin
        mine = effect_knobs(replace(r, values={key: x}))
        knobs = [k for k in fit.knobs if k.key != key] + mine
        start = engine.attempt(fit.values | {key: x}, knobs, fit.noise)
        if start is None:
            continue
        search = next(s for s in r.candidate.searches if s.key == key)
        if search.acts == "rows":
            now = descent.climbed(engine, start, mine[0], search.grid)
        else:
            now = descent.followed(engine, start, key)
        values = {key: now.values[key]}
        kept = {n: getattr(fit, n) for n in ("knobs", "signals", "information")}
        moved = Screened(r.candidate, now.score - fit.score, values)
        pairs.append((moved, replace(now, **kept)))
    return pairs


def afresh(
    engine: Engine, fit: Fit, found: Sequence[Screened]
) -> list[tuple[Screened, Fit]]:
    """The likeliest candidates once more, beside the figures that the file states.

    Tolerances that stand in for an effect have gone a long way, over thresholds and
    limits, and need not find back as it grows.
    """
    stated = {k.key: k.value for k in fit.knobs if k.sd < inf and BIAS not in k.key}
    start = engine.attempt(fit.values | stated, fit.knobs, fit.noise)
    if start is None:
        return []
    start = replace(start, signals=engine.signals(start.values, start.knobs))
    first = sorted(found, key=lambda r: -max(r.gain, r.promised.nats))
    named = {r.candidate.effect: r.candidate for r in first}
    again = engine.each(Screen(engine, start).best, list(named.values())[:AFRESH])
    along = engine.whitened(start.signals, fit.noise)

    def one(r: Screened) -> tuple[Screened, Fit] | None:
        now = with_effect(engine, start, r, fit.noise, along)
        if now is None:
            return None
        signals = {k.key: J for k, J in zip(now.knobs, now.signals, strict=True)}
        values = {key: now.values[key] for key in r.values}
        moved = Screened(r.candidate, now.score - fit.score, values)
        signals_of = [signals[k.key] for k in fit.knobs]
        return moved, replace(now, knobs=fit.knobs, signals=signals_of)

    best = sorted((r for r in again if r.values), key=lambda r: -r.gain)[:FOLLOWED]
    return [pair for pair in engine.each(one, best) if pair]


def likely(
    found: Sequence[tuple[Screened, Fit]], needed: float
) -> list[tuple[Screened, Fit]]:
    """Return what is worth refining; nothing where no candidate comes near.

    A strong effect may gain several times more once it is refined.
    """
    most = max((r.gain for r, _ in found), default=0.0)
    least = max(FAR_BEHIND * most, HOPELESS * needed)
    return [pair for pair in found if pair[0].gain > least][:REFINED]


def contenders(
    engine: Engine,
    base: Fit,
    found: Sequence[tuple[Screened, Fit]],
    needed: float,
) -> list[Refined]:
    """Refine what is worth it after the screen; best first.

    If nothing keeps what the screen promised, also what only seemed far behind: a
    threshold or a clock that promises by chance, and gains nothing once it is refined,
    is no measure for the others.
    """
    tried = likely(found, needed)
    refined = refine(engine, base, tried, needed)
    if not any(r.reaches(needed) for r in refined):
        most = max((r.before for r in refined), default=0.0)
        least = max(FAR_BEHIND * most, HOPELESS * needed)
        masked = [pair for pair in found[len(tried) :] if pair[0].gain > least]
        refined = [*refined, *refine(engine, base, masked[:REFINED], needed)]
    if pulled(base, AWAY) and all(r.gain < CLEAR for r in refined):
        again = afresh(engine, base, [r for r, _ in found])
        refined = [*refined, *refine(engine, base, again, needed)]
    return ranked(refined)


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
        return with_effect(engine, start, r, base.noise, along[id(start.signals)])

    fits = engine.each(one, found)
    every = []
    for (r, _), fit in zip(found, fits, strict=True):
        if fit is None:
            continue
        moved = replace(r, values={k: fit.values[k] for k in r.values})
        before = fit.score - base.score - handicap(r, fit.values)
        every.append(Refined(moved, fit, before, before, fit.prior - base.prior))
    best = max(every, key=lambda r: r.before, default=None)
    if best is None or best.before <= 0:
        return []
    close = [r for r in every if r.before > FAR_BEHIND * best.before]
    if any(r.trusted + max(r.eased, TIED) >= needed for r in close):
        close = by_its_noise(engine, base, close, best)
    return ranked(close)


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

    return engine.each(one, found)


def steady(gains: Array) -> float:
    """Sum of what stretches gain, but for the best and the worst of them."""
    return float(np.sort(gains)[ODD:-ODD].sum())


def plainest_first(refined: list[Refined]) -> list[Refined]:
    """Put a plainer effect first that does as well as the best to the last percent."""
    if not refined or refined[0].screened.candidate.effect not in LESS_LIKELY:
        return refined
    least = 0.98 * refined[0].gain - TIED
    for i, r in enumerate(refined):
        if r.screened.candidate.effect not in LESS_LIKELY and r.gain > least:
            return [r, *refined[:i], *refined[i + 1 :]]
    return refined


def with_effect(
    engine: Engine,
    base: Fit,
    screened: Screened,
    noise: list[Whitener],
    along: Tangent,
    *,
    patient: bool = True,
) -> Fit | None:
    """Refine one candidate under given noise, the knobs of the base giving way.

    None where no vehicle can have such a strength. Unless it is ``patient``, what
    gained less than its signals promised is left there.
    """
    mine = effect_knobs(screened)
    keys = {k.key for k in mine}
    gone = [i for i, k in enumerate(base.knobs) if k.key in keys]
    knobs = [k for k in base.knobs if k.key not in keys] + mine
    start = engine.attempt(base.values | screened.values, knobs, noise)
    kept = along.but(gone)
    return start and pursued(engine, start, keys, kept, patient=patient)


def pursued(
    engine: Engine,
    start: Fit,
    keys: set[str],
    kept: Tangent,
    enough: float = inf,
    *,
    patient: bool = True,
) -> Fit:
    """Refine the figures of a candidate further, the others along ``kept`` signals.

    It ends where the score is enough.
    """
    now, bent = start, False
    for _ in range(STEPS):
        mine = [k for k in now.knobs if k.key in keys]
        own = engine.tangent(now.values, mine, now.noise)
        new, promised = descent.advance(engine, now, kept + own, SETTLED)
        gain, now = new.score - now.score, new
        if now.score >= enough:
            return now
        bent |= patient and gain < min(MUCH * promised, promised - TIED)
        if gain < SETTLED:
            if not (bent or any(k.by_factor for k in mine)):
                return now
            break
    # so far off that the others' signals have bent, or grown by a factor
    now = descent.improve(engine, now, rounds=ANEW, least=SETTLED)
    back = descent.over_steps(engine, now, [0.0])
    if back is now:
        return now
    return descent.improve(engine, back, rounds=ANEW, least=SETTLED)


def effect_knobs(screened: Screened) -> list[Knob]:
    """The figures of a candidate, free to move from where the screen left them."""
    knobs = []
    for s in screened.candidate.searches:
        if s.key not in screened.values or s.clocked:
            continue
        x = screened.values[s.key]
        moved = abs(x - s.neutral) if s.neutral < inf else abs(x)
        step = 0.02 * (moved or abs(s.first) or 1.0)
        knobs.append(Knob(s.key, x, inf, s.low, s.high, step, s.acts))
    return knobs
