"""Descends to the likeliest figures: maximum a posteriori, by Newton's steps."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import replace
from math import inf, isfinite

import numpy as np
from numpy.typing import NDArray

from rcc_sim.diagnose.fitting.engine import Engine
from rcc_sim.diagnose.fitting.fit import FIRM, Fit, Tangent, of_unit_diagonal
from rcc_sim.diagnose.fitting.knobs import Knob, nuisance_knobs
from rcc_sim.diagnose.noise.whitener import Whitener, curvature, weights
from rcc_sim.side_by_side import each, first

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

PATIENT, ROUNDS = 6, 18
"""Rounds from which on a fit goes on only while each settles something, and most of
them: where mass and a rotor's inertia trade, a valley bends at every step."""

LEARNT = 8
"""Times that the noise is learnt anew at most, from what a better fit leaves: an
offset of a battery's voltage and its resistance, by which noise that remembers may pass
for either, took seven."""

SETTLED = 0.5
"""Nats below which no figure is moved any more."""

MUCH = 0.5
"""Share of what a step promised below which its signals are found anew; and of a finite
difference's step, below which they were found over too wide a one."""

SHORTER = (1.0, 0.4, 0.1)
"""Shares of a step that are tried in turn."""

LONGER = 1.25
"""Times what a step promised that it must gain for twice the step to be tried."""

OVER = (-2.0, -1.5, -1.0, -0.5, 0.0, 0.5, 1.0, 1.5, 2.0)
"""Standard deviations from what is stated at which a threshold is tried: each step that
a reference takes past it parts two hollows, and no slope leads from one to the next."""

BESIDE = (-0.02, -0.004, 0.004, 0.02)
"""Shares of itself by which one is tried beside where it is: at 1 kHz a reference takes
a step a tick, and a launch that is a tick early outweighs all else.
"""

AHEAD = (1, 2)
"""Rows by which a delay is moved at a time."""

LITTLE = 0.05
"""Nats that a step must promise to be tried, and gain for another."""


def fit(
    engine: Engine,
    start: dict[str, float],
    knobs: Sequence[Knob],
    noise: list[Whitener] | None = None,
    signals: list[list[Array]] | None = None,
    least: float = -inf,
) -> Fit:
    """Maximum a posteriori under the noise that it leaves.

    What is missing yet counts as noise, and hides itself: the noise is learnt anew
    as long as that leads on. Signals may be given that were found nearby; what slept
    there is asked once whether it still does. A fit that lacks more of the ``least``
    score that is asked of it than it has gained is given up: each turn gains less than
    those before it.
    """
    now = engine.evaluate({**{k.key: k.value for k in knobs}, **start}, knobs, noise)
    now = roused(engine, replace(now, signals=signals or []))
    begun = now.score
    for turn in range(LEARNT):
        before = now.score
        few = noise is None and not turn
        now = improved(engine, now, 2 if few else ROUNDS, settled=turn > 0)
        gain = now.score - before
        now = engine.judged(now, engine.learn_noise(now.residuals))
        if (turn and gain < SETTLED) or least - now.score > now.score - begun:
            break
    return now


def refit(
    engine: Engine,
    found: Fit,
    noise: list[Whitener] | None = None,
    least: float = -inf,
) -> Fit:
    """Fit anew, from where the same figures were fitted to logs much like these."""
    return fit(engine, found.values, found.knobs, noise, found.signals, least)


def of_tolerances(engine: Engine) -> Fit:
    """Fit what the vehicle's file, and its sensors, may be off by, and no cause."""
    return fit(engine, {}, nuisance_knobs(engine.problems))


def improved(engine: Engine, now: Fit, rounds: int, *, settled: bool = False) -> Fit:
    """Return a better fit under the same noise, thresholds in the best hollow.

    One that had ``settled``, by other noise, has them there unless it moves.
    """
    before = now.score
    along = engine.whitened(now.signals, now.noise)
    now = improve(engine, now, along=along, rounds=rounds)
    if settled and now.score < before + SETTLED:
        return now
    leapt = leap(engine, now)
    return now if leapt is now else improve(engine, leapt, rounds=rounds)


def improve(
    engine: Engine,
    now: Fit,
    *,
    along: Tangent | None = None,
    fixed: bool = False,
    rounds: int,
    least: float = LITTLE,
) -> Fit:
    """Return a better fit under the same noise, after some rounds at most.

    Signals may be given, as those of the fit. They are found anew, unless they are
    ``fixed`` or near, once a step along them gains less than it should. None is tried
    that promises no more than the ``least`` nats.
    """
    tangent = along
    since = inf if along and not now.near else 0.0  # nats since its signals were found
    for turn in range(rounds):
        if tangent is None:
            tangent, since = tangent_of(engine, now), 0.0
        new, promised = advance(engine, now, tangent, least)
        if any(
            k.stride < MUCH * was.stride
            for k, was in zip(new.knobs, now.knobs, strict=True)
        ):
            since = inf
        gain, now = new.score - now.score, new
        settled = gain < (LITTLE if turn < PATIENT else SETTLED)
        if settled and (fixed or since < SETTLED):
            break
        if not fixed and (since >= SETTLED or gain < MUCH * promised):
            tangent, since = None, inf
        since += gain
    return replace(now, near=since < SETTLED)


