r"""Nats by which a run tells hypotheses apart.

The run is driven by the vehicle under each hypothesis at its fitted
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

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import permutations
from math import inf

import numpy as np
from numpy.typing import NDArray

from rcc_sim.analyse.heading import TURN_RATE, turn_rate
from rcc_sim.diagnose.fitting.engine import Engine
from rcc_sim.diagnose.fitting.fit import Fit, of_unit_diagonal
from rcc_sim.diagnose.fitting.knobs import BIAS, Knob, figures_of
from rcc_sim.diagnose.judge.asserted import INTERVAL
from rcc_sim.diagnose.next_run.limits import level_column, limits_of
from rcc_sim.diagnose.next_run.menu import (
    STAND,
    Leg,
    Run,
    at_place,
    menu,
)
from rcc_sim.diagnose.noise.whitener import CURVATURE, Whitener, local_range
from rcc_sim.diagnose.residuals.problem import WHEELS, WHEELS_SD, Problem
from rcc_sim.errors import InputError
from rcc_sim.side_by_side import each
from rcc_sim.simulate.drive import drive_of
from rcc_sim.simulate.replay import replay
from rcc_sim.trace import Trace

Array = NDArray[np.float64]

FIRST = f"{BIAS}0."
"""Key of an offset in the first log."""


NIL = 1e-290
"""Precision below which nothing is known of a figure."""

SURE = 10.0
"""Nats at which a pair is settled: odds of twenty thousand to one."""


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

    @property
    def worth(self) -> float:
        """Nats of all pairs; those of one count no further than it is settled by."""
        return self.beside(())

    def beside(self, parted: Collection[tuple[str, str]]) -> float:
        """The same of the pairs that are not parted yet."""
        return sum(min(p.nats, SURE) for p in self.pairs if (p.a, p.b) not in parted)


@dataclass(frozen=True)
class Seen:
    """The log of a leg, and by what noise its channels would be judged.

    Parameters
    ----------
    problem : Problem
        The log.
    noise : list of Whitener
        Of each channel.
    counted : list of ndarray of bool
        Rows of each channel that count.
    beside : callable
        What tells the tracks of these channels apart (`Problem.beside_in`).
    """

    problem: Problem
    noise: list[Whitener]
    counted: list[NDArray[np.bool_]]
    beside: Callable[[Sequence[Array]], list[Array]]

    def white(self, tracks: Sequence[Array]) -> Array:
        """Return changes of the channels in units of the noise."""
        told = self.beside(tracks)
        return np.concatenate(
            [
                w(np.where(ok & np.isfinite(x), x, 0.0))
                for w, ok, x in zip(self.noise, self.counted, told, strict=True)
            ]
        )


@dataclass(frozen=True)
class Driven:
    """A run driven under each hypothesis.

    Parameters
    ----------
    run : Run
        What was driven.
    logs : dict
        Hypothesis -> the log of each leg if it is true.
    apart : dict
        What the one and the other predict apart on the logs of the one, whitened.
    """

    run: Run
    logs: dict[str, list[Seen]]
    apart: dict[tuple[str, str], Array]

    @property
    def most(self) -> float:
        """What the run's worth cannot exceed, as if no figure gave way."""
        each: dict[frozenset[str], float] = {}
        for pair, d in self.apart.items():
            nats = 0.5 * CURVATURE * self.run.times * float(d @ d)
            each[frozenset(pair)] = min(nats, each.get(frozenset(pair), SURE))
        return sum(each.values())


