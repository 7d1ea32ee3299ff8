"""What a log reads directly, where an explanation does not agree with it.

At rest a battery gives what its auxiliaries draw, and an accelerometer feels a slope,
whatever the vehicle is. The noise of a drive remembers, so that a few seconds at rest,
or a slope that is off for a minute, may weigh little in a fit: it is told as a doubt.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import maximum_filter1d

from rcc_sim.analyse.logcheck.finding import Finding
from rcc_sim.diagnose.engine import Engine
from rcc_sim.diagnose.fit import Fit
from rcc_sim.diagnose.problem import Problem
from rcc_sim.units import G

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

CLEAR = 6.0
"""Standard errors of a mean from which on it is told."""

LASTS = 1.0
"""Time over which readings are taken for one, being alike. [s]"""

AT_REST = 2.0
"""Least time at rest. [s]"""

SETTLES, STILL = 1.0, 0.005
"""Time about a row over which the vehicle must be still for it to be at rest [s], and
share of its top speed below which it is."""

IDLE = 0.02
"""Share of the drive's power (root mean square) below which what is drawn at rest
matters to no other cause."""

STRETCH = 50.0
"""Time over which an accelerometer is believed. [s]"""

TILTED = 0.006
"""Slope that is no more than the tilt of a car that pulls, or of a sensor. [1]"""


def disagreeing(engine: Engine, fit: Fit, log: int = 0) -> tuple[Finding, ...]:
    """Return what a log reads directly and the fit does not agree with."""
    return (*at_rest(engine, fit, log), *slopes(engine, fit, log))


def at_rest(engine: Engine, fit: Fit, log: int) -> Iterator[Finding]:
    """Tell if the battery gives at rest what the mended model does not draw."""
    problem = engine.problems[log]
    for channel, left, valid in _tracks(engine, fit, log):
        if channel not in ("battery_power_w", "battery_current_a"):
            continue
        rest = valid & _still(problem)
        if rest.sum() * problem.row < AT_REST:
            continue
        mean, error = _mean(left[rest], problem.row)
        usual = float(np.sqrt(np.mean(problem.log[channel][valid] ** 2)))
        if abs(mean) > max(CLEAR * error, IDLE * usual):
            unit = channel.rpartition("_")[2].upper()
            more = "more" if mean > 0 else "less"
            yield Finding(
                "disagrees",
                channel,
                f"is {abs(mean):.3g} {unit} {more} at rest ({rest.sum()} rows) than in "
                "the mended model",
                action="what is drawn at rest is a load, and no drag",
                severity="warning",
            )


def slopes(engine: Engine, fit: Fit, log: int) -> Iterator[Finding]:
    """Tell where the accelerometer felt another slope than the mended model climbs."""
    problem = engine.problems[log]
    time = problem.log["time_s"]
    for channel, left, valid in _tracks(engine, fit, log):
        if channel != "accel_x_mps2" or not problem.drive.imposed:
            continue
        moves = valid & ~_still(problem)
        usual = float(np.median(left[moves])) if moves.any() else 0.0
        worst, begins = 0.0, 0.0
        for start in np.arange(time[0], time[-1] - STRETCH, 0.5 * STRETCH):
            there = moves & (time >= start) & (time < start + STRETCH)
            if there.sum() * problem.row < 0.5 * STRETCH:
                continue
            mean, error = _mean(left[there] - usual, problem.row)
            if abs(mean) > max(CLEAR * error, TILTED * G, abs(worst)):
                worst, begins = mean, float(start)
        if not worst:
            continue
        ends = begins + STRETCH
        yield Finding(
            "disagrees",
            channel,
            f"felt a slope {100 * worst / G:+.2g} % off the mended model's from "
            f"{begins:.0f} to {ends:.0f} s",
            action="what the model climbs there is a drag, or the sensor tilts",
            severity="warning",
            start_s=begins,
            end_s=ends,
        )


def _tracks(engine: Engine, fit: Fit, log: int) -> Iterator[tuple[str, Array, Mask]]:
    """Channels of a log, what the fit leaves of each, and the rows that count."""
    for (i, channel), left, noise in zip(
        engine.tracks, fit.residuals, fit.noise, strict=True
    ):
        if i == log:
            yield channel, left, noise.valid


def _still(problem: Problem) -> Mask:
    """Rows at rest, before the drive too."""
    rows = max(round(SETTLES / problem.row), 1)
    return np.asarray(
        maximum_filter1d(problem.speed, rows) < STILL * float(problem.speed.max())
    )


def _mean(x: Array, row: float) -> tuple[float, float]:
    """Mean and its standard error, readings within ``LASTS`` being as good as one."""
    alone = max(len(x) * min(row / LASTS, 1.0), 1.0)
    return float(x.mean()), float(x.std() / np.sqrt(alone))