def roused(engine: Engine, now: Fit) -> Fit:
    """Return a fit with the signals that it lacks, and of what slept its new ones."""
    lacking = now.asleep if now.signals else range(len(now.knobs))
    if not lacking:
        return now
    found = engine.signals(now.values, [now.knobs[i] for i in lacking])
    known = dict(enumerate(now.signals)) | dict(zip(lacking, found, strict=True))
    return replace(now, signals=[known[i] for i in range(len(now.knobs))])


def tangent_of(engine: Engine, now: Fit) -> Tangent:
    """How residuals change with the figures of a fit, those that sleep let be.

    Of a car that goes straight on they are the half.
    """
    slept = now.asleep
    awake = [k for i, k in enumerate(now.knobs) if i not in slept]
    found = iter(engine.signals(now.values, awake))
    every = range(len(now.knobs))
    J = [now.signals[i] if i in slept else next(found) for i in every]
    return engine.whitened(J, now.noise)


def advance(
    engine: Engine, now: Fit, tangent: Tangent, least: float = LITTLE
) -> tuple[Fit, float]:
    """Return a fit after one step along some signals, and the nats that it promised."""
    H, g = slopes(engine, now, tangent.white)
    least_at, most_at = at_bounds(now)
    step, J = bounded_step(H, g, least_at, most_at), tangent.signals
    now = replace(now, knobs=finer(now.knobs, H), information=H, signals=J)
    promised = 0.5 * float(step @ H @ step)
    new = line_search(engine, now, step, promised, least)
    if new is None:
        # a threshold that passed what is asked loses more than all others gain
        held = np.array([k.is_stepped for k in now.knobs], dtype=bool)
        if step[held].any():
            step = bounded_step(H, g, least_at | held, most_at | held)
            new = line_search(engine, now, step, 0.5 * float(step @ H @ step), least)
    return replace(new, information=H, signals=J) if new else now, promised


def under_its_noise(engine: Engine, fit: Fit) -> Fit | None:
    """Fit the figures of a fit to these logs by the noise and the signals that it has.

    None where no vehicle could have them.
    """
    now = engine.at(fit, fit.values)
    if now is None:
        return None
    along = engine.whitened(fit.signals, fit.noise)
    return improve(engine, now, along=along, fixed=True, rounds=3)


def newton_step(
    engine: Engine, now: Fit, A: Array, rows: Mask | None = None
) -> tuple[Array, Array]:
    """Newton step along whitened signals, and the information behind it."""
    H, g = slopes(engine, now, A, rows)
    return bounded_step(H, g, *at_bounds(now)), H


def slopes(
    engine: Engine, now: Fit, A: Array, rows: Mask | None = None
) -> tuple[Array, Array]:
    """Curvature and slope of what is to become least, along whitened signals.

    The noise follows a t-distribution: a step of least squares with its weights
    would fall short by a fifth.
    """
    w = engine.white(now.residuals, now.noise)
    if rows is not None:
        w, A = w[rows], A[rows]
    W = weights(w)

    def of_half(half: slice) -> Array:
        B = A[half].T * np.sqrt(W[half])
        product: Array = B @ B.T
        return product

    middle = len(w) // 2
    H = sum(each(of_half, [slice(middle), slice(middle, None)]))
    H = curvature(W) * H + np.diag(1 / now.prior_sd**2)
    return H, A.T @ (W * w) + now.off / now.prior_sd**2


def at_bounds(now: Fit) -> tuple[Mask, Mask]:
    """Which figures of a fit stand at their lower, and at their upper bound."""
    least = np.array([now.values[k.key] <= k.low for k in now.knobs], dtype=bool)
    most = np.array([now.values[k.key] >= k.high for k in now.knobs], dtype=bool)
    return least, most


def bounded_step(H: Array, g: Array, least: Mask, most: Mask) -> Array:
    """Newton step -H⁻¹ g of figures of which some stand at their bounds.

    One that the step would take out stays there, and the others go where they do best
    without it: cut off afterwards, it would leave them half-way.

    Parameters
    ----------
    H, g : ndarray, shapes (k, k) and (k,)
        Curvature and slope of what is to become least.
    least, most : ndarray of bool, shape (k,)
        Figures at their lower and upper bounds.
    """
    scaled, unit = of_unit_diagonal(H, FIRM)
    free = np.ones(len(H), dtype=bool)
    while True:
        step = np.zeros(len(H))
        step[free] = -np.linalg.solve(scaled[np.ix_(free, free)], (g * unit)[free])
        held = (least & (step < 0)) | (most & (step > 0))
        if not held.any():
            return unit * step
        free &= ~held


