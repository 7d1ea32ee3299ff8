r"""Which causes many logs show together, how strong, and how they scatter.

For log i with score c and information G of :mod:`rcc_sim.diagnose.fleet.pool`, and with
g, J the parts of G that tie a candidate's strength to the tolerances and to itself, a
strength :math:`x_i \sim N(\mu, \tau^2)` leaves, with s = 1 / (1 + τ² J) and
z = c_x − g · θ,

.. math:: \ell_i(\theta, \mu) = c^T \theta - \tfrac12 \theta^T G \theta
          + \tfrac12 s (\tau^2 z^2 + 2 \mu z - J \mu^2) - \tfrac12 \ln(1 + \tau^2 J)

again a quadratic form, in the tolerances of the car and in the mean strength. The
scatter τ follows from the moments of the strengths found log by log [1]_; where it is
what the logs show and not what their noise says, the gain is that of a t-test.

References
----------
.. [1] R. DerSimonian and N. Laird, "Meta-analysis in clinical trials," Controlled
       Clinical Trials 7 (3), 1986.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from rcc_sim.definitions.figure import Z_90
from rcc_sim.diagnose.causes.cause import TIED
from rcc_sim.diagnose.fitting.fit import of_unit_diagonal
from rcc_sim.diagnose.fleet.pool import Evidence, Strength
from rcc_sim.diagnose.judge.asserted import INTERVAL
from rcc_sim.diagnose.search.refine import LESS_LIKELY

Array = NDArray[np.float64]

INEXACT = 0.02
"""Share of a likely strength below which it cannot be told from what the model leaves
out, however many logs there are."""

POOLED_ENOUGH = 14.0
"""Nats that a cause must gain in all logs together, its strength free to scatter.

