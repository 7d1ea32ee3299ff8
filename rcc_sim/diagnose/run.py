"""Diagnosis of one or more logs: where, which, how much, proven, and what next."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from functools import partial
from typing import TypeVar

import numpy as np

from rcc_sim.analyse.gap import Gap, gap
from rcc_sim.analyse.logged import Logged
from rcc_sim.analyse.offsets import OFFSETS
from rcc_sim.definitions.vehicle import Vehicle
from rcc_sim.diagnose.causes.candidates import candidates_for
from rcc_sim.diagnose.diagnosis import Diagnosis
from rcc_sim.diagnose.fitting.engine import MEMORY, Engine
from rcc_sim.diagnose.judge.stands import what_stands
from rcc_sim.diagnose.judged import is_doubtless, judged
from rcc_sim.diagnose.next_run.experiment import next_experiments
from rcc_sim.diagnose.profiles.as_felt import as_felt
from rcc_sim.diagnose.proof.proven import proven
from rcc_sim.diagnose.residuals.dense import rows_to_one, thinned, with_fewer_rows
from rcc_sim.diagnose.residuals.posed import problem_of
from rcc_sim.diagnose.residuals.problem import MIN_ROWS, Problem
from rcc_sim.diagnose.residuals.repeated import not_shared
from rcc_sim.diagnose.residuals.shapes import LATERAL
from rcc_sim.diagnose.residuals.terminals import VOLTAGE
from rcc_sim.diagnose.search.as_sent import as_sent
from rcc_sim.diagnose.search.compete import compete
from rcc_sim.diagnose.search.ways import kept_alike
from rcc_sim.errors import InputError
from rcc_sim.side_by_side import in_turn
from rcc_sim.trace import Trace

R = TypeVar("R")

SHORTEST = 1.5 * MEMORY
"""Time that logs must last, all together. [s]"""


def diagnose(
    logs: Sequence[Logged],
    vehicle: Vehicle,
    *,
    candidates: Sequence[str] = (),
    holdouts: Sequence[Logged] = (),
    repeats: Sequence[Trace] = (),
    withheld: Sequence[str] = (),
    told: Callable[[str], None] = lambda _: None,
) -> Diagnosis:
    """Find which unmodelled effects part logs from a vehicle's model.

    Parameters
    ----------
    logs : sequence of Logged
        All are explained at once, by the same vehicle.
    vehicle : Vehicle
        The nominal model; its sds are tolerances.
    candidates : sequence of str
        Effects to consider; all that could show where empty.
    holdouts : sequence of Logged
        Logs that are judged and never fitted; stretches of ``logs`` where empty.
    repeats : sequence of Trace
        Other logs of the same drive, from which noise is known.
    withheld : sequence of str
        Effects that were taken out of the vehicle, and may be found again.
    told : callable
        Called with what is being done.

    Raises
    ------
    InputError
        If a log cannot be compared with the vehicle.
    """
    refuse_short([one.log for one in logs])
    logs, holdouts = ([thinned(one) for one in some] for some in (logs, holdouts))
    repeats = [with_fewer_rows(log, rows_to_one(log)) for log in repeats]
    told("where")
    with beside(partial(gap, one, vehicle, repeats=repeats) for one in logs) as where:
        problems = posed([one.log for one in logs], vehicle, repeats, withheld)
        felt = as_felt(Engine(problems))
        able = candidates_for(problems, candidates, withheld)
        engine, found = as_sent(
            felt.engine,
            felt.null,
            lambda logs, null, other: compete(logs, able, told, null, other),
        )
    gaps = tuple(where)
    stated = {key: figure.value for key, figure in vehicle.figures().items()}
    stands = what_stands(engine, found, able, stated, told)
    told("proof on held-out rows")
    fresh = kept_alike([problem_of(one.log, vehicle) for one in holdouts], engine)
    kept = proven(
        engine, found, stands, gaps, fresh, stated, doubtless=is_doubtless(gaps)
    )
    now = judged(kept, found, gaps, felt.wanders, stated, engine.problems)
    told("which run to drive next")
    runs = next_experiments(
        kept.stands.engine, now.fit, now.asserted, kept.stands.rivals
    )
    shown = farthest_off(gaps)
    return Diagnosis(
        vehicle=vehicle,
        problem=engine.problems[shown],
        gaps=now.gaps,
        status=now.verdict.status,
        short=now.verdict.short,
        asserted=now.asserted,
        found=found,
        fit=now.fit,
        left=now.left,
        proof=kept.proof,
        experiments=tuple(runs),
        kept_back=tuple(one.log.name for one in holdouts),
        withdrawn=kept.refuted,
        shown=shown,
        asked=tuple(candidates),
        hidden=tuple(dict.fromkeys(c for one in logs for c in one.hidden)),
        by_log=kept.by_log,
    )


def posed(
    logs: Sequence[Trace],
    vehicle: Vehicle,
    repeats: Sequence[Trace],
    withheld: Sequence[str],
) -> list[Problem]:
    """Return logs as problems, with noise that repeats tell and offsets to be found.

    Raises
    ------
    InputError
        If a log holds no channel by which the model can be judged.
    """
    problems = [problem_of(log, vehicle) for log in logs]
    refuse_silent(problems)
    offsets = tuple(c for name in withheld for c in OFFSETS.get(name, ()))
    if not (offsets or repeats):  # they keep what they have worked out
        return problems
    again = [problem_of(log, vehicle) for log in repeats]
    return [replace(p, unzeroed=offsets, noise=not_shared(p, again)) for p in problems]


@contextmanager
def beside(tasks: Iterable[Callable[[], R]]) -> Iterator[list[R]]:
    """Do some tasks while something else is done; yield what will hold their results.

    What goes wrong in them comes first.
    """
    results: list[R] = []
    made = in_turn(lambda do: do(), [*tasks])
    try:
        yield results
    finally:
        results += made


def farthest_off(gaps: Sequence[Gap]) -> int:
    """Return the log whose energy is farthest off; the first where none is known."""
    return int(np.argmax([abs(g.energy.gap_wh or 0.0) for g in gaps]))


def refuse_short(logs: Sequence[Trace]) -> None:
    """Raise if logs are too short, all together, for noise to be told from a cause."""
    lasts = sum(float(log["time_s"][-1] - log["time_s"][0]) for log in logs)
    if lasts < SHORTEST:
        names = ", ".join(log.name for log in logs)
        raise InputError(
            f"{names}: lasts {lasts:.3g} s: too short to tell a cause from noise",
            f"noise may remember {MEMORY:g} s; {SHORTEST:g} s of driving at least, in "
            "one log or several of the same vehicle",
        )


def refuse_silent(problems: Sequence[Problem]) -> None:
    """Raise if a log holds no channel by which the model can be judged."""
    for problem in problems:
        if not problem.channels:
            raise InputError(
                f"{problem.log.name}: has no channel by which the model can be judged",
                why_silent(problem),
            )


def why_silent(problem: Problem) -> str:
    """Return what a log's channels need that none of them has."""
    held = set(problem.log.columns)
    needs = [f"a channel needs {MIN_ROWS} rows that can be judged"]
    if held & set(LATERAL):
        needs.append(f"cornering, the steering and {problem.slow:.2g} m/s or more")
    if VOLTAGE in held:
        needs.append(
            "a battery's voltage alone says nothing where the open-circuit voltage is "
            "stated with an sd, or not: log current or power as well"
        )
    return "; ".join(needs)
