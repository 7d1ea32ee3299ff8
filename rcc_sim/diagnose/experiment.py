r"""Which run would tell apart what these logs cannot, and by how many nats.

Each run of a menu is driven by the vehicle under each hypothesis at its fitted
strength. If A is true, the run speaks against B by

.. math:: d_{AB} = \tfrac12 \, \Delta^T (I + A_B C_B A_B^T)^{-1} \Delta,
          \qquad \Delta = W(y_A - y_B)

nats, the expected logarithm of the odds: W whitens by the noise learnt from the log,
A_B are the signals of B's figures, and C_B is what the log left open of them, so that
whatever can give way does. [1]_

References
----------
.. [1] W. G. Hunter and A. M. Reiner, "Designs for discriminating between two rival
       models," Technometrics 7 (1965) 307; the figures marginalised as Gaussians.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import permutations

import numpy as np
from numpy.typing import NDArray

from rcc_sim.diagnose.engine import Engine, Fit
from rcc_sim.diagnose.knobs import BIAS, Knob, figures_of
from rcc_sim.diagnose.menu import (
    ON_STAND,
    STAND,
    Leg,
    Run,
    at_place,
    level_column,
    limits_of,
    menu,
)
from rcc_sim.diagnose.noise import Whitener, local_range
from rcc_sim.diagnose.problem import Problem
from rcc_sim.diagnose.ties import CURVATURE, Rival
from rcc_sim.diagnose.verdict import INTERVAL, Asserted
from rcc_sim.errors import InputError
from rcc_sim.physics.effects import EFFECTS
from rcc_sim.simulate.replay import drive_of, replay
from rcc_sim.trace import Trace

Array = NDArray[np.float64]

MOST = 4
"""Hypotheses of a tie that are told apart: the likeliest."""

SHOWN = 3
"""Runs that are proposed for a tie."""

ENOUGH = 1.0
"""Nats below which a run is not worth proposing."""

WIDE = 0.15
"""Half-width of a 90 % interval, as a share of a cause's departure from what the file
states, above which the cause is not settled."""

WHEELS_SD = 0.5
"""By how much the inertia of the wheels may be off, as a share of it."""

MOST_TIES = 2
"""Ties for which runs are looked for: the strongest causes'."""


@dataclass(frozen=True)
class Pair:
    """Nats by which a run is expected to tell two effects apart, whichever is true."""

    a: str
    b: str
    nats: float


@dataclass(frozen=True)
class Nats:
    """What a run is expected to tell: of each pair, and of the hardest."""

    least: float
    pairs: tuple[Pair, ...]


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
        Cause -> what may stand in its place (:func:`rcc_sim.diagnose.ties.rivals`).
    """
    ties = [a.cause.effect for a in asserted if a.cause.tied]
    wide = [a for a in asserted if not a.cause.tied and is_wide(a, fit)]
    if not ties and not wide:
        return []
    bench = Bench(engine, fit)
    if ties:
        parts = []
        for cause in ties[:MOST_TIES]:
            tied = [r for r in found[cause] if r.is_tied]
            fits = {cause: fit} | {r.effect: r.fit for r in tied[: MOST - 1]}
            parts.append(best_of(bench, fits, (cause, *(r.effect for r in tied))))
        return [e for part in parts for e in part]
    return narrowing(bench, fit, wide[0])


def is_wide(asserted: Asserted, fit: Fit) -> bool:
    """Tell whether the interval of a cause says little of its size."""
    knobs = {k.key for k in fit.knobs}
    for key in asserted.cause.keys:
        figure = asserted.figures.get(key.rpartition(".")[2])
        if figure is None or asserted.cause.profiles or key not in knobs:
            continue
        departs = abs(figure.value - neutral_of(key))
        if 0.5 * (figure.high - figure.low) > WIDE * departs:
            return True
    return False


def neutral_of(key: str) -> float:
    """Value of a figure at which its effect vanishes; 0 where that is infinite."""
    _, name, param = key.split(".")
    effect = EFFECTS.get(name)
    found = [p.neutral for p in effect.params if p.name == param] if effect else []
    return found[0] if found and np.isfinite(found[0]) else 0.0


def best_of(
    bench: Bench, tied: Mapping[str, Fit], names: tuple[str, ...]
) -> list[Experiment]:
    """Return the runs that tell a tie apart, by the nats of the hardest pair."""

    def one(run: Run) -> Experiment | None:
        try:
            told = bench.nats(run, tied)
        except InputError:  # a run that no such vehicle can drive
            return None
        return Experiment(run.do, names, told, run.seconds, run)

    found = [e for e in bench.engine.pool.map(one, bench.runs) if e is not None]
    found = [e for e in found if e.expected_nats.least > ENOUGH]
    found.sort(key=lambda e: (-e.expected_nats.least, e.time_s))
    return found[:SHOWN]


def narrowing(bench: Bench, fit: Fit, wide: Asserted) -> list[Experiment]:
    """Return the runs that narrow a cause's interval most, in nats of its width."""

    def one(run: Run) -> Experiment | None:
        try:
            gain = bench.narrows(run, fit, wide.cause.keys)
        except InputError:
            return None
        return Experiment(
            run.do, (wide.cause.effect,), Nats(gain, ()), run.seconds, run
        )

    found = [e for e in bench.engine.pool.map(one, bench.runs) if e is not None]
    found = [e for e in found if e.expected_nats.least > 0.5 * np.log(2)]
    found.sort(key=lambda e: (-e.expected_nats.least, e.time_s))
    return found[:SHOWN]


