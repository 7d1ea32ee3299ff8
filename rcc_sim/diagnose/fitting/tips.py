"""How well a fit tells its figures: no better than its likelihood falls about them."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import replace

import numpy as np

from rcc_sim.diagnose.fitting.engine import Engine
from rcc_sim.diagnose.fitting.fit import Fit
from rcc_sim.diagnose.fitting.knobs import Knob
from rcc_sim.side_by_side import each

FALLS, DOUBLED = 2.0, 40
"""Nats that a figure must lose, others held, before it is told by what it loses: as two
standard deviations do; and times that the way there is doubled at most."""

JUMPS = 9
"""Steps by which it is known what is lost at any, where one loses more than it can."""


def no_surer(engine: Engine, fit: Fit, keys: Collection[str]) -> Fit:
    """Return a fit that tells figures no better than its likelihood falls about them.

    Where the model jumps, slopes make it look steeper than it is.
    """
    told = np.diag(fit.information)
    wider = [
        wider_by(engine, fit, k, told[j] ** -0.5) if k.key in keys and told[j] else 1.0
        for j, k in enumerate(fit.knobs)
    ]
    return replace(fit, information=fit.information / np.outer(wider, wider))


def wider_by(engine: Engine, fit: Fit, knob: Knob, sd: float) -> float:
    """Times that a figure, others held, is told worse than its sd says; 1 at least.

    Where the model jumps at any change, as where each moves a launch by a tick, a fit
    stands on a tip: it is told by what is lost beyond that, and no better than to where
    that is as much as those losses scatter.
    """
    x, by = fit.values[knob.key], sd
    lost: list[float] = []
    for _ in range(DOUBLED):
        ends = {knob.within(x - by), knob.within(x + by)} - {x}
        at = [fit.values | {knob.key: end} for end in ends]
        tried = each(lambda v: engine.at(fit, v), at)
        less = [fit.score - f.score for f in tried if f is not None]
        lost.append(float(np.mean(less)) if less else 0.0)
        beyond, scatter = beyond_tip(lost)
        if beyond >= FALLS:
            told = by * float(np.sqrt((1 + scatter) / (2 * beyond)))
            return max(told / sd, 1.0)
        by *= 2
    return 1.0


def beyond_tip(lost: Sequence[float]) -> tuple[float, float]:
    """Return what the last of some losses is beyond a tip, and how those on it scatter.

    Each is over twice the step of the one before. The first tells whether there is a
    tip at all; a parabola that is steeper than its slopes say is none.
    """
    if lost[0] < FALLS or (len(lost) > 2 and lost[-1] > 2 ** len(lost) * lost[0]):
        return lost[-1], 0.0
    if len(lost) <= JUMPS:
        return 0.0, 0.0
    level = float(np.median(lost[:-2]))
    scatter = 2 * float(np.median(np.abs(np.diff(lost[:-2]))))
    clear = min(lost[-2:]) - level >= FALLS + 2 * scatter
    return (lost[-1] - level if clear else 0.0), scatter
