"""Candidates around a fit, screened, each with where to refine it from."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from math import inf

import numpy as np
from numpy.typing import NDArray

from rcc_sim.diagnose.causes.candidates import Candidate
from rcc_sim.diagnose.causes.cause import ENOUGH
from rcc_sim.diagnose.fitting import descent
from rcc_sim.diagnose.fitting.engine import Engine
from rcc_sim.diagnose.fitting.fit import Fit
from rcc_sim.diagnose.fitting.knobs import BIAS
from rcc_sim.diagnose.fitting.pulls import TOO_FAR, pulled
from rcc_sim.diagnose.search.pursue import effect_knobs, followed, with_effect
from rcc_sim.diagnose.search.screen import Screen, Screened
from rcc_sim.side_by_side import each

Array = NDArray[np.float64]

REFINED, FAR_BEHIND = 6, 0.2
"""Candidates that are refined after a screen, and share of the best gain below which
none is."""

EXACT = 0.5
"""Share of the nats a cause must gain that one must promise beside the figures that the
file states: so far away the screen is not exact to a half."""

PROMISING, FOLLOWED = 18.0, 2
"""Nats that a slope must promise for a candidate to be followed along its curve; and
how many are, those that promise most."""


def screened(
    engine: Engine, fit: Fit, candidates: Sequence[Candidate]
) -> list[tuple[Screened, Fit]]:
    """Screen candidates around a fit; best first, each with where to refine from."""
    screen = Screen(engine, fit)
    found = [(r, fit) for r in each(screen.best, candidates)]
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
        start = engine.at(fit, fit.values | values | {knob.key: knob.value})
        if start is not None:
            found.append((Screened(candidate, 0.5 * pull**2, values), start))
    return found


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
            now = followed(engine, start, key)
        pairs.append(begun(r.candidate, [key], fit, now, fit.signals))
    return pairs


def likely(
    found: Sequence[tuple[Screened, Fit]], least: float, most: float | None = None
) -> list[tuple[Screened, Fit]]:
    """Return what is worth refining; nothing where no candidate gains the ``least``.

    A strong effect may gain several times more once it is refined; what is far behind
    the best, or the ``most`` nats that were kept, does not.
    """
    if most is None:
        most = max((r.gain for r, _ in found), default=0.0)
    least = max(FAR_BEHIND * most, least)
    return [pair for pair in found if pair[0].gain > least][:REFINED]


def begun(
    candidate: Candidate,
    keys: Iterable[str],
    fit: Fit,
    now: Fit,
    signals: list[list[Array]],
) -> tuple[Screened, Fit]:
    """Return where a candidate came from a fit, as a start: with that fit's knobs."""
    values = {key: now.values[key] for key in keys}
    kept = replace(now, knobs=fit.knobs, signals=signals, information=fit.information)
    return Screened(candidate, now.score - fit.score, values), kept


def afresh(
    engine: Engine, fit: Fit, found: Sequence[Screened]
) -> list[tuple[Screened, Fit]]:
    """Candidates once more, beside the figures that the file states.

    Tolerances that stand in for an effect have gone a long way, over thresholds and
    limits, and need not find back as it grows. All are screened: beside what stands in
    for it an effect may promise nothing. What is far behind the best then is no cause.
    """
    stated = {
        k.key: k.value for k in fit.knobs if k.sd < inf and not k.key.startswith(BIAS)
    }
    start = engine.at(fit, fit.values | stated)
    if start is None:
        return []
    start = replace(start, signals=engine.signals(start.values, start.knobs))
    every = {r.candidate.effect: r.candidate for r in found}
    again = each(Screen(engine, start).best, list(every.values()))
    along = engine.whitened(start.signals, fit.noise)

    def one(r: Screened) -> tuple[Screened, Fit] | None:
        now = with_effect(engine, start, r, fit.noise, along)
        if now is None:
            return None
        signals = {k.key: J for k, J in zip(now.knobs, now.signals, strict=True)}
        along_now = [signals[k.key] for k in fit.knobs]
        return begun(r.candidate, r.values, fit, now, along_now)

    best = sorted((r for r in again if r.values), key=lambda r: -r.gain)
    worth = likely([(r, start) for r in best], EXACT * ENOUGH)
    return [pair for pair in each(one, [r for r, _ in worth]) if pair]
