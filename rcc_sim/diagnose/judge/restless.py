"""Channels of which what is left wanders, though it should have been explained.

A noise that remembers takes whatever comes slowly: the force of a rough road, and what
the library does not hold. Where most of what tells a cause lies in channels of which as
much still comes and goes, it may stand for something unknown. So may the noise, where
no cause stands.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from rcc_sim.analyse.logcheck.finding import Finding
from rcc_sim.diagnose.causes.cause import Cause
from rcc_sim.diagnose.fitting.engine import Engine
from rcc_sim.diagnose.fitting.fit import Fit

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

WANDERS = 2.0
"""Times its scatter from row to row from which on what is left of a channel wanders. Of
63 commanded drives of the blind plant with known causes or none none has more than 1.4,
of 22 with something else nine have more than 2."""

LATER, STILL = 0.5, 0.5
"""Time [s], and share of what is left that is still there then: the noise that a sensor
filters is not."""

BESIDE = 0.1
"""Share of what the causes took out of a channel: if what is still there later is less,
it is an error of their size or course."""

MOST = 0.5
"""Share of a cause in such channels from which on it is doubtful."""


def restless(engine: Engine, fit: Fit, null: Fit) -> Mask:
    """Tell of each track whether what a fit leaves wanders.

    With e what is left by the fit, e+ the same some time later, Δe its change from row
    to row, and e' what is left by the tolerances alone, means over the rows that count:
    e² > 4 (Δe)² / 2, e e+ > e² / 2 and e e+ > (e'² - e²) / 10; no channel scatters less
    than the least noise by which it is judged. Of vehicles that were driven by
    commands: one that is driven by its measured motion shows the road, and what drove
    it, in all that it takes.
    """
    found = np.zeros(len(engine.tracks), bool)
    for i, (log, _) in enumerate(engine.tracks):
        problem, ok, e = engine.problems[log], engine.valid[i], fit.residuals[i]
        if problem.drive.imposed:
            continue
        later = max(round(LATER / problem.row), 1)
        power, before = _power(e, ok), _power(null.residuals[i], ok)
        next_to, beyond = ok[1:] & ok[:-1], ok[later:] & ok[:-later]
        if not (next_to.any() and beyond.any()):
            continue
        scatter = max(_power(np.diff(e), next_to) / 2, engine.least[i] ** 2)
        slow = float(np.mean(e[later:][beyond] * e[:-later][beyond]))
        found[i] = (
            power > WANDERS**2 * scatter
            and slow > STILL * power
            and slow > BESIDE * (before - power)
        )
    return found


def _power(e: Array, ok: Mask) -> float:
    """Mean square over the rows that count."""
    return float(np.mean(e[ok] ** 2))


def is_doubtful(cause: Cause, loose: Mask) -> bool:
    """Tell whether a cause shows in channels that wander, most of all."""
    return bool(len(cause.shares)) and float(cause.shares @ loose) > MOST


def unaccounted(causes: Sequence[Cause], loose: Mask) -> Mask:
    """Tell which channels that wander speak against what is said of a log.

    Those beside a doubtful cause, and where there is none.
    """
    if any(is_doubtful(c, loose) for c in causes) or not causes:
        return loose
    return np.zeros_like(loose)


def coming_and_going(
    engine: Engine, causes: Sequence[Cause], loose: Mask, log: int
) -> tuple[Finding, ...]:
    """Return what to say of a log's channels that are ``unaccounted``."""
    against = unaccounted(causes, loose)
    tracks = zip(engine.tracks, against, strict=True)
    first, *others = [c for (i, c), wanders in tracks if i == log and wanders] or [""]
    if not first:
        return ()
    names = " or ".join(c.effect for c in causes if is_doubtful(c, loose))
    also = f"; so does {' and '.join(others)}" if others else ""
    return (
        Finding(
            "restless",
            first,
            f"comes and goes{names and ' beside '}{names}, more than {WANDERS:g} times "
            f"as far as it scatters from row to row{also}",
            action="what acts now and then, and is not in the library, may have passed "
            "for what acts all the time, or for noise",
            severity="warning",
        ),
    )
