"""Which mistakes of the channels explain the relations, or that none of them does."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from math import log

import numpy as np

from rcc_sim.analyse.logcheck.finding import DROPPED, Columns, Finding, by_map
from rcc_sim.analyse.logcheck.mistakes import Mistake, mistakes, words_of
from rcc_sim.analyse.logcheck.relation import Relation
from rcc_sim.definitions.vehicle import Vehicle

BROKEN, PRICE, RARE = 5.0, 3.0, 0.5
"""What a relation costs that does not hold, and a mistake; and how much less it costs
the more usual it is. A relation that holds costs 1 where it is as far off as it may be:
one mistake has to mend one, two have to mend two."""

CLASHES = 2
"""Things that a vehicle's file alone contradicts, from which it is another vehicle's:
one may be a sensor that no unit explains."""

TENTHS = 8.0, 12.5
"""Times a file's voltage, between which a log's may be in tenths of a volt."""

MOST, KEPT = 6, 40
"""Mistakes of one log at most, and sets of them that are followed."""

NEAR, UNUSUAL = 0.7, 0.3
"""How much more another mistake may cost to be named as well, and what is too rare."""


def blame(
    found: Sequence[Relation], columns: Columns, vehicle: Vehicle | None
) -> list[Finding]:
    """Return the mistakes that together explain the relations best.

    Each mistake has its price, and each relation costs by how far it is off what they
    make of it: two that hide each other, as km/h and g do in an acceleration, are found
    at once. Where another would do nearly as well, the doubt is said.
    """
    told = {channel for r in found for channel in r.powers}
    known = [m for m in mistakes(columns, vehicle) if not told.isdisjoint(m.factors)]
    cost = Costs(found)
    best = _likeliest(cost, known)
    own = tuple(m for m in best if _is_of_the_log(m, best, found))
    against = _against_the_file(found, best, own)
    if against:
        best = own
    factors, most = _factors(best), cost(best) + NEAR
    findings = []
    for mistake in best:
        others = tuple(m for m in best if m is not mistake)
        findings += _told(mistake, others, cost, known, most)
    broken = [r for r in found if not r.allows(_expected(r, factors))]
    if against:
        findings.append(_other_vehicle(against))
        broken = [r for r in broken if r not in against]
    return findings + [_odd(r, _expected(r, factors)) for r in broken[:3]]


def _against_the_file(
    found: Sequence[Relation], best: Sequence[Mistake], own: Sequence[Mistake]
) -> list[Relation]:
    """Return what the vehicle's file alone contradicts, CLASHES at least; else nothing.

    One mistake of a channel explains all that is off by it, and one channel may be in
    a unit that nobody knows. Where something is left over, those of the ``best`` that
    nothing but the file speaks for are no mistakes of the log, as its ``own`` are.
    """
    every, sure = _factors(best), _factors(own)
    off = [r for r in found if r.by_vehicle and not r.allows(1.0)]
    against = [r for r in off if not r.allows(_expected(r, sure))]
    explained = all(r.allows(_expected(r, every)) for r in off)
    few = len(against) < CLASHES
    return [] if explained or few or _is_one_channel(against) else against


def _is_one_channel(off: Sequence[Relation]) -> bool:
    """Tell whether one channel, by whatever factor, would explain all that is off."""
    shared = set(off[0].powers).intersection(*(r.powers for r in off))
    return any(
        all(s.allows(_expected(s, {channel: factor})) for s in off)
        for channel in shared
        for factor in (abs(r.middle) ** (1 / r.powers[channel]) for r in off)
    )


def _is_of_the_log(
    mistake: Mistake, best: Sequence[Mistake], found: Sequence[Relation]
) -> bool:
    """Tell whether a mistake mends anything that no vehicle's file has a say in."""
    others = _factors([m for m in best if m is not mistake])
    whole = others | mistake.factors
    return any(
        not r.by_vehicle
        and not r.allows(_expected(r, others))
        and r.allows(_expected(r, whole))
        for r in found
    )


class Costs:
    """What mistakes cost, and the relations as they then are.

    A relation costs by the factors of its own channels alone: each once.
    """

    def __init__(self, found: Sequence[Relation]) -> None:
        self.found = found
        self._strains: list[dict[tuple[float | None, ...], float]] = [{} for _ in found]

    def __call__(self, some: Sequence[Mistake]) -> float:
        """Return what a set of mistakes costs."""
        factors = _factors(some)
        strain = 0.0
        for relation, known in zip(self.found, self._strains, strict=True):
            own = tuple(map(factors.get, relation.powers))
            if own not in known:
                known[own] = _strain(relation, _expected(relation, factors))
            strain += known[own]
        return sum(PRICE - RARE * m.prior for m in some) + strain


def _likeliest(cost: Costs, known: Sequence[Mistake]) -> tuple[Mistake, ...]:
    """Return the set of mistakes that costs least, the likeliest ``KEPT`` followed."""
    if all(r.allows(1.0) for r in cost.found):
        return ()
    channels = [set(m.factors) for m in known]
    apart = [{k for k, c in enumerate(channels) if not c & own} for own in channels]
    every = set(range(len(known)))
    kept: list[tuple[int, ...]] = [()]
    costs: dict[tuple[int, ...], float] = {(): cost(())}
    for _ in range(MOST):
        wider = (
            tuple(sorted((*some, k)))
            for some in kept
            for k in sorted(every.intersection(*(apart[j] for j in some)))
        )  # in the order of what is usual: of two that cost the same the first is taken
        more = {some: cost([known[k] for k in some]) for some in dict.fromkeys(wider)}
        costs |= more
        kept = sorted(more, key=lambda some: more[some])[:KEPT]
        if not kept or more[kept[0]] > min(costs.values()) + BROKEN:
            break
    best = min(costs, key=lambda some: (costs[some], len(some)))
    return tuple(known[k] for k in best)


