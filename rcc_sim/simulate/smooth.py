"""Speed behind a noisy speed sensor, so that its slope may be used."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

ROUNDS = 6
"""Rounds of reweighting of the jerk."""


def sensor_noise(x: Array) -> float:
    """Noise [unit of x] of a sampled signal, from its second differences.

    For white noise of variance s² these have 6 s²; their median keeps the drive's own
    accelerations out. At least a third of the resolution of a quantised signal.
    """
    d2 = np.diff(x[np.isfinite(x)], 2)
    if len(d2) < 3:
        return 0.0
    noise = 1.4826 * float(np.median(np.abs(d2))) / np.sqrt(6)
    steps = np.abs(d2[d2 != 0])
    return max(noise, float(steps.min()) / 3 if len(steps) else 0.0)


def smooth_speed(
    time: Array, speed: Array, *, noise: float, jerk: float, accel: Array | None = None
) -> tuple[Array, Array]:
    r"""Speed [m/s] and acceleration [m/s²] of a drive whose acceleration changes seldom, but then freely.

    The likeliest path of

    .. math:: \dot v = a, \qquad \dot a = w, \qquad y = v + e

    where w follows a Cauchy distribution (spectral size ``jerk`` [m/s³ √s]): smooth
    while a speed is held or a ramp driven, and free at the corners between. An
    accelerometer, its mean offset taken off, is a second witness of a. Solved by
    reweighted least squares on a banded system; rows without a speed are bridged.
    """
    from scipy import sparse
    from scipy.sparse.linalg import splu

    n = len(time)
    dt = np.diff(time)
    known = np.isfinite(speed)
    seen = np.zeros(n, bool)
    y_a, accel_noise = np.zeros(n), 1.0
    if accel is not None and np.isfinite(accel).sum() > 10:
        seen = np.isfinite(accel) & known
        slope = np.gradient(np.interp(time, time[known], speed[known]), time)
        y_a = np.where(seen, accel - np.median((accel - slope)[seen]), 0.0)
        accel_noise = max(sensor_noise(accel), 1e-6)
    one = np.ones(n - 1)
    shape = (n - 1, n)
    D = sparse.diags_array([-one, one], offsets=[0, 1], shape=shape)
    M = sparse.diags_array([dt / 2, dt / 2], offsets=[0, 1], shape=shape)
    I, Z, O = sparse.identity(n), sparse.csr_array((n, n)), sparse.csr_array(shape)
    blocks = [[D, -M], [O, D], [I, Z], [Z, I]]
    order = np.arange(2 * n).reshape(2, n).T.ravel()  # v, a side by side: a narrow band
    A = sparse.block_array(blocks).tocsc()[:, order]
    y = np.concatenate([np.zeros(2 * n - 2), np.where(known, speed, 0.0), y_a])
    fixed = [known / noise**2, seen / accel_noise**2 + 1e-9]
    weight = one
    x = np.zeros((n, 2))
    for _ in range(ROUNDS):
        W = np.concatenate(
            [12 / (jerk**2 * dt**3) * weight, weight / (jerk**2 * dt), *fixed]
        )
        N = (A.T @ sparse.diags_array(W) @ A).tocsc()
        x = splu(N, permc_spec="NATURAL").solve(A.T @ (W * y)).reshape(n, 2)
        jump = np.diff(x[:, 1]) / np.sqrt(dt) / jerk
        weight = 2 / (1 + jump * jump)
    return x[:, 0], x[:, 1]
