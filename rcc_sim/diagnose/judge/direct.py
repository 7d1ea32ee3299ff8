"""What a log reads directly, where an explanation does not agree with it.

A channel of which the model errs by more than all that was measured is nearer to no
model at all; in a short log a noise that remembers may take that. At rest a battery
gives what its auxiliaries draw, and an accelerometer feels a slope, whatever the
vehicle is. Against a drive a few seconds at rest may weigh little in a fit, and so may
a slope that is off for a minute, to a noise that remembers: it is told as a doubt.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from rcc_sim.analyse.heading import TURN_RATE
from rcc_sim.analyse.logcheck.finding import Finding
from rcc_sim.diagnose.causes.cause import Cause
from rcc_sim.diagnose.causes.strengths import CLIMBS
from rcc_sim.diagnose.fitting.engine import ALIKE, GIVEN, Engine
from rcc_sim.diagnose.fitting.fit import Fit
from rcc_sim.diagnose.residuals.problem import Problem
from rcc_sim.diagnose.residuals.shapes import FELT
from rcc_sim.units import G

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

DISAGREES = "disagrees"

CLEAR = 6.0
"""Standard errors of a mean from which on it is told."""

AT_REST = 2.0
"""Least time at rest. [s]"""

IDLE = 0.02
"""Share of the drive's power (root mean square) below which what is drawn at rest
matters to no other cause."""

OPPOSED = 2.0
"""Mean square of what is left of a channel, of that which was measured, from which on
the model opposes it: beside a true one the noise is left, no more than was measured."""

STRETCH = 50.0
"""Time over which an accelerometer is believed. [s]"""

TILTED = 0.006
"""Slope that is no more than the tilt of a car that pulls, or of a sensor. [1]"""


def disagreeing(engine: Engine, fit: Fit, log: int = 0) -> tuple[Finding, ...]:
    """Return what a log reads directly and the fit does not agree with."""
    problem = engine.problems[log]
    rest = problem.at_rest
    tracks = zip(engine.tracks, fit.residuals, fit.noise, strict=True)
    left = {c: (e, noise.valid) for (i, c), e, noise in tracks if i == log}
    found = [
        at_rest(problem, channel, *left[channel], rest)
        for channel in GIVEN
        if channel in left
    ]
    turns = TURN_RATE if "yaw_rate_radps" in left else None  # which is one motion
    each = [c for c in left if c != turns]
    found += [opposed(problem, channel, *left[channel]) for channel in each]
    if FELT in left and problem.drive.imposed:
        found.append(slopes(problem, *left[FELT], rest))
    return tuple(one for one in found if one)


def felt_otherwise(cause: Cause, findings: Iterable[Finding]) -> bool:
    """Tell whether a cause is a hill, and the accelerometer felt another."""
    hill = bool(cause.profiles) and any(key in CLIMBS for key in cause.keys)
    return hill and any((f.kind, f.channel) == (DISAGREES, FELT) for f in findings)


def at_rest(
    problem: Problem, channel: str, left: Array, valid: Mask, rest: Mask
) -> Finding | None:
    """Tell if the battery gives at rest what the mended model does not draw."""
    rest = valid & rest
    if rest.sum() * problem.row < AT_REST:
        return None
    mean, error = _mean(left[rest], problem.row)
    usual = float(np.sqrt(np.mean(problem.log[channel][valid] ** 2)))
    if abs(mean) <= max(CLEAR * error, IDLE * usual):
        return None
    unit = channel.rpartition("_")[2].upper()
    more = "more" if mean > 0 else "less"
    return Finding(
        DISAGREES,
        channel,
        f"is {abs(mean):.3g} {unit} {more} at rest ({rest.sum()} rows) than in the "
        "mended model",
        action="what is drawn at rest is a load, and no drag",
        severity="warning",
    )


def opposed(problem: Problem, channel: str, left: Array, valid: Mask) -> Finding | None:
    """Tell if the mended model is farther from a channel than none would be."""
    seen = problem.log[channel][valid]
    if float(left[valid] @ left[valid]) <= OPPOSED * float(seen @ seen):
        return None
    return Finding(
        "opposed",
        "yaw_rad" if channel == TURN_RATE else channel,
        "is so far from the mended model that predicting none would do better",
        action="is it a sign, a clock, or not what was asked of the car?",
        severity="warning",
    )


def slopes(problem: Problem, left: Array, valid: Mask, rest: Mask) -> Finding | None:
    """Tell where the accelerometer felt another slope than the mended model climbs."""
    time, moves = problem.log["time_s"], valid & ~rest
    usual = float(np.median(left[moves])) if moves.any() else 0.0
    starts = np.arange(time[0], time[-1] - STRETCH, 0.5 * STRETCH)
    off = np.zeros(len(starts))
    for i, start in enumerate(starts):
        there = moves & (time >= start) & (time < start + STRETCH)
        if there.sum() * problem.row < 0.5 * STRETCH:
            continue
        mean, error = _mean(left[there] - usual, problem.row)
        if abs(mean) > max(CLEAR * error, TILTED * G):
            off[i] = mean
    if not off.any():
        return None
    first = last = int(np.argmax(np.abs(off)))
    while first > 0 and off[first - 1] * off[first] > 0:
        first -= 1
    while last < len(off) - 1 and off[last + 1] * off[last] > 0:
        last += 1
    worst = float(off[first : last + 1].mean())
    begins, ends = float(starts[first]), float(starts[last] + STRETCH)
    return Finding(
        DISAGREES,
        FELT,
        f"felt a slope {100 * worst / G:+.2g} % off the mended model's from "
        f"{begins:.0f} to {ends:.0f} s",
        action="what the model climbs there is a drag, or the sensor tilts",
        severity="warning",
        start_s=begins,
        end_s=ends,
    )


def _mean(x: Array, row: float) -> tuple[float, float]:
    """Mean and its standard error, readings within ``ALIKE`` being as good as one."""
    alone = max(len(x) * min(row / ALIKE, 1.0), 1.0)
    return float(x.mean()), float(x.std() / np.sqrt(alone))