def _factors(some: Sequence[Mistake]) -> dict[str, float]:
    return {channel: f for m in some for channel, f in m.factors.items()}


def _strain(relation: Relation, expected: float) -> float:
    """Return how far a relation is off what mistakes make of it.

    BROKEN at most where a vehicle's file, which may be another's, or a sign alone has a
    say; channels of one log are off each other by thousands through their units alone.
    """
    if not relation.allows(expected):
        if relation.by_vehicle or np.isinf(relation.loose):
            return BROKEN
        off = abs(log(abs(relation.middle / expected)))
        return BROKEN + max(off - log(relation.loose), 0.0) / log(10)
    return (log(abs(relation.middle / expected)) / log(relation.loose)) ** 2


def _expected(relation: Relation, factors: dict[str, float]) -> float:
    """Return the factor that known mistakes give a relation; 1 where there are none."""
    out = 1.0
    for channel, power in relation.powers.items():
        out *= factors.get(channel, 1.0) ** power
    return out


def _told(
    mistake: Mistake,
    others: tuple[Mistake, ...],
    cost: Costs,
    known: Sequence[Mistake],
    most: float,
) -> list[Finding]:
    """Return the findings of a mistake beside others: one for each of its channels.

    Another that costs less than the ``most`` in its place is named as well.
    """
    taken = _factors(others)
    near = [
        m
        for m in known
        if m.prior > UNUSUAL
        and taken.keys().isdisjoint(m.factors)
        and cost((*others, m)) < most
    ]
    rivals = [m for m in near if m.channel not in mistake.factors]
    units = {m.words for m in near if m.channel == mistake.channel and m.kind == "unit"}
    or_in = "".join(f", or in {unit}" for unit in sorted(units - {mistake.words}))
    first = _finding(mistake, mistake.words + or_in, cost.found, taken, rivals)
    also = [
        replace(
            first,
            channel=channel,
            what=f"is in {words_of(channel, mistake.factor)}{or_in}, "
            f"as {mistake.channel} is",
        )
        for channel in mistake.also
    ]
    return [first, *also]


def _finding(
    mistake: Mistake,
    words: str,
    found: Sequence[Relation],
    factors: dict[str, float],
    rivals: Sequence[Mistake],
) -> Finding:
    trial = factors | mistake.factors
    mine = [r for r in found if not mistake.factors.keys().isdisjoint(r.powers)]
    mended = [
        r
        for r in mine
        if r.allows(_expected(r, trial)) and not r.allows(_expected(r, factors))
    ]
    witness = mended or mine
    verb = {"sign": "has", "unit": "is in"}.get(mistake.kind, "is")
    what = f"{verb} {words}"
    seen = "; ".join(
        f"{r.what}: {_factor(r, _expected(r, factors))}" for r in witness[:2]
    )
    what += f" ({seen})"
    if rivals:
        others = {f"{r.channel} ({r.words})" for r in rivals}
        what += f"; or it is {', '.join(sorted(others))}"
    strength = max(abs(r.correlation) for r in witness)
    sure = (0.98 if len(witness) > 1 else 0.9) * min(1.0, 0.6 + 0.4 * strength)
    mend = 1 / mistake.factor
    of = " of motor_speed_erpm" if mistake.kind == "poles" else ""
    action = f"{DROPPED}; {by_map(mend, of)}"
    if mistake.kind == "unit" and any("motor_speed_radps" in r.powers for r in witness):
        action += ", unless the vehicle file's gear, tyre or poles are another car's"
    return Finding(
        mistake.kind,
        mistake.channel,
        what,
        sure=round(sure / (1 + len({r.channel for r in rivals}) * 0.5), 2),
        action=action,
        severity="error",
        factor=mend,
    )


def _factor(relation: Relation, expected: float = 1.0) -> str:
    """Return how a relation is off what other mistakes make of it."""
    off = relation.middle / expected
    if np.isinf(relation.loose):
        return "opposite" if off < 0 else "alike"
    return f"{off:.3g} times what it should be"


def _odd(relation: Relation, expected: float) -> Finding:
    """Return the finding of a relation that is off what named mistakes make of it."""
    channel = next(iter(relation.powers))
    kind = "inconsistent"
    what = f"does not go with the rest ({relation.what}: {_factor(relation, expected)})"
    action = "look at " + " and ".join(relation.powers)
    if relation.powers.keys() == {"battery_voltage_v"}:
        kind = "other_battery"
        off = relation.middle / expected
        what = f"is {off:.3g} times the vehicle file's"
        action = "was it this vehicle that drove?"
        if TENTHS[0] < off < TENTHS[1]:
            action += " Or a VESC that sent tenths of a volt? "
            action += "A --map with `factor = 0.1` mends them"
    return Finding(
        kind,
        channel,
        f"{what}, and no usual unit or sign explains it",
        sure=round(0.8 * abs(relation.correlation), 2),
        action=f"used as it is; {action}",
        severity="warning",
    )


def _other_vehicle(against: Sequence[Relation]) -> Finding:
    """Return the finding of a log that contradicts its vehicle's file in many ways."""
    seen = "; ".join(f"{r.what}: {_factor(r)}" for r in against[:3])
    return Finding(
        "other_vehicle",
        "log",
        f"and vehicle file contradict each other in {len(against)} ways ({seen})",
        sure=0.9,
        action="used as it is; was it this vehicle that drove?",
        severity="warning",
    )