def line_search(
    engine: Engine, now: Fit, step: Array, promised: float, least: float
) -> Fit | None:
    """The first of ever shorter steps that is better, if any is.

    A share s of a step gains s (2 - s) of what all of it promises: none is tried for no
    more than the ``least`` nats. One that gains more than was promised is lengthened as
    long as that gains: rows at which a limit or a tick comes a moment sooner make the
    way look stiffer than it is.
    """
    share, new = first(
        lambda share: (share, stepped(engine, now, share * step)),
        [s for s in SHORTER if s * (2 - s) * promised > least],
        lambda tried: tried[1] is not None and tried[1].score > now.score,
    ) or (0.0, None)
    if new is None:
        return None
    while share >= 1 and new.score - now.score > LONGER * share * promised:
        share *= 2
        farther = stepped(engine, now, share * step)
        if farther is None or farther.score <= new.score:
            break
        new = farther
    return new


def stepped(engine: Engine, now: Fit, step: Array) -> Fit | None:
    """Return a fit after a step; None where no vehicle has such figures."""
    return engine.at(now, figures_after(now, step))


def figures_after(now: Fit, step: Array) -> dict[str, float]:
    """Return a fit's figures after a step, within their bounds."""
    trial = dict(now.values)
    for k, s in zip(now.knobs, step, strict=True):
        trial[k.key] = k.moved(trial[k.key], float(s))
    return trial


def finer(knobs: Sequence[Knob], H: Array) -> tuple[Knob, ...]:
    """Return knobs with steps as fine as what the information tells of each."""
    sds = 1 / np.sqrt(np.diag(H) + 1e-300)
    return tuple(k.finer(sd) for k, sd in zip(knobs, sds, strict=True))


def leap(engine: Engine, now: Fit) -> Fit:
    """Return a better fit in another hollow of thresholds or delays, if any is."""
    for k in now.knobs:
        if k.acts == "rows" and not isfinite(k.sd):
            there = climbed(engine, now, k)
            now = there if there.score > now.score + SETTLED else now
    return over_steps(engine, now, OVER)


def over_steps(
    engine: Engine, now: Fit, places: Sequence[float], keys: Collection[str] = ()
) -> Fit:
    """Return a fit with a threshold at another place if that does better.

    Each is tried nearby, and at so many standard deviations from what is stated; so are
    the figures of some ``keys``.
    """
    tried = []
    for k in (k for k in now.knobs if k.is_stepped or k.key in keys):
        at = [(1 + share) * now.values[k.key] for share in BESIDE]
        at += [k.value + n * k.sd for n in places] if isfinite(k.sd) else []
        tried += [now.values | {k.key: k.within(x)} for x in at]
    fits = each(lambda x: engine.at(now, x), tried)
    best = max(filter(None, fits), key=lambda f: f.score, default=now)
    return now if best.score <= now.score + SETTLED else best


def at_thresholds(engine: Engine, now: Fit, values: Mapping[str, float]) -> Fit:
    """Return a fit with all its thresholds where others have them if that does better.

    The first, long step of a figure takes a threshold along over what it jumps at.
    """
    stepped = {k.key for k in now.knobs if k.is_stepped}
    there = {key: values[key] for key in stepped & values.keys()}
    if there.items() <= now.values.items():
        return now
    new = engine.at(now, now.values | there)
    return now if new is None or new.score <= now.score + SETTLED else new


def climbed(engine: Engine, now: Fit, knob: Knob, tried: Iterable[float] = ()) -> Fit:
    """Move a delay by whole rows as far as it gains, the others giving way.

    From the best of what is ``tried``. Within a row it makes readings smoother,
    which pleases a fit as well: each row has a hollow of its own, out of which no
    slope leads, and one may be deeper than the next.
    """
    others = [k for k in now.knobs if k.key != knob.key]
    row = engine.problems[0].row
    known: dict[float, Fit | None] = {}
    along = engine.tangent(now.values, others, now.noise)

    def held(x: float) -> Fit | None:
        start = engine.attempt(now.values | {knob.key: x}, others, now.noise)
        if start is None:
            return None
        found = improve(engine, start, along=along, fixed=True, rounds=4)
        return replace(found, knobs=now.knobs)

    def best_of(xs: Iterable[float], *fits: Fit) -> Fit:
        near = {round(x / row, 6): x for x in xs if x == knob.within(x)}
        new = [place for place in near if place not in known]
        known.update(zip(new, each(lambda p: held(near[p]), new), strict=True))
        found = [*fits, *filter(None, (known[place] for place in near))]
        return max(found, key=lambda f: f.score, default=now)

    best = best_of({now.values[knob.key], *tried})
    for way in (row, -row):
        before = None
        while best is not before:
            before, x = best, best.values[knob.key]
            best = best_of([x + n * way for n in AHEAD], best)
    return replace(best, information=now.information, signals=now.signals)
