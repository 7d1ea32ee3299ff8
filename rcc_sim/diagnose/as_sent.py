"""Commands that were logged as they were sent, and hold until the next one."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from rcc_sim.analyse.sampled import SAMPLE
from rcc_sim.diagnose import descent
from rcc_sim.diagnose.cause import ENOUGH
from rcc_sim.diagnose.compete import Explanation
from rcc_sim.diagnose.engine import Engine
from rcc_sim.diagnose.fit import Fit
from rcc_sim.simulate.drive import Drive


def as_sent(
    engine: Engine,
    null: Fit | None,
    explained: Callable[[Engine, Fit | None], Explanation],
) -> tuple[Engine, Explanation]:
    """Return logs and explanation, commands holding between rows where likelier.

    A command that runs straight from row to row leads one that holds by half a row; and
    so do flows that are samples such as are means since the row before. Where the
    vehicle as it is stated likes it better so, all is explained so. But a motor or a
    steering that is late, or slow, may seem to hold it: where what was found may do as
    well, or fewer causes, without, all is explained once more, and the likelier
    explanation stands. A cause fewer is worth what one must gain.

    ``null`` is what tolerances alone leave as the logs are, where that is known.
    """
    ways = list(zip(*(held(p.drive) for p in engine.problems), strict=False))
    others = engine.each(partial(with_drives, engine), ways)
    each = engine.each(likelihood, others)
    if not others or max(each) < likelihood(engine) + ENOUGH:
        return engine, explained(engine, null)
    best = others[int(np.argmax(each))]
    found = explained(best, None)
    acting = found.engine
    straight = [
        replace(p.drive, held=q.drive.held, window=q.drive.window)
        for p, q in zip(acting.problems, engine.problems, strict=True)
    ]
    now = descent.fit(with_drives(acting, straight), found.fit.values, found.fit.knobs)
    if now.score + ENOUGH * len(found.causes) <= found.fit.score:
        return best, found
    other = explained(engine, null)
    fewer = len(other.causes) - len(found.causes)
    if found.fit.score + ENOUGH * fewer <= other.fit.score:
        return engine, other
    return best, found


def with_drives(engine: Engine, drives: Sequence[Drive]) -> Engine:
    """Return the logs with other drives."""
    pairs = zip(engine.problems, drives, strict=True)
    return Engine([replace(p, drive=drive) for p, drive in pairs])


def held(drive: Drive) -> list[Drive]:
    """Return a drive with reference, steering or both held, by samples and means."""
    if drive.imposed:
        return []
    windows = sorted({min(drive.window, SAMPLE), drive.window})
    ways = [(True, False), (False, True), (True, True)]
    return [
        replace(drive, held=either(drive.held, way), window=window)
        for way in ways
        for window in windows
    ]


def either(one: tuple[bool, bool], other: tuple[bool, bool]) -> tuple[bool, bool]:
    """Return what either of two says of reference and steering."""
    return one[0] or other[0], one[1] or other[1]


def likelihood(engine: Engine) -> float:
    """Log-likelihood of the vehicle as it is stated, under the noise that it leaves."""
    left = engine.residuals({})
    return engine.loglik(left, engine.learn_noise(left))
