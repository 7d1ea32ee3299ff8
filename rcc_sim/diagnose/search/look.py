"""What candidates gain beside a fit, and what strengths its logs would tell."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

from rcc_sim.diagnose.causes.candidates import Candidate
from rcc_sim.diagnose.causes.cause import ENOUGH, TIED, Cause
from rcc_sim.diagnose.causes.detect import least_seen, shows_likely
from rcc_sim.diagnose.fitting import descent
from rcc_sim.diagnose.fitting.engine import Engine
from rcc_sim.diagnose.fitting.fit import Fit
from rcc_sim.diagnose.fitting.without import refitted_without
from rcc_sim.diagnose.profiles.gusts import OF_THE_AIR, WIND
from rcc_sim.diagnose.search.refine import Refined, contenders
from rcc_sim.diagnose.search.screen import Screened
from rcc_sim.diagnose.search.starts import screened
from rcc_sim.diagnose.search.winner import cause_of


@dataclass(frozen=True)
class Look:
    """What candidates gain beside a fit.

    Parameters
    ----------
    fit : Fit
        Tolerances, and the causes so far, as far down as was seen.
    found : list of (Screened, Fit)
        All candidates, best first, each with where to refine it from.
    refined : list of Refined
        Those that were worth it, best first.
    best : Refined or None
        The first of them that gains enough, all over the logs.
    one : Cause or None
        That one as a cause.
    """

    fit: Fit
    found: list[tuple[Screened, Fit]]
    refined: list[Refined]
    best: Refined | None
    one: Cause | None

    @property
    def known(self) -> list[Screened]:
        """All candidates, best first."""
        return [r for r, _ in self.found]

    @property
    def alone(self) -> dict[str, float]:
        """Effect -> nats that it gained by the screen."""
        return {r.candidate.effect: r.gain for r in reversed(self.known)}

    @property
    def gains(self) -> dict[str, float]:
        """The same, refined where that was worth it, by the noise of the fit."""
        known = {r.screened.candidate.effect: r.before for r in self.refined}
        return self.alone | known

    @property
    def close(self) -> list[Refined]:
        """Those that tie with the best."""
        return [r for r in self.refined if r.gain > self.refined[0].gain - TIED]


def looked(
    engine: Engine,
    fit: Fit,
    candidates: Sequence[Candidate],
    causes: Sequence[Cause],
    told: Callable[[str], None],
    found: list[tuple[Screened, Fit]] | None = None,
    *,
    settled: bool = False,
) -> Look:
    """Screen what may be a cause beside some others, and refine what is worth it.

    Once more, where what came out best owes it to a fit that had not ``settled``.
    ``found`` is what the screen told, where that was asked before.
    """
    if found is None:
        told(f"screening for cause {len(causes) + 1}")
        found = screened(engine, fit, free_of(candidates, causes))
    told(f"refining cause {len(causes) + 1}")
    refined = contenders(engine, fit, found, ENOUGH)
    best = next((r for r in refined if r.reaches(ENOUGH)), None)
    rest = None if settled or best is None else come_to_rest(engine, fit, best)
    if rest:
        return looked(engine, rest, candidates, causes, told, settled=True)
    one = cause_of(engine, best, fit.noise) if best else None
    return Look(fit, found, refined, best, one)


def come_to_rest(engine: Engine, fit: Fit, best: Refined) -> Fit | None:
    """Return the fit further down, where a candidate does not gain enough beyond that.

    Who follows a candidate moves every other figure as well: what they gain where they
    had not come to rest counts for the candidate, whichever it is.
    """
    others = refitted_without(engine, best.fit, best.screened.values)
    if others is None:
        return None
    gained = engine.judged(others, fit.noise).score - fit.score
    if gained < TIED or best.reaches(ENOUGH + gained):
        return None
    return descent.refit(engine, others, fit.noise)


def free_of(
    candidates: Sequence[Candidate], causes: Sequence[Cause]
) -> list[Candidate]:
    """Return the candidates with the figures that no cause has yet.

    Of an effect of which several figures may be off, others may follow the first. What
    a wind acts by is not beside its gusts, whose size makes up for it.
    """
    keys = {c.effect: c.keys for c in causes}
    gusty = any(c.effect == WIND and c.profiles for c in causes)
    rest = [
        replace(c, searches=c.beside(keys[c.effect])) if c.effect in keys else c
        for c in candidates
        if (c.several or c.effect not in keys)
        and not (gusty and any(s.key in OF_THE_AIR for s in c.searches))
    ]
    return [c for c in rest if c.searches]


def told_from(screened: Screened) -> dict[str, float | None]:
    """Return from what strength on the logs would tell each figure of a candidate."""
    return {
        search.key.rpartition(".")[2]: least_seen(
            search, screened.shown[search.key], ENOUGH
        )
        for search in screened.candidate.searches
    }


def shows(screened: Screened, least: Mapping[str, float | None]) -> bool:
    """Tell whether any figure of a candidate would show at a likely strength."""
    return any(
        shows_likely(s, least[s.key.rpartition(".")[2]])
        for s in screened.candidate.searches
    )
