"""Diagnosis of one or more logs: where, which, how much, proven, and what next."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from functools import cached_property
from math import hypot, inf
from typing import Any

import numpy as np

from rcc_sim.analyse.gap import Gap, gap
from rcc_sim.analyse.gap_energy import COVERAGE
from rcc_sim.analyse.gap_report import where
from rcc_sim.analyse.logged import Logged
from rcc_sim.analyse.offsets import OFFSETS
from rcc_sim.definitions.figure import Z_90, Figure
from rcc_sim.definitions.vehicle import Vehicle
from rcc_sim.diagnose import descent
from rcc_sim.diagnose.candidates import candidates_for, size_of
from rcc_sim.diagnose.cause import Cause
from rcc_sim.diagnose.compete import Explanation, compete
from rcc_sim.diagnose.engine import MEMORY, Engine
from rcc_sim.diagnose.experiment import Experiment, next_experiments
from rcc_sim.diagnose.fit import Fit
from rcc_sim.diagnose.hold_out import Shrink, leave_shaft, proof
from rcc_sim.diagnose.knobs import BIAS, RADIUS, Knob
from rcc_sim.diagnose.posed import problem_of
from rcc_sim.diagnose.prices import Prices, prices
from rcc_sim.diagnose.problem import Problem
from rcc_sim.diagnose.remainder import Remainder, clearest, remainder
from rcc_sim.diagnose.sums import with_all_figures
from rcc_sim.diagnose.switched import LOAD
from rcc_sim.diagnose.ties import settled
from rcc_sim.diagnose.verdict import (
    ANOTHER_VEHICLE,
    DOUBTLESS,
    INTERVAL,
    Asserted,
    ends_early,
    estimates,
    is_steady,
    moved,
    probability,
    proves_nothing,
    ranking,
    standing,
    status_of,
)
from rcc_sim.errors import InputError
from rcc_sim.trace import Trace

SHORTEST = 1.5 * MEMORY
"""Time that a log must last. [s]"""

TOLD, MOVED = 0.9, 0.1
"""Share of its stated sd below which the sd of a figure must fall for it to be written;
or else by how many of them it must have moved. The figures of a fit belong together:
one that goes back to what the file says leaves the others with what it made up for."""


@dataclass(frozen=True)
class Diagnosis:
    """What :func:`diagnose` found.

    Parameters
    ----------
    vehicle : Vehicle
        The nominal model.
    problem : Problem
        The log ``shown`` as it was explained, and that model, without any profile.
    gaps : tuple of Gap
        Where each log and the nominal model part.
    status : str
        no_gap, explained, partly_explained or unexplained.
    asserted : tuple of Asserted
        The causes, strongest first.
    found : Explanation
        Everything the competition found.
    fit : Fit
        Tolerances and the causes that stand.
    left : Remainder
        What none of the effects explains.
    shrink : Shrink
        Proof on rows that no fit saw.
    energy_before, energy_after : float or None
        Energy gap on such rows with the nominal vehicle, and with the mended one. [%]
    by_torque : bool
        Whether both ran by a torque that was measured: where there is one, the drive is
        imposed, and no cause changes anything up to the motor's shaft.
    experiments : tuple of Experiment
        Runs that would settle what is tied, or wide; best first.
    kept_back : tuple of str
        Logs on which the proof is; empty: stretches of those that were explained.
    withdrawn : tuple of str
        Effects that explain what was fitted, and do nothing for what was held out.
    shown : int
        Log that is shown: of several, the one whose energy is farthest off.
    """

    vehicle: Vehicle
    problem: Problem
    gaps: tuple[Gap, ...]
    status: str
    asserted: tuple[Asserted, ...]
    found: Explanation
    fit: Fit
    left: Remainder
    shrink: Shrink
    energy_before: float | None
    energy_after: float | None
    by_torque: bool
    experiments: tuple[Experiment, ...] = ()
    kept_back: tuple[str, ...] = ()
    withdrawn: tuple[str, ...] = ()
    shown: int = 0

    def document(self) -> dict[str, Any]:
        """Return what ``--json`` prints."""
        first = self.gap
        unexplained: dict[str, Any] = {
            "fraction": self.unexplained,
            "windows": self.left.windows if self.left.is_real else [],
        }
        if self.left.is_real:
            unexplained |= {"acts_as": self.left.acts_as, "follows": self.left.follows}
        return {
            "schema": "rccsim.diagnosis/1",
            "log": first.log,
            "logs": [g.log for g in self.gaps],
            "vehicle": self.vehicle.name,
            "mode": first.mode,
            "status": self.status,
            "where": where(first),
            "causes": [self._cause(a) for a in self.asserted],
            "ranking": ranking(self.found, list(self.asserted), self.left, self.status),
            "shrink": {
                "held_out": True,
                "logs": list(self.kept_back),
                "withdrawn": list(self.withdrawn),
                **asdict(self.shrink),
                "energy_gap_percent_before": self.energy_before,
                "energy_gap_percent_after": self.energy_after,
                "energy_by_measured_torque": self.by_torque,
            },
            "moved": moved(self.fit, self.vehicle.figures()),
            "prices": self.prices and asdict(self.prices),
            "unexplained": unexplained,
            "next_experiment": [e.document() for e in self.experiments],
            "least_seen": self.found.least_seen,
            "not_identifiable": self.not_identifiable,
            "findings": [asdict(f) for f in first.findings],
        }

    def _cause(self, a: Asserted) -> dict[str, Any]:
        most = max([*self.found.ranking.values(), 1.0])
        gain = self.found.ranking.get(a.cause.effect, a.cause.gain)
        return {
            "effect": a.cause.effect,
            "probability": a.probability,
            "parameters": {k: e.document() for k, e in a.figures.items()},
            "varies": bool(a.cause.profiles),
            "indistinguishable_from": list(a.cause.tied),
            "explains": min(max(gain, 0.0) / most, 1.0),
            "nats": a.cause.gain,
            "energy_wh": self.prices and self.prices.causes[a.cause.effect],
        }

    @property
    def gap(self) -> Gap:
        """Gap of the log that is shown."""
        return self.gaps[self.shown]

    @property
    def is_tied(self) -> bool:
        """Whether something else would do in the place of a cause."""
        return any(a.cause.tied for a in self.asserted)

    @property
    def unexplained(self) -> float:
        """Share of the gap beyond noise that stays; all of it where nothing stands."""
        if self.status == "unexplained":
            return 1.0
        return 1.0 - max(self.shrink.explained, 0.0) if self.left.is_real else 0.0

    @cached_property
    def prices(self) -> Prices | None:
        """What each cause adds to the energy of the log that is shown."""
        causes = [a.cause for a in self.asserted]
        return prices(self.plain, causes, self.fit.values, self.shown)

    @cached_property
    def plain(self) -> Problem:
        """The same as ``problem``, at the log's own rows."""
        if self.problem.charge is None:
            return self.problem
        return problem_of(self.gap.measured, self.vehicle)

    @property
    def not_identifiable(self) -> list[str]:
        """Effects of which no likely strength would show in these logs."""
        told = {e for a in self.asserted for e in (a.cause.effect, *a.cause.tied)}
        return sorted(self.found.hidden - told)

    def figures(self) -> dict[str, Figure]:
        """Stated figures that the logs moved, with intervals."""
        stated = self.vehicle.figures()
        return {key: figure for key, figure in self._moved().items() if key in stated}

    def _moved(self) -> dict[str, Figure]:
        """Tolerances that the logs narrow or move, by key."""
        out = {}
        for knob, sd in zip(self.fit.knobs, self.fit.sds(), strict=True):
            if knob.sd < inf and not knob.key.startswith(BIAS):
                off = abs(self.fit.values[knob.key] - knob.value)
                sd = min(sd * INTERVAL, knob.sd)
                if sd <= TOLD * knob.sd or off >= MOVED * knob.sd:
                    out[knob.key] = self._figure(knob, sd)
        return out

    def _figure(self, knob: Knob, sd: float) -> Figure:
        """Return a figure that the logs moved; its interval ends where it must."""
        value = self.fit.values[knob.key]
        low, high = max(value - Z_90 * sd, knob.low), min(value + Z_90 * sd, knob.high)
        return Figure(value, sd, low, high, self._source_of(knob.key))

    def _source_of(self, key: str) -> str:
        """Return where a figure comes from, and what the file stated before."""
        before = self.vehicle.figures().get(key)
        if before is None:
            return self.source
        told = f": {before.source}" if before.source else ""
        return f"{self.source}; stated {before.value:g}{told}"

    @property
    def elsewhere(self) -> dict[str, float]:
        """Stated figures so many sds off that they are those of another vehicle."""
        pulls = moved(self.fit, self.vehicle.figures())
        return {k: abs(x) for k, x in pulls.items() if abs(x) > ANOTHER_VEHICLE}

    @property
    def source(self) -> str:
        """Where derived figures come from."""
        return "derived: " + ", ".join(g.log for g in self.gaps)

    def effects(self) -> dict[str, dict[str, Figure]]:
        """Causes as the mended file states them; profiles are written apart.

        A tyre radius that moved within its sd is written as ``wheel_radius``, because
        logs hold speeds by the radius that the file states.
        """
        radius = self._moved().get(RADIUS)
        found = {"wheel_radius": {"scale": radius}} if radius else {}
        return found | {
            a.cause.effect: {
                k: Figure(e.value, e.sd, e.low, e.high, self.source)
                for k, e in a.figures.items()
            }
            for a in self.asserted
        }


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
    for one in logs:
        refuse_short(one.log)
    told("where")
    gaps = tuple(gap(one, vehicle, repeats=repeats) for one in logs)
    offsets = tuple(c for name in withheld for c in OFFSETS.get(name, ()))
    problems = [problem_of(one.log, vehicle) for one in logs]
    if offsets:
        problems = [replace(p, unzeroed=offsets) for p in problems]
    engine = Engine(problems)
    able = candidates_for(problems, candidates, withheld)
    found = compete(engine, able, told)
    told("what is left")
    left = remainder(found.engine, found.fit, constant(found.causes))
    causes = [c for c in found.causes if is_steady(c, left)]
    fit, acting = found.fit, found.engine
    if len(causes) < len(found.causes):
        fit, acting = _only(engine, found, fit, causes)
        left = remainder(acting, fit, constant(causes))
    named, causes = causes, standing(causes, left, fit)
    if len(causes) < len(named):
        fit, acting = _only(engine, found, fit, causes)
        left = clearest((left, remainder(acting, fit)))
    told("what these logs cannot tell apart")
    known = settled(acting, fit, causes, able)
    if known.fit is not fit:
        left = remainder(acting, known.fit)
    fit, causes = known.fit, standing(known.causes, left, known.fit)
    if len(causes) < len(known.causes):
        fit, acting = _only(engine, found, fit, causes)
    causes, fit = with_all_figures(acting, fit, causes, able)
    told("proof on held-out rows")
    fresh = [problem_of(one.log, vehicle) for one in holdouts]
    torqued = any(p.torqued for p in (*problems, *fresh))
    by_torque = torqued and leave_shaft(causes, acting.tracks)
    stated = {key: figure.value for key, figure in vehicle.figures().items()}
    level = levels_of(causes, fit, stated)
    shrink, before, after = proof(
        acting, engine, fit, fresh, level, by_torque=by_torque
    )
    large = any(g.energy.beyond(DOUBTLESS) for g in gaps)
    doubtless = any(g.energy.within is False for g in gaps)
    refuted: tuple[str, ...] = ()
    if causes and doubtless and proves_nothing(shrink.explained, before, after):
        refuted = tuple(c.effect for c in causes)
        causes, large = [], True
        fit, acting = _only(engine, found, fit, causes)
        left = remainder(acting, fit)
        shrink, before, after = proof(
            acting, engine, fit, fresh, {}, by_torque=by_torque
        )
    row = size_of(problems[0], "row")
    farthest = max(map(abs, moved(fit, stated).values()), default=0.0)
    asserted = tuple(
        Asserted(c, probability(c, left, farthest), estimates(fit, c, stated, row))
        for c in causes
    )
    told("which run to drive next")
    runs = tuple(next_experiments(acting, fit, asserted, known.rivals))
    ends = any(ends_early(c, fit, vehicle.known) for c in causes)
    status = status_of(
        causes,
        left,
        before,
        after,
        doubtless=doubtless,
        noise=noise_of(gaps),
        large=large,
        explained=shrink.explained,
        ends=ends,
        farthest=farthest,
    )
    shown = farthest_off(gaps)
    return Diagnosis(
        vehicle, problems[shown], gaps, status, asserted, found, fit, left, shrink,
        before, after, by_torque, runs, tuple(one.log.name for one in holdouts),
        refuted, shown,
    )  # fmt: skip


