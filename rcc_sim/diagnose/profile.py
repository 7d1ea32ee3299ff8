"""Causes that vary over a drive: how strong an effect acted, and when.

An effect's signal is what it adds to each channel. Times a window it is what the
effect adds if it acts in that window alone, because the vehicle, drawn to its log,
forgets within a second. The strengths in the windows are then a linear problem, with
a prior on their size and roughness that the log itself scales.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rcc_sim.diagnose.engine import Engine, Fit
from rcc_sim.diagnose.noise import Whitener, weights

Array = NDArray[np.float64]

SIZES = np.logspace(-1, 4, 21)
"""Sizes of a profile that are tried, in times what one window could tell."""

ROUGHNESS = 0.5
"""Size of the change from window to window, in times the size of the profile."""


@dataclass(frozen=True)
class Profile:
    """Strength of an effect over some coordinate, above what a fit holds.

    Parameters
    ----------
    key : str
        Dotted key of the figure that varies.
    along : str
        Coordinate: time_s, distance_m, speed_mps, steer_cmd_rad.
    knots, value, sd : ndarray, shape (k,)
        Coordinate, strength there, standard deviation.
    evidence : float
        Log of the marginal likelihood ratio to no profile. [nats]
    """

    key: str
    along: str
    knots: Array
    value: Array
    sd: Array
    evidence: float

    def at(self, x: Array) -> Array:
        """Strength at a coordinate; the ends hold beyond them."""
        return np.interp(x, self.knots, self.value)

    def clear_at(self, x: Array, times: float = 2.0) -> NDArray[np.bool_]:
        """Tell where the strength is beyond some standard deviations."""
        return np.abs(self.at(x)) > times * np.interp(x, self.knots, self.sd)


def shares(signal: list[Array], noise: list[Whitener]) -> Array:
    """Share of each track in the power of a signal, whitened."""
    power = np.array(
        [float((w(e) ** 2).sum()) for e, w in zip(signal, noise, strict=True)]
    )
    return power / (power.sum() or 1.0)


def overlap(a: Array, b: Array) -> float:
    """Part of two signals that sits in the same tracks: 1 alike, 0 apart."""
    return float(np.minimum(a, b).sum())


def windows(x: Array, knots: Array) -> Array:
    """Piecewise linear windows (n, k) around knots, that sum to 1."""
    i = np.clip(np.searchsorted(knots, x, side="right") - 1, 0, len(knots) - 2)
    part = np.clip((x - knots[i]) / (knots[i + 1] - knots[i]), 0.0, 1.0)
    H = np.zeros((len(x), len(knots)))
    rows = np.arange(len(x))
    H[rows, i] = 1 - part
    H[rows, i + 1] += part
    return H


class Probe:
    """The signal of one figure at a fit, ready to be cut into windows."""

    def __init__(self, engine: Engine, fit: Fit, key: str, size: float) -> None:
        self.engine, self.fit, self.key = engine, fit, key
        base = fit.values.get(key)
        if base is None:
            figure = engine.problems[0].vehicle.figures().get(key)
            base = figure.value if figure else 0.0
        start = engine.residuals(fit.values, coarse=True)
        moved = engine.residuals({**fit.values, key: base + size}, coarse=True)
        pairs = zip(moved, start, strict=True)
        self.signal = [np.nan_to_num((a - b) / size) for a, b in pairs]
        self.tracks = [
            i for i, w in enumerate(fit.noise) if np.any(self.signal[i][w.valid])
        ]

    @property
    def shares(self) -> Array:
        """Share of each track in the signal."""
        return shares(self.signal, self.fit.noise)

    def profile(self, log: int, along: str, x: Array, count: int) -> Profile:
        """Strengths over a coordinate x of one log, and the evidence for them."""
        fit = self.fit
        knots = np.linspace(x.min(), x.max(), count)
        tracks = [i for i in self.tracks if self.engine.tracks[i][0] == log]
        if not tracks or knots[0] == knots[-1]:
            return Profile(self.key, along, knots, 0 * knots, 0 * knots, 0.0)
        H = windows(x, knots)
        A = np.vstack([fit.noise[i](self.signal[i][:, None] * H) for i in tracks])
        r = np.concatenate([fit.noise[i](fit.residuals[i]) for i in tracks])
        J = np.vstack(
            [fit.noise[i](np.stack([j[i] for j in fit.signals], 1)) for i in tracks]
        )
        W = np.sqrt(weights(r))
        A, r, J = A * W[:, None], r * W, J * W[:, None]
        M, b = freed(A, r, J, np.array([k.sd for k in fit.knobs]))
        evidence, value, sd = likeliest(M, b)
        return Profile(self.key, along, knots, value, sd, evidence)


def freed(A: Array, r: Array, J: Array, sd: Array) -> tuple[Array, Array]:
    """Normal equations of A a = -r once the knobs J, with priors sd, give way."""
    unit = np.where(np.isfinite(sd), sd, 1 / np.sqrt((J**2).sum(0) + 1e-300))
    J = J * unit
    N = J.T @ J + np.diag(np.where(np.isfinite(sd), 1.0, 1e-9))
    G = np.linalg.solve(N, J.T @ np.column_stack([A, r]))
    AJ = A.T @ J
    M = A.T @ A - AJ @ G[:, :-1]
    return 0.5 * (M + M.T), -(A.T @ r - AJ @ G[:, -1])


def likeliest(M: Array, b: Array) -> tuple[float, Array, Array]:
    """Evidence, strengths and their sd under the prior size that is likeliest."""
    k = len(b)
    D = np.diff(np.eye(k), axis=0)
    unit = 1 / (np.sqrt(np.trace(M) / k) or 1.0)
    best = (0.0, np.zeros(k), np.zeros(k))
    for size in SIZES:
        tau = size * unit
        P = np.eye(k) / tau**2 + D.T @ D / (ROUGHNESS * tau) ** 2
        C = np.linalg.cholesky(M + P + 1e-12 * np.trace(M) / k * np.eye(k))
        y = np.linalg.solve(C, b)
        half = np.log(np.diag(C)).sum() - 0.5 * np.linalg.slogdet(P)[1]
        value = float(0.5 * y @ y - half)
        if value > best[0]:
            inverse = np.linalg.inv(C)
            sd = np.sqrt((inverse**2).sum(0))
            best = (value, inverse.T @ y, sd)
    return best


def probe_size(engine: Engine, key: str) -> float:
    """A small change of a figure, for a vehicle of any size."""
    problem = engine.problems[0]
    vehicle = problem.vehicle
    lever = vehicle.tyres.radius_m.value / vehicle.drivetrain.gear_ratio.value
    torque = 0.01 * vehicle.body.mass_kg.value * 9.81 * lever
    power = 0.01 * float(np.nanmax(np.abs(problem.nominal["battery_power_w"])))
    sizes = {
        "torque_nm": torque,
        "a_n": torque / lever,
        "power_w": power or 1.0,
        "angle_rad": 0.005,
    }
    return sizes.get(key.rpartition(".")[2], 0.005)
