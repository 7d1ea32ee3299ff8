r"""Which causes many logs show together, how strong, and how they scatter.

For log i with score c and information G of :mod:`rcc_sim.diagnose.pool`, and with g, J
the parts of G that tie a candidate's strength to the tolerances and to itself, a
strength :math:`x_i \sim N(\mu, \tau^2)` leaves, with s = 1 / (1 + τ² J) and
z = c_x − g · θ,

.. math:: \ell_i(\theta, \mu) = c^T \theta - \tfrac12 \theta^T G \theta
          + \tfrac12 s (\tau^2 z^2 + 2 \mu z - J \mu^2) - \tfrac12 \ln(1 + \tau^2 J)

again a quadratic form, in the tolerances of the car and in the mean strength.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rcc_sim.definitions.figure import Z_90
from rcc_sim.diagnose.compete import LESS_LIKELY, TIED
from rcc_sim.diagnose.pool import Evidence, Strength
from rcc_sim.diagnose.verdict import INTERVAL

Array = NDArray[np.float64]

SPREADS = (0.0, 0.1, 0.2, 0.4, 0.7, 1.0, 1.5, 2.5, 4.0, 7.0, 12.0, 25.0)
"""Spreads that are tried, in sds that a strength has in a single log."""

INEXACT = 0.02
"""Share of a likely strength below which it cannot be told from what the model leaves
out, however many logs there are."""

POOLED_ENOUGH = 12.0
"""Nats that a cause must gain in all logs together, its strength free to scatter.

Less than what a single log asks for: what is wrong with one log scatters with the
strength. `benchmarks/pooled.py` counts what fleets without a cause gain.
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
        What it gains, by a common strength and by a mean of strengths alike.
    nats_common, nats_mean : float
        The two.
    nats_spread : float
        What is gained by letting the strength scatter.
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
    nats_mean: float
    nats_spread: float
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
    J = np.concatenate([car.J for car in cars])
    shows = J > 0
    single = 1 / np.sqrt(np.median(J[shows]))
    tried = [_at(cars, (single * k) ** 2, strength) for k in SPREADS]
    best = max(tried, key=lambda t: t.mean_log)
    null = max(tried, key=lambda t: t.null_log)
    common = tried[0]
    mean = best.mean_log - null.null_log
    sd = INTERVAL / np.sqrt(max(best.information, 1e-300))
    value = strength.neutral + best.x
    return Pooled(
        strength.effect,
        strength.key,
        min(common.mean_log - common.null_log, mean),
        common.mean_log - common.null_log,
        mean,
        best.mean_log - common.mean_log,
        value,
        max(value - Z_90 * sd, strength.low),
        min(value + Z_90 * sd, strength.high),
        float(sd),
        float(np.sqrt(best.variance)),
        int(shows.sum()),
    )


@dataclass(frozen=True)
class At:
    """What logs say at one spread."""

    variance: float
    x: float
    information: float
    null_log: float
    mean_log: float


def _at(cars: Sequence[Car], variance: float, strength: Strength) -> At:
    score = information = constant = 0.0
    for car in cars:
        s = 1 / (1 + variance * car.J)
        t = s * variance
        A = car.G + np.diag(car.prior) - np.einsum("i,ij,ik", t, car.g, car.g)
        b = car.c - (t * car.c_x) @ car.g
        across = s @ car.g
        both = _solved(A, np.stack([b, across], axis=1))
        constant += 0.5 * float(
            (t * car.c_x**2).sum() - np.log1p(variance * car.J).sum()
        )
        constant += 0.5 * float(b @ both[:, 0])
        score += float(s @ car.c_x - across @ both[:, 0])
        information += float(s @ car.J - across @ both[:, 1])
    x = score / max(information, 1e-300)
    blur = (INEXACT * strength.likely) ** 2
    information /= 1 + information * blur
    score = x * information
    x = min(max(x, strength.low - strength.neutral), strength.high - strength.neutral)
    gain = score * x - 0.5 * information * x * x
    return At(variance, x, information, constant, constant + gain)


def _solved(A: Array, b: Array) -> Array:
    unit = 1 / np.sqrt(np.diag(A) + 1e-300)
    scaled = A * np.outer(unit, unit) + 1e-10 * np.eye(len(A))
    return np.asarray(unit[:, None] * np.linalg.solve(scaled, b * unit[:, None]))


def pool(groups: Mapping[str, Sequence[Evidence]]) -> Explained:
    """Return the causes that many logs show together.

    Parameters
    ----------
    groups : mapping
        Car -> evidence of its logs: the figures of a car are off by the same in all
        of them, those of another car by others.
    """
    causes: list[Common] = []
    taken: list[str] = []
    ranking: list[Pooled] = []
    for _ in range(MOST_POOLED):
        found = screen(groups, taken)
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
        single = [
            weigh([_car([one], best.key, taken)], _strength([one], best.key)).nats
            for logs in groups.values()
            for one in logs
            if best.key in _keys(one)
        ]
        causes.append(Common(best, tuple(names), max(single), cars))
        taken.append(best.key)
    return Explained(tuple(causes), tuple(ranking))


def _keys(one: Evidence) -> set[str]:
    return {s.key for s in one.strengths}


def _strength(logs: Sequence[Evidence], key: str) -> Strength:
    return next(s for one in logs for s in one.strengths if s.key == key)


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
        have = [(k, place[name]) for k, name in enumerate(order) if name in place]
        to, of = (np.array(side) for side in zip(*have, strict=True))
        c[to] += one.score[of]
        G[np.ix_(to, to)] += one.information[np.ix_(of, of)]
        if key in place:
            c_x[i] = one.score[place[key]]
            rows[i, to] = one.information[place[key], of]
    return Car(c[:n], G[:n, :n], np.array(prior), c_x, rows[:, :n], rows[:, n])