class Bench:
    """Drives runs with the vehicle of a log, as its sensors would see them."""

    def __init__(self, engine: Engine, fit: Fit) -> None:
        self.engine = engine
        problem = engine.problems[0]
        self.vehicle, self.window = problem.vehicle, problem.drive.window
        self.channels = problem.channels
        self.level = level_column(problem)
        self.steered = problem.drive.steered
        self.row = problem.row
        self.noise = fit.noise[: len(self.channels)]  # of the first log
        self.scales = [
            scale_of(w, [problem.speed, local_range(problem.nominal[c])])
            for w, c in zip(self.noise, self.channels, strict=True)
        ]
        self.runs = menu(problem, limits_of(problem), self.row)

    def drive(self, tied: Mapping[str, Fit]) -> Callable[[Run], Driven | None]:
        """Return what drives a run under each of some fits."""

        def drive(run: Run) -> Driven | None:
            try:
                logs = {
                    a: [self.leg(run, leg, f) for leg in run.legs]
                    for a, f in tied.items()
                }
                start = {a: self.seen(run, logs[a], f.values) for a, f in tied.items()}
                apart = {
                    (a, b): self.change(run, logs[a], start[a], tied[b].values)
                    for a, b in permutations(tied, 2)
                }
            except InputError:  # a run that no such vehicle can drive
                return None
            return Driven(run, logs, apart)

        return drive

    def nats(self, driven: Driven, tied: Mapping[str, Fit]) -> Nats | None:
        """Return by how much a run tells each two of some fits apart.

        None if no vehicle with figures a little off could drive it.
        """
        try:
            return self._nats(driven, tied)
        except InputError:
            return None

    def _nats(self, driven: Driven, tied: Mapping[str, Fit]) -> Nats:
        """The signals of the figures that all have are taken from the first."""
        run, logs = driven.run, driven.logs
        first = next(iter(tied))
        shared = self.signals(run, tied[first], logs[first])
        own = {
            b: self.signals(
                run, f, logs[first], [k for k in f.knobs if k.key not in shared]
            )
            for b, f in tied.items()
        }
        told = {b: Told(shared | own[b], f, run.times) for b, f in tied.items()}
        each: dict[tuple[str, str], float] = {}
        for (a, b), d in driven.apart.items():
            nats = CURVATURE * told[b](d)
            pair = (min(a, b), max(a, b))
            each[pair] = min(nats, each.get(pair, np.inf))
        return Nats(
            min(each.values()), tuple(Pair(a, b, x) for (a, b), x in each.items())
        )

    def narrows(self, run: Run, fit: Fit, keys: Sequence[str]) -> float:
        """Return log of the ratio of the sd of figures before and after a run."""
        A = self.signals(run, fit, [self.leg(run, leg, fit) for leg in run.legs])
        before = precision(fit, A)
        names, M = columns(fit, A)
        after = before + run.times * CURVATURE * M.T @ M
        places = [names.index(k) for k in keys]
        ratio = [_variance(before, i) / _variance(after, i) for i in places]
        return 0.5 * float(np.log(max(ratio)))

    def leg(self, run: Run, leg: Leg, fit: Fit) -> Seen:
        """Return the log of a leg, without noise, if a fit is the truth."""
        columns = {"time_s": leg.time, self.level: leg.level}
        if leg.back:
            columns["direction"] = np.full(len(leg.time), -1.0)
        if run.where == STAND:
            columns["on_stand"] = np.ones(len(leg.time))
        if self.steered:
            columns["steer_cmd_rad"] = leg.steer
        settings = at_place(self.vehicle, figures_of(fit.values), run.where)
        first = drive_of(Trace(columns), self.vehicle, self.window)
        out = replay(self.vehicle.changed(settings=settings), first, coarse=True)
        if TURN_RATE in self.channels:
            out[TURN_RATE] = turn_rate(out["time_s"], out["yaw_rad"])
        seen = {c: out[c] for c in (*self.channels, "speed_mps", "yaw_rate_radps")}
        log = Trace(seen | columns, name=run.do)
        drive = drive_of(log, self.vehicle, self.window)
        problem = Problem(self.vehicle, log, drive)
        noise = [self.noise_of(problem, k, c) for k, c in enumerate(self.channels)]
        # what never changes tells of an offset all the same
        every = np.ones(len(leg.time), bool)
        counted = [problem.known(c) if np.ptp(log[c]) else every for c in self.channels]
        return Seen(problem, noise, counted, problem.beside_in(self.channels))

    def noise_of(self, log: Problem, k: int, channel: str) -> Whitener:
        """Return the noise of a channel in a log without any."""
        x = log.log[channel]
        parts = [np.ones(len(x)), log.speed**2, local_range(x) ** 2]
        scale = np.sqrt(self.scales[k] @ np.stack(parts))
        every = np.ones(len(x), bool)  # logs of two hypotheses judge other rows
        return replace(self.noise[k], scale=scale, valid=every, drift=None, rest=None)

    def seen(
        self, run: Run, logs: Sequence[Seen], values: dict[str, float]
    ) -> list[list[Array]]:
        """Return what some figures predict of each leg, channel by channel."""
        settings = at_place(self.vehicle, figures_of(values), run.where)
        legs = []
        for log in logs:
            out = log.problem.predict(settings, coarse=True)  # for differences alone
            legs.append([out[c] for c in self.channels])
        return legs

    def change(
        self,
        run: Run,
        logs: Sequence[Seen],
        start: list[list[Array]],
        values: dict[str, float],
    ) -> Array:
        """Return what other figures change, whitened, a channel of a leg at a time."""
        legs = zip(logs, self.seen(run, logs, values), start, strict=True)
        return np.concatenate(
            [
                log.white([x - y for x, y in zip(new, old, strict=True)])
                for log, new, old in legs
            ]
        )

    def signals(
        self,
        run: Run,
        fit: Fit,
        logs: Sequence[Seen],
        knobs: Sequence[Knob] | None = None,
    ) -> dict[str, Array]:
        """Return the whitened signal of each knob of a fit in a run."""
        wanted = list(fit.knobs if knobs is None else knobs)
        if run.where == STAND:
            wanted = [k for k in wanted if k.key != "body.mass_kg"]
            if knobs is None:
                wanted.append(Knob(WHEELS, 1.0, WHEELS_SD, step=WHEELS_SD))
        wanted = [
            k for k in wanted if not k.key.startswith(BIAS) or k.key.startswith(FIRST)
        ]

        if not wanted:
            return {}
        start = self.seen(run, logs, fit.values)

        def one(k: Knob) -> Array:
            if k.key.startswith(FIRST):
                return self.offset(logs, k.key.removeprefix(FIRST))
            x = fit.values.get(k.key, k.value)
            h = k.inward(x)
            return self.change(run, logs, start, {**fit.values, k.key: x + h}) / h

        signals = each(one, wanted)
        return {k.key: signal for k, signal in zip(wanted, signals, strict=True)}

    def offset(self, logs: Sequence[Seen], what: str) -> Array:
        """Return what an offset of one sensor changes, or a shape of size 1.

        A gain, or a reading that is late, is no surer in a log that is yet to come.
        """
        parts = []
        for log in logs:
            one = np.ones(len(log.problem.speed))
            shape = log.problem.shapes.get(what)
            if shape is None:
                tracks = [one * (c == what) for c in self.channels]
            else:
                known = dict(zip(log.problem.channels, shape.tracks, strict=True))
                tracks = [known.get(c, 0.0 * one) for c in self.channels]
            parts.append(log.white(tracks))
        return np.concatenate(parts)