def farthest_off(gaps: Sequence[Gap]) -> int:
    """Return the log whose energy is farthest off; the first where none is known."""
    return int(np.argmax([abs(g.energy.gap_wh or 0.0) for g in gaps]))


def noise_of(gaps: Sequence[Gap]) -> float:
    """Return how far noise and a rough road may put the energy of logs, in percent."""
    measured = abs(sum(g.energy.measured_wh or 0.0 for g in gaps))
    noise = COVERAGE * hypot(*(g.energy.noise_wh for g in gaps))
    return 100 * noise / measured if measured else inf


def refuse_short(log: Trace) -> None:
    """Raise if a log is too short for its noise to be told from a cause."""
    lasts = float(log["time_s"][-1] - log["time_s"][0])
    if lasts < SHORTEST:
        raise InputError(
            f"{log.name}: lasts {lasts:.3g} s: too short to tell a cause from noise",
            f"noise may remember {MEMORY:g} s; {SHORTEST:g} s of driving at least",
        )


def levels_of(
    causes: Sequence[Cause], fit: Fit, stated: Mapping[str, float]
) -> dict[str, float]:
    """Return the mean of each load that varies, as the mended file states it."""
    return {
        cause.keys[0]: next(iter(estimates(fit, cause, stated).values())).value
        for cause in causes
        if cause.effect == LOAD and cause.profiles
    }


def constant(causes: Sequence[Cause]) -> dict[str, tuple[str, ...]]:
    """Return the figures of the causes that were taken as constant, by effect."""
    return {c.effect: c.keys for c in causes if not c.profiles}


def _only(
    engine: Engine, found: Explanation, fit: Fit, causes: list[Cause]
) -> tuple[Fit, Engine]:
    """Fit again with the causes that stand, from where all stood; or the tolerances."""
    mine = {k for c in causes for k in c.keys}
    acting = found.engine if any(c.profiles for c in causes) else engine
    kept = [k for k in fit.knobs if k.key in mine or np.isfinite(k.sd)]
    keys = {k.key for k in kept}
    kept += [k for k in found.null.knobs if k.key not in keys]
    known = found.null.values | fit.values if causes else found.null.values
    start = {k.key: known.get(k.key, k.value) for k in kept}
    return descent.fit(acting, start, kept), acting
