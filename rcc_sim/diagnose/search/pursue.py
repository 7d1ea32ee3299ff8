"""One candidate, followed as far as it gains, every other figure giving way."""

from __future__ import annotations

from dataclasses import replace
from math import inf, isfinite

from rcc_sim.diagnose.causes.cause import TIED
from rcc_sim.diagnose.fitting import descent
from rcc_sim.diagnose.fitting.descent import MUCH, SETTLED, SHORTER
from rcc_sim.diagnose.fitting.engine import Engine
from rcc_sim.diagnose.fitting.fit import Fit, Tangent
from rcc_sim.diagnose.fitting.knobs import Knob
from rcc_sim.diagnose.noise.whitener import Whitener
from rcc_sim.diagnose.search.screen import Screened

STEPS, ANEW = 6, 4
"""Steps of a candidate along the signals of the base, and rounds with signals found
anew where it has not settled by then."""

LEAPS = 4
"""Steps along which a figure is followed, or times that thresholds leap, at most."""


def with_effect(
    engine: Engine,
    base: Fit,
    screened: Screened,
    noise: list[Whitener],
    along: Tangent,
    *,
    wanted: float | None = None,
) -> Fit | None:
    """Refine one candidate under given noise, the knobs of the base giving way.

    None where no vehicle can have such a strength. Where it is only asked whether it
    reaches a score that is ``wanted``, it is followed as far as the signals of the base
    lead, and if it is not behind there.
    """
    mine = effect_knobs(screened)
    keys = {k.key for k in mine}
    gone = [i for i, k in enumerate(base.knobs) if k.key in keys]
    knobs = [k for k in base.knobs if k.key not in keys] + mine
    start = engine.attempt(base.values | screened.values, knobs, noise)
    kept = along.but(gone)
    return start and pursued(engine, start, keys, kept, wanted=wanted)


def from_nothing(engine: Engine, base: Fit, screened: Screened, found: Fit) -> Fit:
    """Return a candidate that ended worse than the base it started from, or better.

    One figure is followed from where it does nothing: at the strength that the screen
    promised the others may be so far off that no step leads back.
    """
    (key, *more) = screened.values
    (search,) = (s for s in screened.candidate.searches if s.key == key)
    if more or search.grid or search.clocked or not isfinite(search.neutral):
        return found
    start = engine.attempt(base.values | {key: search.neutral}, found.knobs, base.noise)
    if start is None:
        return found
    new = followed(engine, start, key)
    new = descent.improve(engine, new, rounds=ANEW, least=SETTLED)
    return new if new.score > found.score else found


def followed(engine: Engine, now: Fit, key: str) -> Fit:
    """Follow one figure as far as it gains, the others giving way along curves.

    At each step it is held until the others have settled: in a narrow valley that
    bends, a step of all figures at once leads nowhere.
    """
    for _ in range(LEAPS):
        along = engine.tangent(now.values, now.knobs, now.noise)
        step, _ = descent.newton_step(engine, now, along.white)
        for share in SHORTER:
            moved = descent.figures_after(now, share * step)
            others = [k for k in now.knobs if k.key != key]
            held = engine.attempt(moved, others, now.noise)
            if held is None:
                continue
            new = descent.improve(engine, held, rounds=2)
            if new.score > now.score + SETTLED:
                now = replace(new, knobs=now.knobs)
                break
        else:
            break
    return now


def pursued(
    engine: Engine,
    start: Fit,
    keys: set[str],
    kept: Tangent,
    enough: float = inf,
    *,
    wanted: float | None = None,
) -> Fit:
    """Refine the figures of a candidate further, the others along ``kept`` signals.

    It ends where the score is enough; and where one is ``wanted``, and these signals do
    not lead there.
    """
    now, bent = start, False
    for _ in range(STEPS):
        mine = [k for k in now.knobs if k.key in keys]
        own = engine.tangent(now.values, mine, now.noise)
        new, promised = descent.advance(engine, now, kept + own, SETTLED)
        gain, now = new.score - now.score, new
        if now.score >= enough:
            return now
        bent |= wanted is None and gain < min(MUCH * promised, promised - TIED)
        if gain < SETTLED:
            if not (bent or any(k.by_factor or k.is_stepped for k in mine)):
                return now
            break
    if wanted is not None and now.score < wanted:
        return now
    # so far off that the others' signals have bent, or grown by a factor
    now = descent.improve(engine, now, rounds=ANEW, least=SETTLED)
    for _ in range(LEAPS):  # what jumps and the others take turns
        back = descent.over_steps(engine, now, [0.0], keys)
        if back is now:
            break
        now = descent.improve(engine, back, rounds=ANEW, least=SETTLED)
    return now


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
