r"""Which effects a log cannot tell from the one that is named.

Each candidate that could stand in a cause's place is put there and fitted, every other
figure giving way. Two hypotheses A and B are then told apart by

.. math:: d_{AB} = \min_\theta \tfrac12 |W(y_A - y_B(\theta))|^2 + \pi_B(\theta) - \pi_A

nats: what such a log would speak against B if A were true, W being the whitener of the
noise and π the price of figures that leave what the file states. [1]_ What this log
does say, the difference of the two log-posteriors, counts beyond what chance could
bring about, judged from how it scatters from stretch to stretch. [2]_

References
----------
.. [1] D. Jung, E. Frisk, M. Krysander, "Quantitative isolability analysis of different
       fault modes", 2013; the expectation of a log-likelihood ratio.
.. [2] Q. H. Vuong, "Likelihood ratio tests for model selection and non-nested
       hypotheses," Econometrica 57 (1989) 307.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from math import inf

import numpy as np
from numpy.typing import NDArray

from rcc_sim.definitions.figure import Z_90
from rcc_sim.diagnose.causes.candidates import Candidate
from rcc_sim.diagnose.causes.cause import TIED, Cause
from rcc_sim.diagnose.causes.profile import overlap
from rcc_sim.diagnose.fitting import descent
from rcc_sim.diagnose.fitting.engine import MEMORY, Engine
from rcc_sim.diagnose.fitting.fit import FIRM, Fit, of_unit_diagonal
from rcc_sim.diagnose.fitting.without import without
from rcc_sim.diagnose.noise.whitener import CURVATURE, weights
from rcc_sim.diagnose.search.give_way import gives_way, nats_of_courses
from rcc_sim.diagnose.search.pursue import with_effect
from rcc_sim.diagnose.search.refine import LESS_LIKELY
from rcc_sim.diagnose.search.screen import Screen, Screened
from rcc_sim.diagnose.search.winner import shares_of
from rcc_sim.side_by_side import each

Array = NDArray[np.float64]

NEAR = 0.3
"""Share of a cause's nats that another must have gained beside it to be tried; once
other causes are known it may gain more."""

ALIKE = 0.6
"""Share of a cause's nats that another must gain at its best strength to be fitted; and
along the signals found there, to be followed any farther."""

ELSEWHERE = 0.2
"""Overlap of what two effects change, channel by channel, below which the one does not
do what the other does. A steering that is late by half a row and a payload had 0.06; an
offset of an accelerometer and a slope, of a car whose loop feels it, 0.45."""

NEAREST = 3
"""Effects in a cause's place that are tried beside courses of their own."""

CHANGES = 3
"""Times that a cause may give way."""

ROUNDS = 2
"""Rounds of a fit that is still on its way, its signals found anew."""


@dataclass(frozen=True)
class Rival:
    """Another effect in a cause's place, fitted.

    Parameters
    ----------
    screened : Screened
        The effect and the strength that it takes.
    fit : Fit
        Every figure, under the noise of the cause's own fit.
    behind : float
        Nats of log-posterior by which it is behind the cause on these logs, and by
        which its strength is the less usual one.
    scatter : float
        Standard deviation of that difference by chance.
    apart : float
        Nats by which such logs would tell it from the cause if the cause is true.
    absent : float
        The same for nothing at all in the cause's place.
    """

    screened: Screened
    fit: Fit
    behind: float
    scatter: float
    apart: float
    absent: float = inf

    @property
    def effect(self) -> str:
        """Its id."""
        return self.screened.candidate.effect

    @property
    def keys(self) -> tuple[str, ...]:
        """Its figures."""
        return tuple(self.screened.values)

    def in_place_of(self, cause: Cause) -> Cause:
        """Return it as the cause, by what it would then gain."""
        gain = cause.gain - self.behind
        return replace(cause, effect=self.effect, keys=self.keys, gain=gain)

    @property
    def is_tied(self) -> bool:
        """Whether these logs cannot tell it from the cause.

        What is farther from the cause than nothing is does not do what the cause does,
        whatever it gains of its own.
        """
        close = self.apart < TIED or self.behind < max(TIED, Z_90 * self.scatter)
        return close and self.apart < max(self.absent, TIED)


@dataclass(frozen=True)
class Settled:
    """The causes that do best, and what may stand in the place of each.

    Parameters
    ----------
    fit : Fit
        Tolerances and causes.
    causes : list of Cause
        Each with the effects that the logs cannot tell from it.
    rivals : dict
        Cause -> other effects in its place, nearest first.
    """

    fit: Fit
    causes: list[Cause]
    rivals: dict[str, list[Rival]]