class Bench:
    """Drives runs with the vehicle of a log, as its sensors would see them."""

    def __init__(self, engine: Engine, fit: Fit) -> None:
        self.engine = engine
        problem = engine.problems[0]
        self.vehicle, self.window = problem.vehicle, problem.drive.window
        self.channels = problem.channels
        self.level = level_column(problem)
        self.steered = problem.drive.steered
        self.row = float(np.median(np.diff(problem.log["time_s"])))
        self.noise = fit.noise[: len(self.channels)]  # of the first log
        self.scales = [
            scale_of(w, [problem.speed, local_range(problem.nominal[c])])
            for w, c in zip(self.noise, self.channels, strict=True)
        ]
        self.runs = menu(problem, limits_of(problem), self.row)

    def nats(self, run: Run, tied: Mapping[str, Fit]) -> Nats:
        """Return by how much a run tells each two of some fits apart."""
        legs = {a: [self.leg(run, leg, f) for leg in run.legs] for a, f in tied.items()}
        shared = self.signals(run, next(iter(tied.values())), legs[next(iter(tied))])
        each: dict[frozenset[str], float] = {}
        for a, b in permutations(tied, 2):
            d = self.between(run, legs[a], tied[a], tied[b])
            own = [k for k in tied[b].knobs if k.key not in shared]
            A = shared | self.signals(run, tied[b], legs[a], own)
            nats = CURVATURE * told(d, A, tied[b])
            each[frozenset((a, b))] = min(nats, each.get(frozenset((a, b)), np.inf))
        pairs = tuple(Pair(min(p), max(p), x) for p, x in each.items())
        return Nats(min(each.values()), pairs)

    def narrows(self, run: Run, fit: Fit, keys: Sequence[str]) -> float:
        """Return log of the ratio of the sd of figures before and after a run."""
        A = self.signals(run, fit, [self.leg(run, leg, fit) for leg in run.legs])
        before = precision(fit, A)
        names, M = columns(fit, A)
        after = before + CURVATURE * M.T @ M
        places = [names.index(k) for k in keys]
        ratio = [_variance(before, i) / _variance(after, i) for i in places]
        return 0.5 * float(np.log(max(ratio)))

    def leg(self, run: Run, leg: Leg, fit: Fit) -> Problem:
        """Return the log of a leg, without noise, if a fit is the truth."""
        columns = {"time_s": leg.time, self.level: leg.level}
        if self.steered:
            columns["steer_cmd_rad"] = leg.steer
        settings = at_place(self.vehicle, figures_of(fit.values), run.where, leg.back)
        first = drive_of(Trace(columns), self.vehicle, self.window)
        out = replay(self.vehicle.changed(settings=settings), first)
        seen = {c: out[c] for c in (*self.channels, "speed_mps", "yaw_rate_radps")}
        log = Trace(seen | columns, name=run.do)
        return Problem(self.vehicle, log, drive_of(log, self.vehicle, self.window))

    def seen(
        self, run: Run, leg: Leg, log: Problem, values: dict[str, float]
    ) -> list[Array]:
        """Return what some figures predict of a leg, channel by channel."""
        settings = at_place(self.vehicle, figures_of(values), run.where, leg.back)
        out = log.predict(settings, coarse=True)  # for differences alone
        return [out[c] for c in self.channels]

    def between(self, run: Run, logs: Sequence[Problem], a: Fit, b: Fit) -> Array:
        """Return what two fits predict apart, whitened, on the logs of the one."""
        return self.change(run, logs, a.values, b.values)

    def change(
        self,
        run: Run,
        logs: Sequence[Problem],
        a: dict[str, float],
        b: dict[str, float],
    ) -> Array:
        """Return what other figures change, whitened, a channel of a leg at a time."""
        parts = []
        for leg, log in zip(run.legs, logs, strict=True):
            pairs = zip(
                self.seen(run, leg, log, b), self.seen(run, leg, log, a), strict=True
            )
            parts.append(self.white(log, [x - y for x, y in pairs]))
        return np.concatenate(parts)

    def white(self, log: Problem, tracks: Sequence[Array]) -> Array:
        """Return changes of the channels in units of the log's noise."""
        judged = dict(zip(log.channels, log.judged, strict=True))
        parts = []
        for c, w, shares, x in zip(
            self.channels, self.noise, self.scales, tracks, strict=True
        ):
            parts_of = [np.ones(len(x)), log.speed**2, local_range(log.log[c]) ** 2]
            scale = np.sqrt(shares @ np.stack(parts_of))
            valid = judged.get(c, np.ones(len(x), bool)) & np.isfinite(x)
            parts.append(replace(w, scale=scale, valid=valid)(np.nan_to_num(x)))
        return np.concatenate(parts)

    def signals(
        self,
        run: Run,
        fit: Fit,
        logs: Sequence[Problem],
        knobs: Sequence[Knob] | None = None,
    ) -> dict[str, Array]:
        """Return the whitened signal of each knob of a fit in a run."""
        found = {}
        for k in fit.knobs if knobs is None else knobs:
            if k.key.startswith(BIAS):
                if k.key.startswith(f"{BIAS}0."):
                    found[k.key] = self.offset(logs, k.key.removeprefix(f"{BIAS}0."))
                continue
            if run.where == STAND and k.key == "body.mass_kg":
                continue
            h = k.stride if fit.values[k.key] + k.stride <= k.high else -k.stride
            moved = {**fit.values, k.key: fit.values[k.key] + h}
            found[k.key] = self.change(run, logs, fit.values, moved) / h
        if run.where == STAND and knobs is None:
            moved = {**fit.values, ON_STAND: 1.0 + WHEELS_SD}
            found[ON_STAND] = self.change(run, logs, fit.values, moved) / WHEELS_SD
        return found

    def offset(self, logs: Sequence[Problem], column: str) -> Array:
        """Return what an offset of one sensor changes."""
        parts = []
        for log in logs:
            one = np.ones(len(log.speed))
            parts.append(self.white(log, [one * (c == column) for c in self.channels]))
        return np.concatenate(parts)


