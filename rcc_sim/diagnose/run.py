"""Diagnosis of one or more logs: where, which, how much, proven, and what next."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import replace
from functools import partial
from itertools import accumulate
from math import inf
from operator import or_
from typing import TypeVar

import numpy as np

from rcc_sim.analyse.gap import Gap, gap
from rcc_sim.analyse.logged import Logged
from rcc_sim.analyse.offsets import OFFSETS
from rcc_sim.definitions.vehicle import Vehicle
from rcc_sim.diagnose.causes.candidates import candidates_for
from rcc_sim.diagnose.diagnosis import Diagnosis
from rcc_sim.diagnose.fitting.engine import MEMORY, Engine
from rcc_sim.diagnose.fitting.fit import Fit
from rcc_sim.diagnose.fitting.pulls import farthest, moved, moved_together
from rcc_sim.diagnose.fitting.tips import no_surer
from rcc_sim.diagnose.judge.apart_from_nil import apart_from_nil
from rcc_sim.diagnose.judge.direct import felt_otherwise
from rcc_sim.diagnose.judge.misread import findings_of
from rcc_sim.diagnose.judge.restless import is_doubtful, restless
from rcc_sim.diagnose.judge.stands import what_stands
from rcc_sim.diagnose.judge.verdict import (
    DOUBTLESS,
    EVEN,
    asserted_of,
    chances_of,
    ends_early,
    of_another,
    verdict,
)
from rcc_sim.diagnose.next_run.experiment import next_experiments
from rcc_sim.diagnose.profiles.as_felt import as_felt
from rcc_sim.diagnose.proof.by_log import noise_of
from rcc_sim.diagnose.proof.proven import proven
from rcc_sim.diagnose.residuals.dense import rows_to_one, thinned, with_fewer_rows
from rcc_sim.diagnose.residuals.posed import problem_of
from rcc_sim.diagnose.residuals.problem import MIN_ROWS, Problem
from rcc_sim.diagnose.residuals.repeated import not_shared
from rcc_sim.diagnose.residuals.shapes import LATERAL
from rcc_sim.diagnose.residuals.sizes import size_of
from rcc_sim.diagnose.residuals.terminals import VOLTAGE
from rcc_sim.diagnose.search.as_sent import as_sent, kept_alike
from rcc_sim.diagnose.search.compete import compete
from rcc_sim.errors import InputError
from rcc_sim.jit import threads
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
        offsets = tuple(c for name in withheld for c in OFFSETS.get(name, ()))
        problems = [problem_of(one.log, vehicle) for one in logs]
        refuse_silent(problems)
        if offsets or repeats:  # else they keep what they have worked out
            again = [problem_of(log, vehicle) for log in repeats]
            problems = [
                replace(p, unzeroed=offsets, noise=not_shared(p, again))
                for p in problems
            ]
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
    doubtless = any(g.energy.within is False for g in gaps)
    large = any(g.energy.beyond(DOUBTLESS) for g in gaps)
    kept = proven(engine, found, stands, gaps, fresh, stated, doubtless=doubtless)
    if kept.refuted:
        large = doubtless
    stands, proved = kept.stands, kept.proof
    acting, causes, left = stands.engine, stands.causes, stands.left
    if not causes and doubtless:
        left = replace(left, opens_gap=True)
    wanders = {r.log: r.heights for r in left.rivals if r.heights} | felt.wanders
    loose = restless(acting, stands.fit, found.null)
    said = partial(findings_of, acting, stands.fit, wanders, causes, loose)
    gaps = tuple(replace(g, findings=g.findings + said(i)) for i, g in enumerate(gaps))
    told_of = [f for g in gaps for f in g.findings]
    kinds = {f.kind for f in told_of}
    fit = no_surer(acting, stands.fit, {k for c in causes for k in c.keys})
    farthest = farthest_moved(fit, stated, gaps)
    # what was found beside a stronger cause that ends is no surer than that
    early = [*accumulate((ends_early(c, fit, vehicle.known) for c in causes), or_)]
    doubtful = [
        end or kept.unproven or is_doubtful(c, loose) or felt_otherwise(c, told_of)
        for c, end in zip(causes, early, strict=True)
    ]
    chances = chances_of(causes, left, farthest, doubtful)
    row = size_of(engine.problems[0], "row")
    asserted = asserted_of(fit, causes, stands.rivals, stated, row, chances)
    asserted = apart_from_nil(acting, fit, asserted)
    told("which run to drive next")
    runs = tuple(next_experiments(acting, fit, asserted, stands.rivals))
    # by a logged speed a prediction has that speed's noise, beyond its own sensor's
    commanded = not all(p.drive.imposed for p in engine.problems)
    comes_to = verdict(
        causes,
        left,
        proved.before,
        proved.after,
        doubtless=doubtless,
        noise=noise_of(gaps),
        large=large,
        explained=proved.shrink.explained if commanded else 1.0,
        ends=any(early),
        farthest=farthest,
        disagree=any(one.disagrees for one in kept.by_log) or "opposed" in kinds,
        even=any(chance <= EVEN for chance in chances),
        wanders="restless" in kinds,
    )
    shown = farthest_off(gaps)
    hidden = tuple(dict.fromkeys(c for one in logs for c in one.hidden))
    return Diagnosis(
        vehicle=vehicle,
        problem=engine.problems[shown],
        gaps=gaps,
        status=comes_to.status,
        short=comes_to.short,
        asserted=asserted,
        found=found,
        fit=fit,
        left=left,
        proof=proved,
        experiments=runs,
        kept_back=tuple(one.log.name for one in holdouts),
        withdrawn=kept.refuted,
        shown=shown,
        asked=tuple(candidates),
        hidden=hidden,
        by_log=kept.by_log,
    )


def farthest_moved(fit: Fit, stated: Mapping[str, float], gaps: Sequence[Gap]) -> float:
    """Return by how many sds stated figures are off, alone or all together.

    Without end where a log and the vehicle's file contradict each other.
    """
    if any(of_another(g.findings) for g in gaps):
        return inf
    return farthest(moved(fit, stated), moved_together(fit, stated))


@contextmanager
def beside(tasks: Iterable[Callable[[], R]]) -> Iterator[list[R]]:
    """Do some tasks while something else is done; yield what will hold their results.

    What goes wrong in them comes first.
    """
    results: list[R] = []
    if threads() < 2:
        results += [do() for do in tasks]
        yield results
        return
    with ThreadPoolExecutor(1) as other:
        asked = [other.submit(do) for do in tasks]
        try:
            yield results
        finally:
            results += [one.result() for one in asked]


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