Less than what a single log asks for: what is wrong with one log scatters with the
strength. Of 24 fleets without a cause one gained 11.6 and no other 7.
"""

MOST_POOLED = 4
"""Causes that are looked for one after the other."""


@dataclass(frozen=True)
class Pooled:
    """A candidate by the evidence of all logs.

    Parameters
    ----------
    effect, key : str
        Its id, and the dotted key of its figure.
    nats : float
        What the mean of strengths that scatter gains.
    nats_common : float
        What a strength that is the same in all logs gains.
    value, low, high, sd : float
        Mean strength with its 90 % interval.
    spread : float
        sd of the strength between logs.
    logs : int
        Logs in which it shows at all.
    """

    effect: str
    key: str
    nats: float
    nats_common: float
    value: float
    low: float
    high: float
    sd: float
    spread: float
    logs: int


@dataclass(frozen=True)
class Common:
    """A cause that the logs show together.

    Parameters
    ----------
    found : Pooled
        What all logs say of it.
    tied : tuple of str
        Effects that these logs together cannot tell from it.
    largest : float
        The most nats that it gains in a single log.
    cars : mapping
        Car -> what its own logs say, where there are several cars.
    """

    found: Pooled
    tied: tuple[str, ...]
    largest: float
    cars: Mapping[str, Pooled]


@dataclass(frozen=True)
class Explained:
    """What the logs show together: causes, strongest first, and every candidate."""

    causes: tuple[Common, ...]
    ranking: tuple[Pooled, ...]


@dataclass(frozen=True)
class Car:
    """The logs of one car: sums over them, and for one strength what each says."""

    c: Array  # (k,)
    G: Array  # (k, k)
    prior: Array  # (k,)
    c_x: Array  # (n,)
    g: Array  # (n, k)
    J: Array  # (n,)


def weigh(cars: Sequence[Car], strength: Strength) -> Pooled:
    """Return what logs of some cars say of one strength."""
    common = _at(cars, 0.0, strength)
    variance, logs = _scatter(cars, common)
    mean = _at(cars, variance, strength)
    known = mean.information / max(common.information, 1e-300)
    scattered = max(1.0 - known, 1e-9)  # share of the variance that logs show, not say
    n = logs / scattered
    gain = 0.5 * n * float(np.log1p(2 * mean.gain / n))
    sd = INTERVAL / np.sqrt(max(mean.information, 1e-300))
    value = strength.neutral + mean.x
    return Pooled(
        strength.effect,
        strength.key,
        gain,
        common.gain,
        value,
        float(max(value - Z_90 * sd, strength.low)),
        float(min(value + Z_90 * sd, strength.high)),
        float(sd),
        float(np.sqrt(variance)),
        logs,
    )


@dataclass(frozen=True)
class At:
    """What logs say of a mean strength x at one scatter; shared figures of each car."""

    x: float
    information: float
    gain: float
    shared: tuple[Array, ...]
    best: float


def _at(cars: Sequence[Car], variance: float, strength: Strength) -> At:
    score = information = 0.0
    solved = []
    for car in cars:
        s = 1 / (1 + variance * car.J)
        t = s * variance
        A = car.G + np.diag(car.prior) - np.einsum("i,ij,ik", t, car.g, car.g)
        b = car.c - (t * car.c_x) @ car.g
        across = s @ car.g
        both = _solved(A, np.stack([b, across], axis=1))
        score += float(s @ car.c_x - across @ both[:, 0])
        information += float(s @ car.J - across @ both[:, 1])
        solved.append(both)
    best = score / max(information, 1e-300)
    information /= 1 + information * (INEXACT * strength.likely) ** 2
    score = best * information
    low, high = strength.low - strength.neutral, strength.high - strength.neutral
    x = min(max(best, low), high)
    gain = score * x - 0.5 * information * x * x
    shared = tuple(both[:, 0] - best * both[:, 1] for both in solved)
    return At(x, information, max(gain, 0.0), shared, best)


def _scatter(cars: Sequence[Car], common: At) -> tuple[float, int]:
    """Return the variance of strengths between logs, and the logs in which it shows."""
    x, J = [], []
    for car, shared in zip(cars, common.shared, strict=True):
        there = car.J > 0
        x.append((car.c_x - car.g @ shared)[there] / car.J[there])
        J.append(car.J[there])
    every = np.concatenate(J)
    return _moments(np.concatenate(x), every, common.best), len(every)


def _moments(x: Array, J: Array, mean: float) -> float:
    r"""Return the variance between strengths x of information J, by their moments.

    :math:`\tau^2 = (Q - n + 1) / (\sum J - \sum J^2 / \sum J)`, where positive. [1]_
    """
    room = float(J.sum() - (J**2).sum() / J.sum())
    if len(x) < 2 or room <= 0:
        return 0.0
    return max(float(J @ (x - mean) ** 2) - len(x) + 1, 0.0) / room


def _solved(A: Array, b: Array) -> Array:
    scaled, unit = of_unit_diagonal(A)
    return np.asarray(unit[:, None] * np.linalg.solve(scaled, b * unit[:, None]))


def pool(groups: Mapping[str, Sequence[Evidence]]) -> Explained:
    """Return the causes that many logs show together.

    None of which the interval, widened by how far the logs differ, holds nothing at
    all.

    Parameters
    ----------
    groups : mapping
        Car -> evidence of its logs: the figures of a car are off by the same in all
        of them, those of another car by others.
    """
    causes: list[Common] = []
    taken: list[str] = []
    settled: set[str] = set()  # named, or not to be told from what is
    ranking: list[Pooled] = []
    for _ in range(MOST_POOLED):
        found = [p for p in screen(groups, taken) if p.effect not in settled]
        ranking = ranking or found
        if not found or found[0].nats < POOLED_ENOUGH:
            break
        best = found[0]
        rivals = [p for p in found[1:] if best.nats - p.nats < TIED]
        names = dict.fromkeys(p.effect for p in rivals if p.effect != best.effect)
        cars = {
            name: weigh([_car(logs, best.key, taken)], _strength(logs, best.key))
            for name, logs in groups.items()
            if len(groups) > 1 and any(best.key in _keys(one) for one in logs)
        }
        singles = [
            _at([_car([one], best.key, taken)], 0.0, _strength([one], best.key))
            for logs in groups.values()
            for one in logs
            if best.key in _keys(one)
        ]
        largest = max(one.gain for one in singles)
        strength = next(s for logs in groups.values() for s in _known(logs, best.key))
        doubted = _doubted(best, singles, strength)
        settled |= {best.effect, *names}
        if doubted.low <= strength.neutral <= doubted.high:
            continue  # the logs do not agree that it acts at all
        causes.append(Common(doubted, tuple(names), largest, cars))
        taken.append(best.key)
    return Explained(tuple(causes), tuple(ranking))


def _keys(one: Evidence) -> set[str]:
    return {s.key for s in one.strengths}


def _known(logs: Sequence[Evidence], key: str) -> list[Strength]:
    return [s for one in logs for s in one.strengths if s.key == key]


def _strength(logs: Sequence[Evidence], key: str) -> Strength:
    return _known(logs, key)[0]


def _doubted(p: Pooled, singles: Sequence[At], strength: Strength) -> Pooled:
    """Return a cause about the mean of what each log finds with figures of its own.

    Where that differs from what the logs find with figures in common, the model is
    not right to that extent: it widens the interval.
    """
    x = np.array([one.best for one in singles])
    w = np.array([one.information for one in singles])
    variance = _moments(x, w, float(w @ x / w.sum()))
    w = 1 / (variance + 1 / w)
    value = strength.neutral + float(w @ x / w.sum())
    value = min(max(value, strength.low), strength.high)
    sd = float(np.hypot(p.sd, value - p.value))
    low, high = value - Z_90 * sd, value + Z_90 * sd
    low, high = max(low, strength.low), min(high, strength.high)
    return replace(p, value=value, low=low, high=high, sd=sd)


def screen(
    groups: Mapping[str, Sequence[Evidence]], taken: Sequence[str]
) -> list[Pooled]:
    """Return the candidates by their nats, those taken being free to move."""
    known: dict[str, Strength] = {}
    for logs in groups.values():
        for one in logs:
            known |= {s.key: s for s in one.strengths}
    found = []
    for key, strength in known.items():
        if key in taken:
            continue
        cars = [_car(logs, key, taken) for logs in groups.values()]
        if any((car.J > 0).any() for car in cars):
            found.append(weigh(cars, strength))
    return sorted(found, key=lambda p: -(p.nats - LESS_LIKELY.get(p.effect, 0.0)))


def _car(logs: Sequence[Evidence], key: str, taken: Sequence[str]) -> Car:
    """Return the logs of a car in the same columns; what a log lacks says nothing."""
    shared = list(dict.fromkeys(k for one in logs for k in one.knobs))
    sds = {k: float(s) for one in logs for k, s in zip(one.knobs, one.sd, strict=True)}
    prior = [1 / sds[k] ** 2 for k in shared] + [0.0] * len(taken)
    order = [*shared, *taken, key]
    n = len(order) - 1
    c, G = np.zeros(n + 1), np.zeros((n + 1, n + 1))
    c_x, rows = np.zeros(len(logs)), np.zeros((len(logs), n + 1))
    for i, one in enumerate(logs):
        names = [*one.knobs, *(s.key for s in one.strengths)]
        place = {name: k for k, name in enumerate(names)}
        to = np.array([k for k, name in enumerate(order) if name in place], np.intp)
        of = np.array([place[order[k]] for k in to], np.intp)
        c[to] += one.score[of]
        G[np.ix_(to, to)] += one.information[np.ix_(of, of)]
        if key in place:
            c_x[i] = one.score[place[key]]
            rows[i, to] = one.information[place[key], of]
    return Car(c[:n], G[:n, :n], np.array(prior), c_x, rows[:, :n], rows[:, n])
