"""Strengths in windows over a drive: how likely, how large, how sure.

A linear problem with a Gaussian prior, whose size the log itself tells (empirical
Bayes): the evidence is the marginal likelihood at its most likely size. [1]_

References
----------
.. [1] D. J. C. MacKay, "Bayesian interpolation," Neural Computation 4 (1992) 415.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import eigh
from scipy.sparse import csc_array

from rcc_sim.diagnose.noise.strips import Strips

Array = NDArray[np.float64]
Places = NDArray[np.intp]
Windows: TypeAlias = csc_array
"""Windows (n, k), a column each: most of their rows are nil."""

SIZES = np.logspace(-1, 4, 21)
"""Sizes of a profile that are tried, in times what one window could tell."""

ROUGHNESS, GENTLE = 0.5, 0.12
"""Size of the change from window to window, in times the size of the profile; where
the windows are shorter than what it needs to change."""

ABSORBED = 1e-3
"""Share of a signal that the knobs leave from which on it is found by itself: of less,
the difference of two sums of squares may be nothing but rounding."""


CLIMBS = ("effects.road_grade.slope",)
"""What adds up, over the distance, to a height."""

RELIEF = 100.0
"""Height by which a drive may end above where it began, one sd: what goes on for tens
of kilometres is no slope. Of the 27 trips of two measured cars, of 3 to 60 km, it is
27 m (root mean square) and 60 m at most; other country is hillier. [m]"""


WINDS = ("effects.headwind.speed_mps",)
"""What blows in gusts, about a steady wind that is a figure of its own."""

CALM = 0.1
"""Mean of gusts, one sd: next to none. [m/s]"""


@dataclass(frozen=True)
class Prior:
    """What is expected of strengths before a log is seen.

    Parameters
    ----------
    shape : ndarray, shape (k, k)
        Their inverse covariance at size 1.
    held : ndarray, shape (k,), or None
        Weights of a sum of them whose standard deviation is 1, whatever their size.
    """

    shape: Array
    held: Array | None = None


@dataclass(frozen=True)
class Weighed:
    """Strengths with their sd, how the knobs give way, and what the prior costs."""

    evidence: float
    value: Array
    sd: Array
    knobs: Array
    cost: float
    normal: tuple[Array, Array]
    mean_sd: float


def windows(x: Array, knots: Array, which: Places | None = None) -> Windows:
    """Piecewise linear windows (n, k) around knots, that sum to 1.

    Knots of the same number in ``which``, 0 to k - 1, have one window together.
    """
    which = np.arange(len(knots)) if which is None else which
    i = np.clip(np.searchsorted(knots, x, side="right") - 1, 0, len(knots) - 2)
    part = np.clip((x - knots[i]) / (knots[i + 1] - knots[i]), 0.0, 1.0)
    share = np.concatenate([1 - part, part])
    at = np.tile(np.arange(len(x)), 2), which[np.concatenate([i, i + 1])]
    return csc_array((share, at), shape=(len(x), which[-1] + 1))


def freed(
    A: Strips,
    r: Array,
    J: Array,
    sd: Array,
    off: Array,
    beside: tuple[Array, Array] | None = None,
) -> tuple[Array, Array, Callable[[Array], Array]]:
    """Normal equations of A a = -r once the knobs J, with priors sd, give way.

    A knob that is ``off`` what was expected of it is drawn back there. Rows ``beside``,
    R (m, k) and s (m,), say of the knobs alone that R x = -s.
    The third tells by how much the knobs move with strengths a.
    """
    R, s = beside or (np.zeros((0, len(sd))), np.zeros(0))
    power = (J**2).sum(0) + (R**2).sum(0)
    unit = np.where(np.isfinite(sd), sd, 1 / np.sqrt(power + 1e-300))
    J, R = J * unit, R * unit
    prior = np.where(np.isfinite(sd), 1.0, 1e-9)
    JA, drawn = A.onto(J).T, np.where(np.isfinite(sd), off / unit, 0.0)
    own = J.T @ J + R.T @ R + np.diag(prior)
    G = np.linalg.solve(own, np.column_stack([JA, J.T @ r + R.T @ s + drawn]))
    AA = A.gram()
    M = AA - JA.T @ G[:, :-1]
    if np.trace(M) < ABSORBED * np.trace(AA):
        rest = A.toarray() - J @ G[:, :-1]
        rows = R @ G[:, :-1]
        M = rest.T @ rest + rows.T @ rows + (G[:, :-1].T * prior) @ G[:, :-1]

    def back(a: Array) -> Array:
        moved: Array = -unit * (G @ np.append(a, 1.0))
        return moved

    return 0.5 * (M + M.T), -(A.onto(r) - JA.T @ G[:, -1]), back


def smooth(k: int, roughness: float = ROUGHNESS) -> Array:
    """Inverse covariance of k strengths of size 1 that change little knot by knot."""
    D = np.diff(np.eye(k), axis=0)
    level = np.full((k, k), 1 / k)  # a mean counts as one figure, not as one a knot
    inverse: Array = np.eye(k) - level + level / k + D.T @ D / roughness**2
    return inverse


def prior_of(key: str, along: str, knots: Array, roughness: float = ROUGHNESS) -> Prior:
    """What is expected of strengths at knots: little change, no great climb, gusts."""
    k = len(knots)
    if key in WINDS:
        return Prior(smooth(k, roughness), np.full(k, 1 / (k * CALM)))
    if key not in CLIMBS or along != "distance_m":
        return Prior(smooth(k, roughness))
    climb = np.full(k, knots[1] - knots[0])
    climb[[0, -1]] *= 0.5
    return Prior(smooth(k, roughness), climb / RELIEF)


def priors_of(key: str, along: str, knots: Array) -> list[Prior]:
    """What may be expected of strengths at knots, gentle or not."""
    return [prior_of(key, along, knots, rough) for rough in (ROUGHNESS, GENTLE)]


def likeliest(
    M: Array, b: Array, prior: Prior, share: Array | None = None
) -> tuple[float, Array, Array, float]:
    """Evidence, strengths, their sd and their mean's, for the likeliest prior size.

    ``share`` is the part of the rows that each strength stands for (all of the same,
    if not told).
    """
    k = len(b)
    share = np.full(k, 1 / k) if share is None else share
    unit = 1 / (np.sqrt(max(np.trace(M), 0.0) / k) or 1.0)
    shape, held = prior.shape, np.zeros(k) if prior.held is None else prior.held
    loose = float(held @ np.linalg.solve(shape, held))  # variance of the sum at size 1
    # V' shape V = 1 and V' M V = told: (M + shape / τ²)⁻¹ = V / (told + 1 / τ²) V'
    told, V = eigh(M + np.outer(held, held), shape)
    told, along = np.maximum(told, 0.0), V.T @ b
    squares = (SIZES * unit) ** 2
    half = 0.5 * np.log1p(np.outer(squares, told)).sum(axis=1)
    half -= 0.5 * np.log1p(squares * loose)
    left = 1 / (told + 1 / squares[:, None])
    evidence = 0.5 * left @ along**2 - half
    i = int(np.argmax(evidence))
    if not evidence[i] > 0:
        return 0.0, np.zeros(k), np.zeros(k), 0.0
    sd, mean = np.sqrt(V**2 @ left[i]), np.sqrt(left[i]) * (V.T @ share)
    value = V @ (left[i] * along)
    return float(evidence[i]), value, sd, float(np.linalg.norm(mean))
