"""Commands that were logged as they were sent, and hold until the next one."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from functools import partial
from math import inf

import numpy as np

from rcc_sim.diagnose.causes.cause import ENOUGH
from rcc_sim.diagnose.fitting import descent
from rcc_sim.diagnose.fitting.engine import Engine
from rcc_sim.diagnose.fitting.fit import Fit
from rcc_sim.diagnose.fitting.without import refitted_without
from rcc_sim.diagnose.noise.whitener import log_likelihood
from rcc_sim.diagnose.residuals.shapes import LATERAL
from rcc_sim.diagnose.search.compete import Asked, Explanation, Way
from rcc_sim.diagnose.search.ways import (
    are_clocked,
    are_driven_as,
    driven_as,
    every_way,
    holds_more,
    is_asked,
    is_logged_later,
    other_ways,
    parts_of,
    with_drives,
)
from rcc_sim.side_by_side import each

LATE = {
    "reference_sampling": 0,
    "reference_delay": 0,
    "actuation_delay": 0,
    "motor_lag": 0,
    "steering_delay": 1,
    "steering_lag": 1,
    "tyre_relaxation": 1,
}
"""Effect -> the command that passes for it where it holds from row to row: the
reference or the throttle, or the steering."""

Explained = Callable[[Engine, Fit | None, Asked | None], Explanation]
"""How logs are explained: from a null, where known, and asked how they are driven."""


def as_sent(
    engine: Engine, null: Fit | None, explained: Explained
) -> tuple[Engine, Explanation]:
    """Return logs and explanation, commands running between rows as is likelier.

    A command that runs straight from row to row leads one that holds by half a row, and
    lags one that is logged while it acts by as much; and so do flows that are samples
    such as are means since the row before. The vehicle as it is stated may like it
    better so; but a motor or a steering that is late, or slow, may seem to hold it:
    with the first cause it is asked, and all is explained so if it still is; and with
    each, if logs are about as likely without it where the command holds. Where what
    was found does better another way, or fewer causes as well, all is explained that
    way, too, and the likelier stands. A cause fewer is worth what one must gain.

    ``null`` is what tolerances alone leave as the logs are, where that is known.
    """
    return averaged(*as_commanded(engine, null, explained), explained)


def as_commanded(
    engine: Engine, null: Fit | None, explained: Explained
) -> tuple[Engine, Explanation]:
    """Return logs and explanation, commands running between rows as is likelier."""
    now = [p.drive.held for p in engine.problems]
    other = [d for d in every_way(engine.problems) if [x.held for x in d] != now]
    ways = each(partial(with_drives, engine), other)
    if not ways:
        return engine, explained(engine, null, None)
    likely = each(likelihood, ways)
    best = ways[int(np.argmax(likely))]
    by = max(likely) - likelihood(engine)
    liked = by >= ENOUGH
    some = parts_of(best, engine, ways) if liked else []
    found = explained(engine, null, Likelier(some, ways, (best, by)))
    begun = driven_as(engine, like=found.engine)
    if not found.causes and not liked:
        return begun, found
    late = late_in(c.effect for c in found.causes)
    later = [way for way in ways if is_logged_later(way, begun)]
    others = [way for way in ways if holds_more(way, begun, late)]
    if are_clocked(engine.problems):
        others, later = others + later, []
    others += [w for w in (engine, best) if liked and w not in others]
    others, later = (
        [way for way in some if not are_driven_as(way, begun)]
        for some in (others, later)
    )
    again = asked_again(others, found, fewer=liked)
    if again is None:  # few loggers write what acts until a row: clearly, or not
        clearly = found.fit.score + ENOUGH
        again = likeliest(later, found.engine, found.fit, clearly)
    if again is None:
        return begun, found
    holds = Likelier((), ways)  # a cause that a command which holds passes for
    anew = explained(again, null if again is engine else None, holds)
    fewer = len(anew.causes) - len(found.causes)
    if found.fit.score + ENOUGH * fewer <= anew.fit.score:
        return driven_as(engine, like=anew.engine), anew
    return begun, found


def asked_again(
    ways: Sequence[Engine], found: Explanation, *, fewer: bool
) -> Engine | None:
    """Return the way in which what was found does better, or some of it as well.

    The second is asked where ``fewer`` causes may do, and of the likeliest way alone.
    """
    if not ways:
        return None
    least = found.fit.score - ENOUGH * len(found.causes) * fewer
    way, there, fit = likeliest_of(ways, found.engine, found.fit, least)
    if fit.score > found.fit.score or (fewer and spares(there, fit, found)):
        return way
    return None


def spares(engine: Engine, fit: Fit, found: Explanation) -> bool:
    """Tell whether logs are as likely by a fit without some of the causes found.

    A cause fewer is worth what one must gain. One that varies is not asked.
    """
    causes = found.causes
    for some in [*((c,) for c in causes), causes]:
        least = found.fit.score - ENOUGH * len(some)
        if fit.score <= least:
            continue
        if any(c.profiles for c in some):
            return True
        keys = {key for c in some for key in c.keys}
        rest = refitted_without(engine, fit, keys)
        if rest is not None and rest.score > least:
            return True
    return False


class Likelier:
    """Tells how logs are driven where they are likelier by the same figures.

    That is one of ``some`` ways, with the first cause or as likely without it; or,
    where the cause is one that a command which holds passes for, one of all ``ways``
    that differs by that alone, and asks for no such cause: logs are about as likely by
    what was found before. Once they are driven another way, commands can but hold more.
    ``best`` is that of ``some`` which the vehicle as it is stated likes most, and by
    how many nats more than the logs as they are.
    """

    def __init__(
        self,
        some: Sequence[Engine],
        ways: Sequence[Engine],
        best: tuple[Engine, float] | None = None,
    ) -> None:
        self._some, self._ways, self._best = some, ways, best

    def sooner(self, engine: Engine, null: Fit, most: float) -> Way | None:
        """Tell it where tolerances alone do better so than the best cause would here.

        That promises ``most`` nats by the screen, half of what it may gain.
        """
        best, by = self._best or (engine, 0.0)
        self._best = None
        if by <= 2 * most or not likeliest(
            [best], engine, null, null.score + 2 * most + ENOUGH
        ):
            return None
        self._some = []
        return partial(driven_as, like=best)

    def __call__(self, engine: Engine, fit: Fit, before: Fit) -> Way | None:
        """Tell it by a fit with one more cause, and the one before."""
        least = fit.score - ENOUGH
        best = likeliest(self._some, engine, fit, fit.score)
        best = best or likeliest(self._some, engine, before, least)
        self._some = []
        late = late_in(freed(fit, before))
        if best is None and late:
            others = [way for way in self._ways if holds_more(way, engine, late)]
            best = likeliest(others, engine, before, least)
        return None if best is None else partial(driven_as, like=best)


def late_in(effects: Iterable[str]) -> set[int]:
    """Return the commands that, where they hold, pass for one of some effects."""
    return {LATE[effect] for effect in effects if effect in LATE}


def freed(fit: Fit, before: Fit) -> set[str]:
    """Return the effects of which a figure was free, or was set, only in the first.

    One that makes steps alone, as a period, is never free.
    """

    def moved(one: Fit) -> set[str]:
        return set(one.values) - {k.key for k in one.knobs if k.sd < inf}

    keys = moved(fit) - moved(before)
    return {key.split(".")[1] for key in keys if key.startswith("effects.")}


def likeliest(
    ways: Sequence[Engine], engine: Engine, fit: Fit, least: float
) -> Engine | None:
    """Return the way in which logs are likeliest by the same figures, fitted anew.

    None where none scores more than the ``least``.
    """
    if not ways:
        return None
    way, _, now = likeliest_of(ways, engine, fit, least)
    return way if now.score > least else None


def likeliest_of(
    ways: Sequence[Engine], engine: Engine, fit: Fit, least: float
) -> tuple[Engine, Engine, Fit]:
    """Return the way in which logs are likeliest, logs driven so, and figures there.

    Those that do not come near the ``least`` score are not fitted to the end.
    """
    others = [driven_as(engine, like=way) for way in ways]
    fits = each(lambda e: descent.refit(e, fit, least=least), others)
    every = zip(ways, others, fits, strict=True)
    return max(every, key=lambda way: way[2].score)


def averaged(
    engine: Engine, found: Explanation, explained: Explained
) -> tuple[Engine, Explanation]:
    """Return logs and explanation, flows being samples or means as the steering says.

    The flows of a drive that its own noisy speed drives do not always tell within half
    a row. How the car answers its steering does, once what else is late or slow there
    is found: half a row amiss moves its centre of gravity by three standard deviations,
    or makes a cause of where the load lies. Where what was found does better the other
    way, all is explained so, too, a cause being worth what one must gain.
    """
    asked = [is_asked(p) for p in engine.problems]
    if not any(asked):
        return engine, found
    others = other_ways(engine, asked)
    as_found = [driven_as(found.engine, like=other) for other in others]
    fits = each(lambda there: descent.refit(there, found.fit), as_found)
    answers = [answered(*there) for there in zip(as_found, fits, strict=True)]
    k = int(np.argmax(answers))
    other, better = others[k], answers[k] - answered(found.engine, found.fit)
    fewer = bool(found.causes) and better > 0 and spares(as_found[k], fits[k], found)
    if better <= ENOUGH and not fewer:
        return engine, found
    again = explained(other, None, None)
    more = len(again.causes) - len(found.causes)
    better = answered(again.engine, again.fit) - answered(found.engine, found.fit)
    return (other, again) if better > ENOUGH * (1 + more) else (engine, found)


def answered(engine: Engine, fit: Fit) -> float:
    """Log-likelihood of how a car answers its steering, and prior of all figures.

    What the noisy speed makes of the other channels is less of it in a mean.
    """
    each = zip(engine.tracks, fit.residuals, fit.noise, strict=True)
    return fit.prior + sum(
        log_likelihood(noise, left)
        for (_, channel), left, noise in each
        if channel in LATERAL
    )


def likelihood(engine: Engine) -> float:
    """Log-likelihood of the vehicle as it is stated, under the noise that it leaves."""
    left = engine.residuals({})
    return engine.loglik(left, engine.learn_noise(left))
