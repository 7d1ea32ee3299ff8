"""Null, single effects, sets of effects and profiles compete for the logs."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Protocol

from rcc_sim.diagnose.causes.candidates import Candidate
from rcc_sim.diagnose.causes.cause import Cause
from rcc_sim.diagnose.fitting import descent
from rcc_sim.diagnose.fitting.engine import Engine
from rcc_sim.diagnose.fitting.fit import Fit
from rcc_sim.diagnose.fitting.wake import woken
from rcc_sim.diagnose.search.give_way import hills_beside_all
from rcc_sim.diagnose.search.leave_out import one_alone, without_idle, without_outdone
from rcc_sim.diagnose.search.look import free_of, shows, told_from
from rcc_sim.diagnose.search.read_late import read_late
from rcc_sim.diagnose.search.refine import Refined
from rcc_sim.diagnose.search.starts import screened
from rcc_sim.diagnose.search.taken import CONSTANT, KeptOut, Taken
from rcc_sim.diagnose.search.winner import cause_of

Way = Callable[[Engine], Engine]
"""Logs, driven another way."""


class Asked(Protocol):
    """Whether logs are driven another way."""

    def __call__(self, engine: Engine, fit: Fit, before: Fit) -> Way | None:
        """Tell it once a cause is fitted, by that fit and the one before."""

    def sooner(self, engine: Engine, null: Fit, most: float) -> Way | None:
        """Tell it by tolerances alone, and the nats that the best cause promises."""


TURNS = 6
"""Turns of the competition at most: causes taken in, or profiles refuted."""


@dataclass(frozen=True)
class Explanation:
    """What the competition ended with.

    Parameters
    ----------
    engine : Engine
        The logs, with the profiles found acting on them.
    null, fit : Fit
        Tolerances alone; tolerances and causes.
    causes : tuple of Cause
        Strongest first.
    ranking : dict
        Effect -> nats it gained alone, of all candidates; of two that hide each other,
        beside the other.
    least_seen : dict
        Effect -> parameter -> least strength that the logs would have told beside the
        tolerances; None where they tell none that is usual.
    hidden : frozenset
        Effects of which they would not have told a likely strength of any figure.
    kept_out : KeptOut or None
        What gained too little beside so strong causes, and enough for any other.
    """

    engine: Engine
    null: Fit
    fit: Fit
    causes: tuple[Cause, ...]
    ranking: dict[str, float]
    least_seen: dict[str, dict[str, float | None]] = field(default_factory=dict)
    hidden: frozenset[str] = frozenset()
    kept_out: KeptOut | None = None


def compete(
    engine: Engine,
    candidates: Sequence[Candidate],
    told: Callable[[str], None] = lambda _: None,
    null: Fit | None = None,
    asked: Asked | None = None,
) -> Explanation:
    """Find the smallest set of effects that the logs ask for.

    ``null`` is what tolerances alone leave, where that is known; ``asked`` tells how
    logs with one more cause are likelier driven, if not as they are: all begins anew.
    """
    base = engine
    told("tolerances")
    null = woken(engine, null or descent.of_tolerances(engine))
    now = Taken(engine, null, candidates, told)
    late = read_late(engine, null, candidates)
    if late:
        now.fit, now.causes = late.fit, [cause_of(engine, late, late.fit.noise)]
    found = None
    if asked:
        told(f"screening for cause {len(now.causes) + 1}")
        found = screened(engine, now.fit, free_of(candidates, now.causes))
        most = max((r.gain for r, _ in found), default=0.0)
        if way := asked.sooner(engine, null, most):
            return compete(way(base), candidates, told, asked=asked)
    look = now.looked(found)
    null = null if now.causes else look.fit
    now.ranking |= look.alone
    close: list[Refined] = []
    for _ in range(TURNS):
        if now.are_enough():
            break
        if look.fit is not now.fit:  # a profile that did not stand has changed nothing
            look = now.looked()
        if not now.causes:
            now.ranking |= {r.screened.candidate.effect: r.gain for r in look.refined}
            close = look.close
        before = now.fit
        taken = now.take_in(look)
        if not taken:
            break
        if taken == CONSTANT and asked:
            if way := asked(now.engine, now.fit, before):
                return compete(way(base), candidates, told, asked=asked)
    if late:
        now.rank(late.screened.candidate.effect, late.gain)
    told("leaving out what is not needed")
    engine, causes, fit = without_outdone(now.engine, now.causes, now.fit)
    engine, causes, fit = without_idle(engine, causes, fit)
    causes, fit = one_alone(engine, causes, fit, close)
    engine, fit, causes = hills_beside_all(engine, fit, causes)
    causes.sort(key=lambda c: -c.gain)
    # beside all the causes; what took a tolerance's place was not tried at strengths
    tried = {r.candidate.effect: r for r in look.known if r.shown}
    seen = {effect: told_from(r) for effect, r in tried.items()}
    hidden = frozenset(e for e, r in tried.items() if not shows(r, seen[e]))
    return Explanation(
        engine, null, fit, tuple(causes), now.ranking, seen, hidden, now.kept_out
    )
