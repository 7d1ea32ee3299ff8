"""What no column tells from a road that climbs on the whole."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from rcc_sim.analyse.logcheck.finding import Finding
from rcc_sim.diagnose.causes.strengths import RELIEF
from rcc_sim.diagnose.judge.asserted import Asserted
from rcc_sim.diagnose.residuals.problem import Problem
from rcc_sim.diagnose.residuals.shapes import FELT
from rcc_sim.simulate.drive import is_surveyed
from rcc_sim.units import G

TELLS = "heights of start and end tell, or the way back"


def mean_slopes(
    problem: Problem, asserted: Sequence[Asserted], log: int = 0
) -> tuple[Finding, ...]:
    """Return what to say of a mean slope where no column tells it.

    That of hills acts as a rolling resistance that is larger by as much, and is known
    by what the file states of that alone; and where none was found, what resists at any
    speed alike may be a road's that climbs so.
    """
    if is_surveyed(problem.log):
        return ()
    hills = any(a.cause.along_way for a in asserted)
    return (*of_hills(asserted, log), *(() if hills else instead(problem, asserted)))


def of_hills(asserted: Sequence[Asserted], log: int) -> Iterator[Finding]:
    """Yield what to say of the mean of hills that climb on the whole."""
    for a in asserted:
        for slope in a.figures.values():
            varies = a.cause.along_way and log in a.cause.profiles
            if varies and slope.low * slope.high > 0.0:
                yield Finding(
                    "mean_slope",
                    "elevation_m",
                    f"is not logged: a mean slope of {slope.value:.2g} rests on the "
                    "rolling resistance that the file states; another of that does as "
                    "well",
                    action=TELLS,
                )


def instead(problem: Problem, asserted: Sequence[Asserted]) -> Iterator[Finding]:
    """Yield which slope would do as well as what resists at any speed alike.

    Of a log without an accelerometer, and no higher than a drive may well end:
    Δs = ΔC_rr, ΔT N_d / (r_w m g), ΔA / (m g).
    """
    if FELT in problem.channels:
        return
    weight = problem.vehicle.body.mass_kg.value * G
    per_unit = {
        "effects.rolling_resistance.coefficient": 1.0,
        "effects.drivetrain_friction.torque_nm": problem.vehicle.rad_per_m / weight,
        "effects.road_load.a_n": 1.0 / weight,
    }
    way = float(np.ptp(problem.distance))
    for a in asserted:
        for key in (k for k in a.cause.keys if k in per_unit):
            found, stated = a.figures[key.rpartition(".")[2]], problem.stated(key)
            slope = per_unit[key] * (found.value - stated)
            is_off = not found.low <= stated <= found.high
            if is_off and abs(slope) * way < 2.0 * RELIEF:
                yield Finding(
                    "climb",
                    "elevation_m",
                    f"is not logged, nor what an accelerometer feels: a road that "
                    f"{'climbs' if slope > 0 else 'falls'} by {100 * abs(slope):.2g} % "
                    f"on the whole would do as well as {a.cause.effect}",
                    action=TELLS,
                )