def settled(
    engine: Engine, fit: Fit, causes: Sequence[Cause], candidates: Sequence[Candidate]
) -> Settled:
    """Put others in the place of each cause; keep what does best, and say what ties.

    A cause that was taken in first, before the others were known, may have been taken
    for another: where one in its place does better, it gives way. A cause that varies
    over the drive stays as it is.

    Parameters
    ----------
    engine : Engine
        The logs, with the profiles found acting on them.
    fit : Fit
        Tolerances and all causes.
    causes : sequence of Cause
        What is asserted.
    candidates : sequence of Candidate
        Effects that could act.
    """
    causes, found = list(causes), {}
    for i, cause in enumerate(causes):
        if cause.profiles:
            continue
        mine = in_place(engine, fit, cause, causes, candidates)
        for _ in range(CHANGES):
            best = better(causes[i], mine)
            if best is None:
                break
            causes[i] = best.in_place_of(causes[i])
            fit = descent.refit(engine, best.fit)
            mine = in_place(engine, fit, causes[i], causes, candidates)
        found[causes[i].effect] = mine
    return Settled(fit, with_ties(causes, found), found)


def in_place(
    engine: Engine,
    fit: Fit,
    cause: Cause,
    causes: Sequence[Cause],
    candidates: Sequence[Candidate],
) -> list[Rival]:
    """Return what could stand in a cause's place, nearest first, and at what price.

    What shows elsewhere may gain as much of its own; it takes the place only if it does
    better.
    """
    mine = next(c for c in candidates if c.effect == cause.effect)
    paid = mine.price(fit.values, cause.keys)
    close = near(cause, causes, candidates)
    least = ALIKE * cause.screened.get(cause.effect, inf)
    alike = {c.effect for c in close if cause.screened.get(c.effect, 0.0) > least}
    rivals = rivals_of(engine, fit, cause.keys, close, alike)
    prices = [r.screened.candidate.price(r.fit.values, r.keys) for r in rivals]
    found = [
        replace(r, behind=r.behind + price - paid)
        for r, price in zip(rivals, prices, strict=True)
    ]
    if any(map(gives_way, causes)):
        found = beside_their_courses(engine, fit, causes, found)
    if found:
        own = shares_of(engine, fit, cause.keys, fit.noise)
        found = [r for r in found if r.behind < -TIED or not elsewhere(engine, r, own)]
    return sorted(found, key=lambda r: r.behind)


def beside_their_courses(
    engine: Engine, fit: Fit, causes: Sequence[Cause], rivals: Sequence[Rival]
) -> list[Rival]:
    """Return rivals, the nearest that do not tie beside courses of their own.

    A hill was found beside the cause in whose place they stand, and suits it.
    """
    tied = [r for r in rivals if r.is_tied]
    clear = [r for r in rivals if not r.is_tied]
    own = nats_of_courses(engine, fit, causes)[0] if clear else 0.0

    def one(r: Rival) -> Rival:
        more = nats_of_courses(engine, r.fit, causes)[0] - own
        return replace(r, behind=min(r.behind, max(r.behind - more, 0.0)))

    return [*tied, *each(one, clear[:NEAREST]), *clear[NEAREST:]]


def elsewhere(engine: Engine, rival: Rival, shares: Array) -> bool:
    """Tell whether a rival acts in other channels than those that have the shares."""
    its = shares_of(engine, rival.fit, rival.keys, rival.fit.noise)
    return overlap(shares, its) <= ELSEWHERE


def better(cause: Cause, rivals: Sequence[Rival]) -> Rival | None:
    """Return what is to be named in place of a cause, if anything.

    What does better by more than what two alike may differ; or what is plainer, where
    the cause is one of two figures that do as others do and the logs cannot tell: of
    logs and prices together, less speaks against it than it is likelier.
    """
    if rivals and rivals[0].behind < -TIED:
        return rivals[0]
    if cause.effect not in LESS_LIKELY:
        return None
    plain = (r for r in rivals if r.is_tied and r.effect not in LESS_LIKELY)
    return next((r for r in plain if r.behind < LESS_LIKELY[cause.effect]), None)


def near(
    cause: Cause, causes: Sequence[Cause], candidates: Sequence[Candidate]
) -> list[Candidate]:
    """Return the candidates that came near a cause, or another, when it was taken in.

    Of three effects of which any two do as well, one that gains much alone is taken in
    first, and what comes near the second may stand in its place beside that.
    """

    def came_near(one: Candidate, to: Cause) -> bool:
        unknown = inf if to is cause else 0.0
        gained = to.screened.get(one.effect, unknown)
        return gained > NEAR * to.screened.get(to.effect, 0.0)

    named = {c.effect for c in causes}
    free = [c for c in candidates if c.effect not in named]
    return [c for c in free if any(came_near(c, to) for to in causes)]


def with_ties(
    causes: Sequence[Cause], found: Mapping[str, Sequence[Rival]]
) -> list[Cause]:
    """Return the causes, each with the effects that the logs cannot tell from it."""
    out = []
    for cause in causes:
        if cause.effect not in found:
            out.append(cause)
            continue
        mine = found[cause.effect]
        tied = tuple(r.effect for r in mine if r.is_tied)
        clear = min((r.behind for r in mine if not r.is_tied), default=cause.gain)
        out.append(replace(cause, tied=tied, rival=max(cause.gain - clear, 0.0)))
    return out


