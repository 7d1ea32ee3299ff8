"""The model beside one or more logs: what figures leave of them, and how likely."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from math import inf, isfinite

import numpy as np
from numpy.typing import NDArray

from rcc_sim.analyse.heading import TURN_RATE
from rcc_sim.analyse.offsets import OFFSETS, noise_at_rest
from rcc_sim.channel import is_rough, resolution
from rcc_sim.diagnose.fitting.fit import Fit, Tangent
from rcc_sim.diagnose.fitting.knobs import BIAS, Knob, figures_of
from rcc_sim.diagnose.noise.whitener import (
    SHORT,
    Whitener,
    at_rest,
    fit_whitener,
    lag_edges,
    local_range,
    log_density,
    log_likelihood,
)
from rcc_sim.diagnose.residuals.problem import MIN_ROWS, Problem
from rcc_sim.diagnose.residuals.shapes import added_by
from rcc_sim.errors import InputError
from rcc_sim.side_by_side import each

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

MEMORY = 3.0
"""Time over which the noise may remember, a rough road's above all. [s]"""

INEXACT = 3e-4
"""Noise below which no channel is judged, as a share of its largest value: no model is
more exact than that."""

NOISELESS = 2e-3
"""The same for a channel without noise, as a simulated log has: there each launch that
is a tick late would outweigh the drive."""

GIVEN = ("battery_power_w", "battery_current_a")
"""Channels that at rest tell what the auxiliaries draw, whatever the vehicle is."""

ALIKE = 1.0
"""Time over which readings at rest tell no more than one. [s]"""

STRETCHES = 25
"""Stretches of a log over which gains are told apart."""

WIDER = (1.0, 10.0, 100.0)
"""Times by which the step along a figure that is to be found widens until it changes
something: a threshold may move between two ticks and change nothing."""


