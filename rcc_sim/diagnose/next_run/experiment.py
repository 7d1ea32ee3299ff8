"""Which run would tell apart what these logs cannot, and by how many nats."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import zip_longest
from math import inf, log

from rcc_sim.diagnose.causes.cause import TIED
from rcc_sim.diagnose.fitting.engine import Engine
from rcc_sim.diagnose.fitting.fit import Fit
from rcc_sim.diagnose.judge.asserted import Asserted
from rcc_sim.diagnose.judge.ties import Rival
from rcc_sim.diagnose.next_run.bench import Bench, Nats
from rcc_sim.diagnose.next_run.menu import Run
from rcc_sim.errors import InputError
from rcc_sim.physics.effect import Effect
from rcc_sim.physics.effects import neutral_of
from rcc_sim.side_by_side import each

MOST = 4
"""Hypotheses of a tie that are told apart: the likeliest."""

SHOWN, AT_ONCE = 3, 4
"""Runs that are proposed for a tie, and runs that are weighed side by side."""

ENOUGH = 1.0
"""Nats below which no second run is worth proposing."""

NOTHING = TIED / 30
"""Nats below which a run parts nothing, even driven thirty times."""

WIDE = 0.15
"""Half-width of a 90 % interval, as a share of a cause's departure from what the file
states, above which the cause is not settled."""

MOST_TIES = 2
"""Ties for which runs are looked for: the strongest causes'."""


@dataclass(frozen=True)
class Experiment:
    """A run to drive next.

    Parameters
    ----------
    do : str
        What to do.
    separates : tuple of str
        The effects that it would tell apart; of one, it narrows the interval.
    expected_nats : Nats
        What it is expected to tell.
    time_s : float
        How long it takes. [s]
    run : Run
        Its commands.
    """

    do: str
    separates: tuple[str, ...]
    expected_nats: Nats
    time_s: float
    run: Run

    def document(self) -> dict[str, object]:
        """Return what ``--json`` prints."""
        nats = self.expected_nats
        return {
            "do": self.do,
            "separates": list(self.separates),
            "expected_nats": {
                "least": nats.least,
                "pairs": [{"a": p.a, "b": p.b, "nats": p.nats} for p in nats.pairs],
            },
            "time_s": self.time_s,
            "commanded": self.run.is_commanded,
        }


def next_experiments(
    engine: Engine,
    fit: Fit,
    asserted: Sequence[Asserted],
    found: Mapping[str, Sequence[Rival]],
) -> list[Experiment]:
    """Return the runs that would settle what is tied, else what is wide; best first.

    Parameters
    ----------
    engine : Engine
        The logs; the first one tells what can be driven.
    fit : Fit
        Tolerances and all causes.
    asserted : sequence of Asserted
        The causes, strongest first.
    found : mapping
        Cause -> what may stand in its place, as
        :func:`rcc_sim.diagnose.judge.ties.rivals_of` finds it.
    """
    ties = [a.cause.effect for a in asserted if a.cause.tied]
    known = engine.problems[0].vehicle.known
    wide = [a for a in asserted if not a.cause.tied and is_wide(a, fit, known)]
    if not ties and not wide:
        return []
    bench = Bench(engine, fit)
    if ties:
        parts = []
        for cause in ties[:MOST_TIES]:
            tied = [r for r in found[cause] if r.is_tied]
            fits = {cause: fit} | {r.effect: r.fit for r in tied[: MOST - 1]}
            parts.append(best_of(bench, fits, (cause, *(r.effect for r in tied))))
        return [e for turn in zip_longest(*parts) for e in turn if e]
    return narrowing(bench, fit, wide[0])


def is_wide(asserted: Asserted, fit: Fit, known: Mapping[str, Effect]) -> bool:
    """Tell whether the interval of a cause says little of its size."""
    knobs = {k.key for k in fit.knobs}
    for key in asserted.cause.keys:
        figure = asserted.figures.get(key.rpartition(".")[2])
        if figure is None or asserted.cause.profiles or key not in knobs:
            continue
        departs = abs(figure.value - neutral_of(key, known))
        if 0.5 * (figure.high - figure.low) > WIDE * departs:
            return True
    return False


def best_of(
    bench: Bench, tied: Mapping[str, Fit], names: tuple[str, ...]
) -> list[Experiment]:
    """Return the runs that tell most of a tie apart; the best even if it tells little.

    None where it tells nothing at all. Two that do the same in every run do not hide
    what tells the others, and what one run parts the next need not.
    """
    driven = [d for d in each(bench.drive(tied), bench.runs) if d]
    driven.sort(key=lambda d: -d.most)
    found: list[Experiment] = []
    for k in range(0, len(driven), AT_ONCE):
        least = found[SHOWN - 1].expected_nats.worth if len(found) >= SHOWN else -inf
        worth = [d for d in driven[k : k + AT_ONCE] if d.most > least]
        if not worth:
            break
        every = each(lambda d: bench.nats(d, tied), worth)
        for one, nats in zip(worth, every, strict=True):
            if nats is None:
                continue
            told = {e for p in nats.pairs if p.nats > ENOUGH for e in (p.a, p.b)}
            apart = tuple(n for n in names if n in told) or names
            run = one.run
            found.append(Experiment(run.words, apart, nats, run.seconds, run))
        found.sort(key=lambda e: (-round(e.expected_nats.worth, 1), e.time_s))
    return [
        e
        for k, e in enumerate(in_turn(found)[:SHOWN])
        if any(p.nats > (ENOUGH if k else NOTHING) for p in e.expected_nats.pairs)
    ]


def in_turn(runs: Sequence[Experiment]) -> list[Experiment]:
    """Return runs in the order in which each parts most of what is still tied."""
    left, order = list(runs), []
    parted: set[tuple[str, str]] = set()
    while left:
        more = [round(e.expected_nats.beside(parted), 1) for e in left]
        most = more.index(max(more))
        order.append(left.pop(most))
        parted |= {(p.a, p.b) for p in order[-1].expected_nats.pairs if p.nats > TIED}
    return order


def narrowing(bench: Bench, fit: Fit, wide: Asserted) -> list[Experiment]:
    """Return the runs that narrow a cause's interval most, in nats of its width.

    Of those that do so alike the shortest: a gyro's offset shows as well at rest.
    """

    def one(run: Run) -> Experiment | None:
        try:
            gain = bench.narrows(run, fit, wide.cause.keys)
        except InputError:
            return None
        return Experiment(
            run.words, (wide.cause.effect,), Nats(gain, ()), run.seconds, run
        )

    found = [e for e in each(one, bench.runs) if e is not None]
    found = [e for e in found if e.expected_nats.least > 0.5 * log(2)]
    found.sort(key=lambda e: (-round(e.expected_nats.least, 1), e.time_s))
    return found[:SHOWN]