def scale_of(noise: Whitener, grows_with: Sequence[Array]) -> Array:
    """Return the shares of 1 and of squares whose sum is the square of a scale."""
    X = np.stack([np.ones(len(noise.scale)), *(g**2 for g in grows_with)], axis=1)
    unit = np.maximum(np.abs(X).max(axis=0), 1e-300)
    found, *_ = np.linalg.lstsq(X / unit, noise.scale**2, rcond=1e-12)
    shares: Array = np.maximum(found / unit, [1e-6, 0.0, 0.0])
    return shares


def columns(fit: Fit, signals: Mapping[str, Array]) -> tuple[list[str], Array]:
    """Return names and signals: of the fit's knobs, then of offsets met anew."""
    zero = np.zeros_like(next(iter(signals.values())))
    names = [k.key for k in fit.knobs]
    there = [zero if n.startswith(BIAS) else signals.get(n, zero) for n in names]
    new = [n for n in signals if n.startswith(BIAS) or n == ON_STAND]
    return names + new, np.stack(there + [signals[n] for n in new], axis=1)


def precision(fit: Fit, signals: Mapping[str, Array]) -> Array:
    """Return what is known beforehand of the figures that signals belong to."""
    sds = {k.key: k.sd for k in fit.knobs} | {ON_STAND: WHEELS_SD}
    new = [n for n in signals if n.startswith(BIAS) or n == ON_STAND]
    size = len(fit.knobs)
    P = np.zeros((size + len(new), size + len(new)))
    P[:size, :size] = fit.information / INTERVAL**2
    P[range(size, len(P)), range(size, len(P))] = [1 / sds[n] ** 2 for n in new]
    return P


def told(d: Array, signals: Mapping[str, Array], fit: Fit) -> float:
    """Nats that a difference is worth once the figures of a fit give way."""
    _, A = columns(fit, signals)
    N = precision(fit, signals) + A.T @ A
    g = A.T @ d
    unit = 1 / np.sqrt(np.diag(N) + 1e-300)
    x = np.linalg.solve(N * np.outer(unit, unit) + 1e-10 * np.eye(len(N)), g * unit)
    return max(0.5 * float(d @ d - (g * unit) @ x), 0.0)


def _variance(P: Array, i: int) -> float:
    unit = 1 / np.sqrt(np.diag(P) + 1e-300)
    inverse = np.linalg.inv(P * np.outer(unit, unit) + 1e-10 * np.eye(len(P)))
    return float(inverse[i, i] * unit[i] ** 2)
