r"""Evidence of many logs added up: a cause too weak for each is found in all together.

Around the fit of a log's tolerances the log-likelihood is a quadratic form in what the
vehicle's figures are off by, :math:`\theta`, and in the strength of each candidate, x:

.. math:: \ell(\theta, x) = c^T [\theta, x] - \tfrac12 [\theta, x]^T G [\theta, x]

with score c and information G of whitened residuals that follow a t-distribution
[1]_. Forms of logs add; so the figures of a vehicle, which are off by the same in all
its logs, are weighed against a cause once, and not once a log.

What sensors are off by is the car's own and in each log a little more. What
they come to together stands in :mod:`rcc_sim.diagnose.fleet.pooled`.

References
----------
.. [1] K. L. Lange, R. J. A. Little and J. M. G. Taylor, "Robust statistical modeling
       using the t distribution," J. Am. Stat. Assoc. 84 (408), 1989.
.. [2] P. J. Huber and E. M. Ronchetti, Robust Statistics, 2nd ed., Wiley, 2009, ch. 3.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from math import isfinite

import numpy as np
from numpy.typing import NDArray

from rcc_sim.diagnose.causes.candidates import Candidate
from rcc_sim.diagnose.causes.sought import Search
from rcc_sim.diagnose.fitting.engine import Engine
from rcc_sim.diagnose.fitting.fit import Fit
from rcc_sim.diagnose.fitting.knobs import BIAS, Knob
from rcc_sim.diagnose.noise.kernel import FREEDOM
from rcc_sim.diagnose.noise.whitener import weights
from rcc_sim.errors import InputError
from rcc_sim.side_by_side import each

Array = NDArray[np.float64]
Places = NDArray[np.intp]

WEAK = 0.1
"""Share of a likely strength at which a candidate's signal is taken: it is weak."""


@dataclass(frozen=True)
class Strength:
    """A figure of a candidate, as a column of the form.

    Parameters
    ----------
    effect, key : str
        Its id, and the dotted key.
    neutral, low, high : float
        What the file states or where it vanishes; its bounds.
    likely : float
        How far from neutral a strength that is worth a look would be.
    """

    effect: str
    key: str
    neutral: float
    low: float
    high: float
    likely: float = 0.0


@dataclass(frozen=True)
class Evidence:
    """What one log says of tolerances and candidates together.

    Parameters
    ----------
    knobs : tuple of str
        Figures of the vehicle that its file states with an sd.
    sd : ndarray, shape (k,)
        Their sds.
    strengths : tuple of Strength
        Columns after those of the knobs.
    score : ndarray, shape (k + m,)
        c, about the file's own figures.
    information : ndarray, shape (k + m, k + m)
        G.
    """

    knobs: tuple[str, ...]
    sd: Array
    strengths: tuple[Strength, ...]
    score: Array
    information: Array


def evidence_of(engine: Engine, null: Fit, candidates: Sequence[Candidate]) -> Evidence:
    """Return the evidence of a log from its fit with tolerances alone.

    One simulation a candidate's figure; nothing is refined.

    Parameters
    ----------
    engine : Engine
        The log.
    null : Fit
        Tolerances alone.
    candidates : sequence of Candidate
        Effects to weigh; those found by trying alone (limits, thresholds, clocks) show
        in the logs that reach them and are left out.
    """
    searches = [(c.effect, s) for c in candidates for s in c.searches if _slopes(s)]
    found = each(lambda pair: _signal(engine, null, pair[1]), searches)
    pairs = [
        (pair, d) for pair, d in zip(searches, found, strict=True) if d is not None
    ]
    c, G = _form(null, [*null.signals, *(d for _, d in pairs)])
    c += G[:, : len(null.knobs)] @ null.off
    biases = np.array([k.key.startswith(BIAS) for k in null.knobs])
    sd = null.prior_sd
    c, G = _blurred(c, G, np.flatnonzero(biases), 1 / sd[biases] ** 2)
    strengths = tuple(
        Strength(e, s.key, s.neutral, s.low, s.high, abs(s.first - s.neutral))
        for (e, s), _ in pairs
    )
    knobs = tuple(_of_car(k.key) for k in null.knobs)
    return Evidence(knobs, sd, strengths, c, G)


def _form(null: Fit, signals: list[list[Array]]) -> tuple[Array, Array]:
    """Return score and information of signals, each track by how its noise is spread.

    With psi the derivative of the log-density, a strength's variance is that of an
    M-estimate, mean(psi²) / mean(psi')². [2]_
    """
    c, G = np.zeros(len(signals)), np.zeros((len(signals), len(signals)))
    for white, e, *tracks in zip(null.noise, null.residuals, *signals, strict=True):
        w, A = white(e), white(np.stack(tracks, axis=1))
        psi = weights(w) * w
        slope = float(np.mean((FREEDOM + 1) * (FREEDOM - w**2) / (FREEDOM + w**2) ** 2))
        spread = float(np.mean(psi**2))
        if slope > 0 and spread > 0:
            c -= slope / spread * (A.T @ psi)
            G += slope**2 / spread * (A.T @ A)
    return c, G


def _blurred(c: Array, G: Array, mine: Places, prior: Array) -> tuple[Array, Array]:
    """Return the form with an offset in this log alone beside each of the car's own."""
    if not len(mine):
        return c, G
    across = np.linalg.solve(G[np.ix_(mine, mine)] + np.diag(prior), G[mine])
    return c - across.T @ c[mine], G - across.T @ G[mine]


def _of_car(key: str) -> str:
    """Return a knob's key; a sensor's offset is the car's, whichever the log."""
    if not key.startswith(BIAS):
        return key
    return BIAS + key.removeprefix(BIAS).partition(".")[2]


def _slopes(search: Search) -> bool:
    return not search.grid and not search.clocked and isfinite(search.neutral)


def _signal(engine: Engine, null: Fit, search: Search) -> list[Array] | None:
    """d(residual)/d(strength) from neutral to a weak strength; None if it has none.

    One that the file states with an sd is free of it: the figure's own signal, once
    more beside its tolerance.
    """
    for knob, signal in zip(null.knobs, null.signals, strict=True):
        if knob.key == search.key:
            return signal
    step = WEAK * (search.first - search.neutral)
    if step == 0:
        return None
    start = null.values.get(search.key, search.neutral)
    knob = Knob(search.key, start, low=search.low, high=search.high, step=step)
    try:
        (found,) = engine.signals({**null.values, search.key: start}, [knob])
    except InputError:  # a strength that no such vehicle can have
        return None
    return found if any(np.any(d[np.isfinite(d)]) for d in found) else None


def packed(evidence: Evidence) -> tuple[str, list[float]]:
    """Return evidence as a text of its columns and a list of numbers."""
    columns = {
        "knobs": list(evidence.knobs),
        "strengths": [list(vars(s).values()) for s in evidence.strengths],
    }
    upper = evidence.information[np.triu_indices(len(evidence.score))]
    numbers = np.concatenate([evidence.sd, evidence.score, upper])
    return json.dumps(columns), numbers.tolist()


def unpacked(columns: str, numbers: Sequence[float]) -> Evidence:
    """Return the evidence that :func:`packed` wrote."""
    about = json.loads(columns)
    strengths = tuple(Strength(*row) for row in about["strengths"])
    k = len(about["knobs"])
    n = k + len(strengths)
    sd, score, upper = np.split(np.asarray(numbers), [k, k + n])
    information = np.zeros((n, n))
    information[np.triu_indices(n)] = upper
    information += np.triu(information, 1).T
    return Evidence(tuple(about["knobs"]), sd, strengths, score, information)
