"""What gives a cause away: its change in each channel, beside that of its rivals."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from rcc_sim.diagnose.causes.candidates import candidates_for
from rcc_sim.diagnose.causes.prices import with_profiles
from rcc_sim.diagnose.fitting.engine import Engine
from rcc_sim.diagnose.fitting.fit import Fit
from rcc_sim.diagnose.fitting.knobs import figures_of
from rcc_sim.diagnose.search.screen import Screen
from rcc_sim.errors import InputError

if TYPE_CHECKING:
    from rcc_sim.diagnose.diagnosis import Diagnosis
    from rcc_sim.diagnose.residuals.problem import Problem

Array = NDArray[np.float64]

RIVALS = 3
"""Candidates that are held beside the winner."""


@dataclass(frozen=True)
class Signature:
    """An effect at its best strength.

    Parameters
    ----------
    effect : str
        Its id.
    figures : dict
        Parameter -> strength; empty where it varies over the drive.
    moved : dict of ndarray
        Channel -> what it changes at the rows of the first log.
    """

    effect: str
    figures: Mapping[str, float]
    moved: Mapping[str, Array]


@dataclass(frozen=True)
class Signatures:
    """What a winner and its rivals have to explain, and what each would change.

    Parameters
    ----------
    left : dict of ndarray
        Channel -> measured less predicted without the winner, all else as found.
    effects : tuple of Signature
        The winner first, where there is one.
    """

    left: Mapping[str, Array]
    effects: tuple[Signature, ...]


def signatures(found: Diagnosis) -> Signatures:
    """Return the signature of the strongest cause and of its likeliest rivals.

    The model is drawn gently to the log, as the diagnosis does it; the other causes
    act and the stated figures stand where the fit has them. A rival has the strength
    at which it does best in the winner's place, those that are tied with it first.
    Where no vehicle could have the fit's figures without the winner, they stand as the
    file states them.
    """
    causes = [a.cause for a in found.asserted]
    winner, others = (causes[0], causes[1:]) if causes else (None, [])
    own = set(winner.keys) if winner else set()
    plain = with_profiles(found.problem, others, found.shown)
    values = {k: x for k, x in found.fit.values.items() if k not in own}
    beside = figures_of(values, found.shown)
    try:
        base = plain.predict(beside)
    except InputError:  # no vehicle can have the figures without the cause
        values, beside = {}, {}
        base = plain.nominal
    channels = plain.channels

    def at_rows(x: Array) -> Array:
        return x if plain.charge is None else plain.charge.held(x)

    def moved(figures: Mapping[str, float], varying: bool = False) -> dict[str, Array]:
        mine = [winner] if varying and winner else []
        on = with_profiles(plain, mine, found.shown)
        out = on.predict({**beside, **figures})
        return {c: at_rows(out[c] - base[c]) for c in channels}

    told = []
    if winner:
        figures = {k: found.fit.values[k] for k in winner.keys if k in found.fit.values}
        varies = bool(winner.profiles)
        shown = {} if varies else figures
        told.append(Signature(winner.effect, _named(shown), moved(figures, varies)))
    if len(found.gaps) == 1 and values:
        told += [
            Signature(effect, _named(figures), moved(figures))
            for effect, figures in _rivals(found, plain, values)
        ]
    left = {c: at_rows(plain.log[c] - base[c]) for c in channels}
    return Signatures(left, tuple(told))


def _named(figures: Mapping[str, float]) -> dict[str, float]:
    return {key.rpartition(".")[2]: x for key, x in figures.items()}


def _rivals(
    found: Diagnosis, plain: Problem, values: Mapping[str, float]
) -> list[tuple[str, dict[str, float]]]:
    """Return rivals of the winner with the strengths at which each does best."""
    taken = {a.cause.effect for a in found.asserted}
    tied = list(found.asserted[0].cause.tied) if found.asserted else []
    order = sorted(found.found.ranking, key=lambda e: -found.found.ranking[e])
    names = [e for e in dict.fromkeys([*tied, *order]) if e not in taken]
    known = {c.effect: c for c in candidates_for([plain])}
    engine = Engine([plain])
    screen = Screen(engine, _around(engine, found.fit, values))
    told: list[tuple[str, dict[str, float]]] = []
    for name in (n for n in names if n in known):
        best = screen.best(known[name])
        if best.values:
            told.append((name, best.values))
        if len(told) == RIVALS:
            break
    return told


def _around(engine: Engine, fit: Fit, values: Mapping[str, float]) -> Fit:
    """Return the fit without the winner, by the noise that the whole fit leaves."""
    pairs = zip(fit.knobs, fit.signals, strict=True)
    kept = [(k, j) for k, j in pairs if k.key in values]
    base = engine.evaluate(dict(values), [k for k, _ in kept], fit.noise)
    return replace(base, signals=[j for _, j in kept])