def scale_of(noise: Whitener, grows_with: Sequence[Array]) -> Array:
    """Return the shares of 1 and of squares whose sum is the square of a scale."""
    X = np.stack([np.ones(len(noise.scale)), *(g**2 for g in grows_with)], axis=1)
    unit = np.maximum(np.abs(X).max(axis=0), 1e-300)
    moves = slice(None) if noise.rest is None else ~noise.rest.at
    found, *_ = np.linalg.lstsq(X[moves] / unit, noise.scale[moves] ** 2, rcond=1e-12)
    shares: Array = np.maximum(found / unit, [1e-6, 0.0, 0.0])
    return shares


def columns(fit: Fit, signals: Mapping[str, Array]) -> tuple[list[str], Array]:
    """Return names and signals: of the fit's knobs, then of offsets met anew."""
    zero = np.zeros_like(next(iter(signals.values())))
    names = [k.key for k in fit.knobs]
    there = [zero if n.startswith(BIAS) else signals.get(n, zero) for n in names]
    new = [n for n in signals if n.startswith(BIAS) or n == WHEELS]
    return names + new, np.stack(there + [signals[n] for n in new]).T


def precision(fit: Fit, signals: Mapping[str, Array]) -> Array:
    """Return what is known beforehand of the figures that signals belong to."""
    sds = {k.key: k.sd for k in fit.knobs} | {WHEELS: WHEELS_SD}
    new = [n for n in signals if n.startswith(BIAS) or n == WHEELS]
    size = len(fit.knobs)
    P = np.zeros((size + len(new), size + len(new)))
    P[:size, :size] = fit.information / INTERVAL**2
    P[range(size, len(P)), range(size, len(P))] = [1 / sds[n] ** 2 for n in new]
    return P


class Told:
    """Nats that differences are worth, seen some times, once the figures give way."""

    def __init__(self, signals: Mapping[str, Array], fit: Fit, times: int = 1) -> None:
        _, self.A = columns(fit, signals)
        self.times = times
        N = precision(fit, signals) + times * self.A.T @ self.A
        self.N, self.unit = of_unit_diagonal(N)

    def __call__(self, d: Array) -> float:
        """Return the nats of one difference."""
        g = self.times * (self.A.T @ d) * self.unit
        x = np.linalg.solve(self.N, g)
        return max(0.5 * float(self.times * (d @ d) - g @ x), 0.0)


def _variance(P: Array, i: int) -> float:
    """Return the variance of a figure by the precision P of all; inf where nil."""
    if P[i, i] < NIL:
        return inf
    unit = 1 / np.sqrt(np.maximum(np.diag(P), NIL))
    inverse = np.linalg.inv(P * np.outer(unit, unit) + 1e-10 * np.eye(len(P)))
    return float(inverse[i, i] * unit[i] ** 2)
