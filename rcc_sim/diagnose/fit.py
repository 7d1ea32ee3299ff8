"""Figures that a log asks for: Gauss-Newton on whitened residuals, with priors."""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field, replace
from math import inf

import numpy as np
from numpy.typing import NDArray

from rcc_sim.diagnose.noise import (
    Whitener,
    fit_whitener,
    lag_edges,
    log_likelihood,
    weights,
)
from rcc_sim.diagnose.problem import Problem

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Knob:
    """A figure that a fit may move."""

    key: str
    value: float
    sd: float = inf
    low: float = -inf
    high: float = inf
    step: float = 0.0

    @property
    def stride(self) -> float:
        """Step of a finite difference."""
        if self.step:
            return self.step
        return 0.5 * self.sd if np.isfinite(self.sd) else 1e-3 * (abs(self.value) or 1)


@dataclass
class Fit:
    values: dict[str, float]
    loglik: float
    prior: float
    whiteners: list[Whitener]
    residual: Array
    information: Array | None = None
    signals: Array | None = None
    knobs: tuple[Knob, ...] = ()

    @property
    def score(self) -> float:
        return self.loglik + self.prior


def local_range(x: Array, rows: int = 7) -> Array:
    """How far a channel moves within some rows: where timing matters."""
    from scipy.ndimage import maximum_filter1d, minimum_filter1d

    x = np.where(np.isfinite(x), x, 0.0)
    return maximum_filter1d(x, rows) - minimum_filter1d(x, rows)


