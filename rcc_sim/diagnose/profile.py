"""Causes that vary over a drive: how strong an effect acted, when.

An effect's signal is what it adds to each channel. Times a window it is, because the
vehicle forgets within a second or two, what the effect adds if it acts in that window
alone. The strengths in the windows are then a linear problem with a smooth prior.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rcc_sim.diagnose.fit import Engine, Fit
from rcc_sim.diagnose.noise import weights

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Profile:
    """Strength of an effect over time or distance, above what the fit holds."""

    key: str
    knots: Array
    value: Array
    sd: Array
    evidence: float
    along: str
    gain: float


def hats(x: Array, knots: Array) -> Array:
    """Piecewise linear windows (n, k) that sum to 1."""
    i = np.clip(np.searchsorted(knots, x, side="right") - 1, 0, len(knots) - 2)
    part = np.clip((x - knots[i]) / (knots[i + 1] - knots[i]), 0.0, 1.0)
    H = np.zeros((len(x), len(knots)))
    rows = np.arange(len(x))
    H[rows, i] = 1 - part
    H[rows, i + 1] += part
    return H


def find_profile(
    engine: Engine, fit: Fit, key: str, probe: float, x: Array, count: int, along: str
) -> Profile:
    """Strengths of the effect behind ``key`` over x, and the evidence for them.

    ``probe`` is the change of the figure by which its signal is taken.
    """
    base = fit.values.get(key, 0.0)
    signal = (engine.residual({**fit.values, key: base + probe}) - fit.residual) / probe
    knots = np.linspace(x.min(), x.max(), count)
    H = hats(x, knots)
    blocks, rest = [], []
    for w, e, s in zip(fit.whiteners, fit.residual, signal, strict=True):
        if not np.any(s[w.valid]):
            continue
        blocks.append(w(np.where(np.isfinite(s), s, 0.0)[:, None] * H))
        rest.append(w(e))
    if not blocks:
        return Profile(key, knots, 0 * knots, 0 * knots, 0.0, along, 0.0)
    A, r = np.vstack(blocks), np.concatenate(rest)
    J = np.concatenate(
        [
            np.stack([w(j[i]) for j in fit.signals], axis=1)
            for i, w in enumerate(fit.whiteners)
            if np.any(signal[i][w.valid])
        ]
    )
    W = np.sqrt(weights(r))
    A, r, J = A * W[:, None], r * W, J * W[:, None]
    prior = np.diag([1 / k.sd**2 for k in fit.knobs])
    # the knobs give way: take their part out (they keep their priors)
    N = J.T @ J + prior + 1e-12 * np.eye(len(prior))
    G = np.linalg.solve(N, J.T)
    M = A.T @ A - (A.T @ J) @ (G @ A)
    b = -(A.T @ r - (A.T @ J) @ (G @ r))
    D = np.diff(np.eye(count), axis=0)
    scale = np.sqrt(np.trace(M) / count) or 1.0
    best = (0.0, None, None)
    for size in np.logspace(-1, 4, 21):
        # amplitude and roughness of the profile, both of this size
        tau = size / scale
        P = np.eye(count) / tau**2 + D.T @ D / (0.5 * tau) ** 2
        C = np.linalg.cholesky(M + P)
        y = np.linalg.solve(C, b)
        logdet = np.log(np.diag(C)).sum() - 0.5 * np.linalg.slogdet(P)[1]
        value = 0.5 * y @ y - logdet
        if value > best[0]:
            best = (value, np.linalg.solve(C.T, y), np.linalg.inv(M + P))
    if best[1] is None:
        return Profile(key, knots, 0 * knots, 0 * knots, 0.0, along, 0.0)
    a, cov = best[1], best[2]
    return Profile(key, knots, a, np.sqrt(np.diag(cov)), float(best[0]), along, float(b @ a - 0.5 * a @ M @ a))


CARRIERS = {
    "drag": ("effects.drivetrain_friction.torque_nm", "time"),
    "power": ("effects.auxiliary_load.power_w", "time"),
    "steer": ("effects.steering_offset.angle_rad", "time"),
    "grade": ("effects.road_grade.slope", "distance"),
}


def probes(engine: Engine) -> dict[str, float]:
    problem = engine.problem
    v = problem.vehicle
    m, r = v.body.mass_kg.value, v.tyres.radius_m.value
    torque = 0.01 * m * 9.81 * r / v.drivetrain.gear_ratio.value
    power = float(np.nanmax(np.abs(problem.nominal["battery_power_w"])))
    return {"drag": torque, "power": 0.01 * power, "steer": 0.005, "grade": 0.005}


def all_profiles(engine: Engine, fit: Fit, width: float) -> dict[str, Profile]:
    problem = engine.problem
    t = problem.log["time_s"]
    v = np.where(np.isfinite(engine.speed), engine.speed, 0.0)
    s = np.concatenate([[0.0], np.cumsum(0.5 * (v[1:] + v[:-1]) * np.diff(t))])
    count = int(np.clip((t[-1] - t[0]) / width, 4, 150))
    out = {}
    sizes = probes(engine)
    for name, (key, along) in CARRIERS.items():
        if name == "grade" and ("elevation_m" in problem.log or "slope" in problem.log):
            continue
        if name == "steer" and not problem.drive.steered:
            continue
        x = t if along == "time" else s
        out[name] = find_profile(engine, fit, key, sizes[name], x, count, along)
    return out
