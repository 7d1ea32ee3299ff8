"""Effects that sum up others: all their figures move once one of them is a cause."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from rcc_sim.diagnose.causes.candidates import Candidate
from rcc_sim.diagnose.causes.cause import Cause
from rcc_sim.diagnose.fitting import descent
from rcc_sim.diagnose.fitting.engine import Engine
from rcc_sim.diagnose.fitting.fit import Fit
from rcc_sim.diagnose.fitting.knobs import Knob
from rcc_sim.side_by_side import each
from rcc_sim.units import unit_of

FORCES = {"N": 0, "N s/m": 1, "N s²/m²": 2}
"""Unit of a figure of a force -> power of speed that it goes with."""


def with_all_figures(
    engine: Engine, fit: Fit, causes: list[Cause], candidates: Sequence[Candidate]
) -> tuple[list[Cause], Fit]:
    """Let all figures of a sum move that is a cause, not those alone that it took.

    Logs that do not tell them apart do not say that the others are zero, either. Each
    may be so large as to do at the log's speed what those found do there. The last
    cause is the newest: where it is a sum, it is begun from what was found, and from an
    equal share of each. One figure was taken after the other, and where a car moves off
    by the one, no step may lead to the other: 13 starts of a car that stood still in
    one more were 316 nats likelier by both.
    """
    sums = {c.effect: c for c in candidates if c.is_sum and c.searches[1:]}
    if not any(c.effect in sums for c in causes):
        return causes, fit
    moving = np.concatenate([p.speed[p.speed > 0] for p in engine.problems])
    v = float(np.sqrt(np.mean(moving**2))) if len(moving) else 1.0
    out: list[Cause] = []
    more: dict[str, Knob] = {}
    even: dict[str, float] = {}
    for cause in causes:
        own = sums.get(cause.effect)
        lacking = own and len(cause.keys) < len(own.searches)
        if own and (lacking or cause is causes[-1]):
            per = {s.key: v ** -FORCES.get(unit_of(s.key), 0) for s in own.searches}
            whole = sum(fit.values[key] / per[key] for key in cause.keys)
            for s in own.searches:
                share = whole * per[s.key] / len(per)
                even[s.key] = min(max(share, s.low), s.high)
                if lacking:
                    sd = abs(whole) * per[s.key]
                    more[s.key] = Knob(s.key, s.neutral, sd, s.low, s.high)
            cause = replace(cause, keys=tuple(per))
        out.append(cause)
    if not even:
        return out, fit
    free = [*(k for k in fit.knobs if k.key not in more), *more.values()]
    neutral = {k.key: k.value for k in more.values()}
    starts = [neutral | fit.values] if more else []  # else they are free, and fitted
    tried = each(
        lambda start: descent.fit(engine, start, free), [*starts, fit.values | even]
    )
    return out, max(tried if more else [fit, *tried], key=lambda f: f.score)