class Engine:
    """Simulates, whitens and fits, on one log."""

    def __init__(self, problem: Problem, rows=None, memory=3.0):
        self.problem = problem
        self.pool = ThreadPoolExecutor(2)
        t = problem.log["time_s"]
        self.edges = lag_edges(1 / float(np.median(np.diff(t))), memory, len(t))
        self.speed = np.abs(problem.drive.measured[0])
        self.speed = np.where(np.isfinite(self.speed), self.speed, 0.0)
        self.rows = np.ones(len(t), bool) if rows is None else rows
        self.sims = 0
        self.unrest = [
            local_range(problem.log[c] * 0 + problem.nominal[c])
            for c in problem.channels
        ]

    def residual(self, values: dict[str, float]) -> Array:
        self.sims += 1
        car = {k: v for k, v in values.items() if not k.startswith("bias.")}
        e = self.problem.residual(car)
        for i, c in enumerate(self.problem.channels):
            e[i] -= values.get(f"bias.{c}", 0.0)
        return e

    def valid(self, e: Array) -> Array:
        out = np.isfinite(e) & self.rows
        out[:, 0] = False
        for i, c in enumerate(self.problem.channels):
            if c in ("yaw_rate_radps", "accel_y_mps2"):
                out[i] &= self.speed > self.problem.slow
        return out

    def noise(self, e: Array) -> list[Whitener]:
        return [
            fit_whitener(x, ok, [self.speed, self.unrest[i]], self.edges)
            for i, (x, ok) in enumerate(zip(e, self.valid(e), strict=True))
        ]

    def loglik(self, e: Array, whiteners: list[Whitener]) -> float:
        return sum(log_likelihood(w, x) for w, x in zip(whiteners, e, strict=True))

    def white(self, e: Array, whiteners: list[Whitener]) -> Array:
        return np.concatenate([w(x) for w, x in zip(whiteners, e, strict=True)])

    def prior(self, knobs, values) -> float:
        return -0.5 * sum(
            ((values[k.key] - k.value) / k.sd) ** 2 for k in knobs if np.isfinite(k.sd)
        )

    def evaluate(self, values, knobs, whiteners=None) -> Fit:
        e = self.residual(values)
        whiteners = whiteners or self.noise(e)
        return Fit(
            dict(values),
            self.loglik(e, whiteners),
            self.prior(knobs, values),
            whiteners,
            e,
            None,
            None,
            tuple(knobs),
        )

    def signals(self, values, knobs, base: Array) -> Array:
        """d(residual)/d(knob) per knob: (knobs, channels, n)."""

        def one(k):
            if k.key.startswith("bias."):
                d = np.zeros_like(base)
                d[self.problem.channels.index(k.key[5:])] = -1.0
                return d
            h = k.stride
            if values[k.key] + h > k.high:
                h = -h
            return (self.residual({**values, k.key: values[k.key] + h}) - base) / h

        each = map(one, knobs) if len(knobs) < 4 else self.pool.map(one, knobs)
        return np.stack(list(each))

    def fit(
        self,
        start: dict[str, float],
        knobs: Sequence[Knob],
        *,
        noise: list[Whitener] | None = None,
        signals: Array | None = None,
        rounds: int = 6,
    ) -> Fit:
        """Maximum a posteriori under given noise, else under the noise it leaves.

        The signals of the knobs are found anew at the start and after the first
        step, unless they are given.
        """
        values = {**{k.key: k.value for k in knobs}, **start}
        if noise is None:
            now = self.evaluate(values, knobs)
            for passes in (2, 2, rounds):
                now = self.fit(now.values, knobs, noise=now.whiteners, rounds=passes)
                learnt = self.noise(now.residual)
                now = replace(
                    now,
                    whiteners=learnt,
                    loglik=self.loglik(now.residual, learnt),
                )
            return now
        now = self.evaluate(values, knobs, noise)
        J = signals
        for turn in range(rounds):
            if signals is None and turn in (0, 1, 3):
                J = self.signals(now.values, knobs, now.residual)
            step, H = self.step(now, knobs, J)
            now.information, now.signals = H, J
            new = self.line_search(now, knobs, step, noise)
            if new is None:
                break
            gain = new.score - now.score
            new.information, new.signals = H, J
            now = new
            if gain < 0.05 and turn > 0:
                break
        return now

    def line_search(self, now: Fit, knobs, step: Array, noise) -> Fit | None:
        """The first of ever shorter steps that is better, if any is."""
        for share in (1.0, 0.4, 0.1):
            trial = dict(now.values)
            for k, s in zip(knobs, step, strict=True):
                trial[k.key] = float(np.clip(trial[k.key] + share * s, k.low, k.high))
            new = self.evaluate(trial, knobs, noise)
            if new.score > now.score:
                return new
        return None

    def step(self, now, knobs, J):
        sd = np.array([k.sd for k in knobs])
        w = self.white(now.residual, now.whiteners)
        A = np.stack([self.white(j, now.whiteners) for j in J], axis=1)
        W = weights(w)
        H = (A.T * W) @ A + np.diag(1 / sd**2)
        off = np.array([(now.values[k.key] - k.value) / k.sd**2 for k in knobs])
        g = A.T @ (W * w) + off
        unit = 1 / np.sqrt(np.diag(H) + 1e-300)
        return -unit * np.linalg.solve(
            H * np.outer(unit, unit) + 1e-9 * np.eye(len(H)), g * unit
        ), H


def tolerance_knobs(problem: Problem) -> list[Knob]:
    knobs = []
    for key, figure in problem.vehicle.figures().items():
        sd = figure.sd
        if not sd and figure.low is not None and figure.high is not None:
            sd = (figure.high - figure.low) / 3.29
        if sd > 0:
            knobs.append(
                Knob(
                    key,
                    figure.value,
                    sd,
                    low=figure.value - 6 * sd
                    if figure.value - 6 * sd > 0
                    else 0.05 * figure.value,
                )
            )
    return knobs


BIAS = 0.5
"""Constant offset of a sensor that its noise leaves likely, in times that noise."""


def bias_knobs(problem: Problem) -> list[Knob]:
    """An offset for each sensor but the motor's encoder, which counts."""
    return [
        Knob(f"bias.{c}", 0.0, BIAS * noise)
        for c in problem.channels
        if c != "speed_mps" and (noise := quiet_noise(problem.log[c])) > 0
    ]


def quiet_noise(x: Array) -> float:
    """Noise of a sensor, from the calmest tenth of its record."""
    d = np.diff(x)
    d = d[np.isfinite(d)]
    if len(d) < 40:
        return float(np.std(d)) / np.sqrt(2) if len(d) else 0.0
    parts = np.array_split(d, 30)
    sizes = [float(np.sqrt(np.mean((part - part.mean()) ** 2))) for part in parts]
    return float(np.quantile(sizes, 0.1)) / np.sqrt(2)