def rivals_of(
    engine: Engine,
    fit: Fit,
    keys: Sequence[str],
    candidates: Sequence[Candidate],
    alike: Collection[str] = (),
) -> list[Rival]:
    """Return each candidate that may stand in place of some figures, nearest first.

    Parameters
    ----------
    keys : sequence of str
        Figures of the cause in whose place they stand.
    alike : collection of str
        Effects that are known to do about as well, whatever a screen makes of them.
    """
    base = without(engine, fit, keys)
    if base is None:
        return []
    screen = Screen(engine, base)
    own = promise(screen, {k: fit.values[k] for k in keys})

    tried = each(screen.best, candidates)
    screened = [
        s
        for s in tried
        if s.gain > ALIKE * own or (s.values and s.candidate.effect in alike)
    ]
    along = engine.whitened(base.signals, fit.noise)
    wanted = base.score + ALIKE * (fit.score - base.score)

    def fitted(one: Screened) -> Fit | None:
        return with_effect(engine, base, one, fit.noise, along, wanted=wanted)

    fits = each(fitted, screened)
    absent = apart(engine, fit, base)

    def held(pair: tuple[Screened, Fit]) -> Rival:
        return replace(against(engine, fit, *pair), absent=absent)

    could = [
        (one, other)
        for one, other in zip(screened, fits, strict=True)
        if other is not None
    ]
    return sorted(each(held, could), key=lambda r: r.behind)


def against(engine: Engine, fit: Fit, screened: Screened, other: Fit) -> Rival:
    """Hold another effect's fit against the cause's own.

    One that left a threshold in another hollow than the cause's takes it back, and one
    that should come nearer than it is, to first order, is fitted on.
    """
    there = descent.at_thresholds(engine, other, fit.values)
    if there is not other:
        other = descent.improve(engine, there, rounds=ROUNDS)
    far = apart(engine, fit, other)
    behind = fit.score - other.score
    if far < min(behind, Z_90 * scatter(engine, fit, other)) - 1:
        on = descent.improve(engine, other, rounds=ROUNDS)
        if on.score > other.score:
            other, behind = on, fit.score - on.score
            far = apart(engine, fit, other)
    return Rival(screened, other, behind, scatter(engine, fit, other), far)


def promise(screen: Screen, values: dict[str, float]) -> float:
    """Nats that a change would gain if its signal only grew."""
    d = screen.signal(values)
    size = float(d @ d)
    return 0.5 * float(screen.left @ d) ** 2 / size if size > 0 else 0.0


def apart(engine: Engine, true: Fit, other: Fit) -> float:
    """Nats by which a log of the one would speak against the other, refitted to it."""
    pairs = zip(other.residuals, true.residuals, strict=True)
    d = engine.white([a - b for a, b in pairs], true.noise)
    free = [
        (j, k)
        for j, k in zip(other.signals, other.knobs, strict=True)
        if k.low < other.values[k.key] < k.high
    ]
    A = np.array([engine.white(j, true.noise) for j, _ in free]).reshape(-1, len(d)).T
    sd = np.array([k.sd for _, k in free])
    off = np.array([other.values[k.key] - k.value for _, k in free]) / sd
    root = np.sqrt(CURVATURE)
    return max(least_squares(root * A, root * d, sd, off) + true.prior, 0.0)


def least_squares(A: Array, d: Array, sd: Array, off: Array) -> float:
    """Half the least square of d + A x, and of (off + x / sd), over all x."""
    N, unit = of_unit_diagonal(A.T @ A + np.diag(1 / sd**2), FIRM)
    g = (A.T @ d + off / sd) * unit
    x = np.linalg.solve(N, g)
    return 0.5 * float(d @ d + off @ off - g @ x)


def scatter(engine: Engine, one: Fit, other: Fit) -> float:
    """Standard deviation of the difference of two log-likelihoods, by chance.

    The difference is the expected one and the noise times what the two predict apart.
    Whitened rows still depend on each other where the model errs; sums over stretches
    longer than the noise remembers do not.
    """
    sums: dict[tuple[int, int], float] = {}
    for (log, _), w, a, b in zip(
        engine.tracks, one.noise, one.residuals, other.residuals, strict=True
    ):
        noise = w(a)
        chance = weights(noise) * noise * (w(b) - noise)
        t = engine.problems[log].log["time_s"]
        stretch = ((t - t[0]) / MEMORY).astype(int)[w.valid]
        for k, x in enumerate(np.bincount(stretch, chance)):
            sums[log, k] = sums.get((log, k), 0.0) + float(x)
    return float(np.linalg.norm(list(sums.values())))