class Engine:
    """The model and one or more logs of the same vehicle.

    Parameters
    ----------
    problems : sequence of Problem
        The logs; all are explained at once.
    """

    def __init__(self, problems: Sequence[Problem]) -> None:
        self.problems = tuple(problems)
        self.vehicle = problems[0].vehicle
        self.tracks = [(i, c) for i, p in enumerate(problems) for c in p.channels]
        self.valid, self.grows_with, self.edges, self.least = [], [], [], []
        self.memory: list[Array | None] = []
        self.stands: list[Mask | None] = []
        self.added: dict[str, dict[int, Array | float]] = {}
        for p in problems:
            t = p.log["time_s"]
            for c, ok in zip(p.channels, p.judged, strict=True):
                self.valid.append(ok)
                grows = [p.speed, local_range(p.nominal[c]), *p.unsure]
                counts = c == "speed_mps" and len(t) < SHORT
                self.grows_with.append([] if counts else grows)
                most = float(np.nanmax(np.abs(p.log[c])))
                noisy = (
                    is_rough(p.log[c]) or INEXACT * most < noise_at_rest(p.log, c) < inf
                )
                rounding = resolution(p.log[c]) / 12**0.5
                self.least.append(
                    max((INEXACT if noisy else NOISELESS) * most, rounding)
                )
                edges = lag_edges(1 / p.row, MEMORY, len(t))
                self.edges.append([] if counts else edges)
                self.memory.append(
                    remembered(p, c, self.grows_with[-1], self.edges[-1])
                )
                told = c in GIVEN and p.drive.imposed and p.charge is None
                counted = [(ok & at).sum() for at in (p.at_rest, ~p.at_rest)]
                told = told and edges != [0] and min(counted) >= MIN_ROWS
                self.stands.append(p.at_rest if told else None)

    def stated(self, key: str) -> float:
        """Return what the vehicle file says of a figure, or what it is without."""
        return self.problems[0].stated(key)

    def residuals(self, values: dict[str, float], coarse: bool = False) -> list[Array]:
        """Measured minus predicted, a track each.

        Coarse: for differences alone, in which offsets, the same in both, are nil.
        """
        found = [
            e
            for i, p in enumerate(self.problems)
            for e in p.residuals(figures_of(values, i), coarse)
        ]
        for key in (k for k in values if k.startswith(BIAS) and not coarse):
            for track, x in self.offset(key).items():
                found[track] = found[track] - values[key] * x
        return found

    def offset(self, key: str) -> dict[int, Array | float]:
        """What size 1 adds to each track: an offset, or a shape of its own."""
        if key not in self.added:
            log, _, what = key.removeprefix(BIAS).partition(".")
            mine = [k for k, (i, _) in enumerate(self.tracks) if i == int(log)]
            found = added_by(self.problems[int(log)], what)
            self.added[key] = {mine[k]: x for k, x in found.items()}
        return self.added[key]

    def learn_noise(self, residuals: list[Array]) -> list[Whitener]:
        """Noise model of each track, from what a fit leaves."""
        return self.learn_noise_of(range(len(self.tracks)), residuals)

    def learn_noise_of(
        self, tracks: Sequence[int], left: Sequence[Array]
    ) -> list[Whitener]:
        """Noise model of some tracks, from what is left in them."""
        left_in = dict(zip(tracks, left, strict=True))
        sought = {TURN_RATE, *(c for columns in OFFSETS.values() for c in columns)}

        def one(i: int) -> Whitener:
            e, valid = left_in[i], self.valid[i]
            if self.tracks[i][1] in sought and valid.any():
                # a noise that remembers would take an offset that is to be found; a
                # heading does not wander off at a rate that stays
                e = e - float(np.mean(e[valid]))
            known = (self.grows_with[i], self.edges[i], self.least[i], self.memory[i])
            stands = self.stands[i]
            if stands is None:
                return fit_whitener(e, valid, *known)
            moving = fit_whitener(e, valid & ~stands, *known)
            row = self.problems[self.tracks[i][0]].row
            return at_rest(moving, e, valid, stands, max(ALIKE / row, 1.0))

        return each(one, tracks)

    def loglik(self, residuals: list[Array], noise: list[Whitener]) -> float:
        """Log-likelihood of residuals."""
        pairs = zip(noise, residuals, strict=True)
        found = sum(log_likelihood(w, e) for w, e in pairs)
        return found if isfinite(found) else -inf  # a run that went astray

    def gains(self, less: Fit, more: Fit) -> Array:
        """Nats by which one fit is likelier than another, by stretch of each log.

        Both are judged by the noise of the second; what priors add counts nowhere.
        """
        found = np.zeros((len(self.problems), STRETCHES))
        tracks = zip(
            self.tracks, more.noise, less.residuals, more.residuals, strict=True
        )
        for (log, _), w, a, b in tracks:
            t = self.problems[log].log["time_s"][w.valid]
            if not len(t):
                continue
            edges = np.linspace(t[0], t[-1], STRETCHES + 1)[1:-1]
            each = log_density(w(b)) - log_density(w(a))
            found[log] += np.bincount(np.searchsorted(edges, t), each, STRETCHES)
        return found.ravel()

    @staticmethod
    def white(tracks: Sequence[Array], noise: list[Whitener]) -> Array:
        """All tracks, whitened, one after the other."""
        pairs = zip(noise, tracks, strict=True)
        return np.concatenate([w(e) for w, e in pairs])

    def evaluate(
        self,
        values: dict[str, float],
        knobs: Iterable[Knob],
        noise: list[Whitener] | None = None,
    ) -> Fit:
        """Judge some figures, under given noise or under what they leave."""
        e = self.residuals(values)
        noise = noise or self.learn_noise(e)
        knobs = tuple(knobs)
        prior = -0.5 * sum(
            ((values[k.key] - k.value) / k.sd) ** 2 for k in knobs if np.isfinite(k.sd)
        )
        return Fit(dict(values), knobs, self.loglik(e, noise), prior, noise, e)

    def judged(self, fit: Fit, noise: list[Whitener]) -> Fit:
        """Return the same figures judged under another noise."""
        return replace(fit, noise=noise, loglik=self.loglik(fit.residuals, noise))

    def attempt(
        self, values: dict[str, float], knobs: Sequence[Knob], noise: list[Whitener]
    ) -> Fit | None:
        """Evaluate; None for figures that no such vehicle can have together."""
        try:
            return self.evaluate(values, knobs, noise)
        except InputError:
            return None

    def at(self, fit: Fit, values: dict[str, float]) -> Fit | None:
        """Return a fit at other figures, its knobs, noise and signals as they are.

        None for figures that no such vehicle can have together.
        """
        there = self.attempt(values, fit.knobs, fit.noise)
        if there is None:
            return None
        return replace(there, signals=fit.signals, information=fit.information)

    def signals(
        self, values: dict[str, float], knobs: Sequence[Knob]
    ) -> list[list[Array]]:
        """d(residual)/d(knob) by re-simulation, per knob and track.

        Nil where no vehicle can have the figure a little larger, nor smaller.
        """

        def moved(k: Knob | None, wider: float = WIDER[0]) -> tuple[float, list[Array]]:
            if k is None:
                return 0.0, self.residuals(values, coarse=True)
            try:
                return self.aside(values, k, k.inward(values[k.key], wider))
            except InputError:
                return 0.0, []

        run = [k for k in knobs if not k.key.startswith(BIAS)]
        (_, base), *beside = each(moved, [None, *run])
        first = {k.key: there for k, there in zip(run, beside, strict=True)}

        def change(h: float, there: list[Array]) -> list[Array]:
            if not h:  # none is possible, or it is too small for the figure to change
                return [np.zeros_like(e) for e in base]
            return [1 / h * (a - b) for a, b in zip(there, base, strict=True)]

        def one(k: Knob) -> list[Array]:
            if k.key not in first:
                off = self.offset(k.key)
                return [np.zeros_like(e) - off.get(i, 0.0) for i, e in enumerate(base)]
            found = change(*first[k.key])
            for wider in WIDER[1:] if k.sd == inf else ():
                if any(np.nan_to_num(c).any() for c in found):
                    break
                found = change(*moved(k, wider))
            return found

        return each(one, knobs)

    def aside(
        self, values: dict[str, float], knob: Knob, h: float
    ) -> tuple[float, list[Array]]:
        """Return a step of one figure, within its bounds, and what it leaves.

        It is taken the other way where no vehicle can have the figures together.

        Raises
        ------
        InputError
            If none can either way.
        """
        x = values[knob.key]
        there, back = knob.within(x + h), knob.within(x - h)
        try:
            return there - x, self.residuals({**values, knob.key: there}, coarse=True)
        except InputError:
            if back == x:
                raise
            return back - x, self.residuals({**values, knob.key: back}, coarse=True)

    def tangent(
        self, values: dict[str, float], knobs: Sequence[Knob], noise: list[Whitener]
    ) -> Tangent:
        """How residuals change with some knobs."""
        return self.whitened(self.signals(values, knobs), noise)

    def whitened(self, J: list[list[Array]], noise: list[Whitener]) -> Tangent:
        """Signals as they are and whitened."""
        rows = sum(int(w.valid.sum()) for w in noise)
        white = np.empty((len(J), rows))

        def one(i: int) -> None:
            white[i] = self.white(J[i], noise)

        each(one, range(len(J)))
        return Tangent(J, white.T)


def remembered(
    problem: Problem, channel: str, grows_with: list[Array], edges: list[int]
) -> Array | None:
    """Return what a channel's noise remembers, by repeats of the drive if any tell.

    What is missing in the model may look like a noise that remembers; but repeats share
    it, and not their noise.
    """
    apart = problem.noise.get(channel)
    if apart is None or len(edges) < 2:
        return None
    known = np.isfinite(apart)
    if known.sum() < MIN_ROWS:
        return None
    return fit_whitener(apart, known, grows_with, edges).memory
