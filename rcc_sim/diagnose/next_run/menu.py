"""Runs that could be driven next, within what a log shows the vehicle can do."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from rcc_sim.definitions.vehicle import Vehicle
from rcc_sim.diagnose.next_run.limits import Limits
from rcc_sim.diagnose.residuals.problem import Problem
from rcc_sim.simulate.drive import drive_of
from rcc_sim.simulate.replay import replay
from rcc_sim.trace import Trace

Array = NDArray[np.float64]

LOAD = 0.1
"""Known load that is taken on board, as a share of the mass."""

SLOWEST_COAST = 0.02
"""Least deceleration of a coast, as a share of the vehicle's own. [1]"""

ROAD, STAND, LOADED = "road", "stand", "loaded"


@dataclass(frozen=True)
class Leg:
    """One stretch of a run: commanded level and steering over time.

    ``level`` is the speed [m/s], or the throttle; ``back`` drives it the other way.
    """

    time: Array
    level: Array
    steer: Array
    back: bool = False


@dataclass(frozen=True)
class Run:
    """A run of the menu.

    Parameters
    ----------
    do : str
        What to do, in words.
    legs : tuple of Leg
        What is commanded.
    where : str
        road, stand (wheels off the ground) or loaded (a known load on board).
    times : int
        How often it is driven.
    """

    do: str
    legs: tuple[Leg, ...]
    where: str = ROAD
    times: int = 1

    @property
    def once(self) -> float:
        """Time that it takes to drive it once. [s]"""
        return float(sum(leg.time[-1] for leg in self.legs))

    @property
    def seconds(self) -> float:
        """Time that it takes. [s]"""
        return self.times * self.once

    @property
    def words(self) -> str:
        """What to do, and how often."""
        return self.do + (f", {self.times} times" if self.times > 1 else "")

    @property
    def commands(self) -> Leg:
        """What is commanded in one go: every repetition, or one way of out and back."""
        leg, row = self.legs[0], float(self.legs[0].time[1])
        times = 1 if self.is_both_ways else self.times
        starts = np.arange(times) * (leg.time[-1] + row)
        return Leg(
            (starts[:, None] + leg.time).ravel(),
            np.tile(leg.level, times),
            np.tile(leg.steer, times),
        )

    @property
    def is_commanded(self) -> bool:
        """Whether commands make it, given to the vehicle as it is, on the road."""
        return self.where == ROAD

    @property
    def is_both_ways(self) -> bool:
        """Whether the same is driven out and back along a road."""
        return len(self.legs) > 1


class Path:
    """Commands of a leg, drawn piece by piece."""

    def __init__(self, limits: Limits, gain: float = 1.0) -> None:
        self.limits, self.gain = limits, gain
        self.knots: list[tuple[float, float, float]] = [(0.0, 0.0, 0.0)]

    def hold(self, seconds: float, steer: float = 0.0) -> Path:
        """Hold the level, at a steering angle; the wheels turn within 0.1 s."""
        t, v, was = self.knots[-1]
        if steer != was:
            self.knots.append((t + 0.1, v, steer))
        self.knots.append((t + max(seconds, 0.2), v, steer))
        return self

    def to(self, speed: float, accel: float | None = None) -> Path:
        """Come to a speed at an acceleration, the limit's where not given."""
        t, v, angle = self.knots[-1]
        a = accel or self.limits.accel
        self.knots.append((t + max(abs(speed - v) / a, 0.05), speed, angle))
        return self

    def jump(self, speed: float) -> Path:
        """Command another speed at once."""
        t, _, angle = self.knots[-1]
        self.knots.append((t + 0.02, speed, angle))
        return self

    def coast(self, curve: Array | None) -> Path:
        """Let go until it stands: the command falls to 0, or the speed on a curve."""
        if curve is None:
            return self.jump(0.0).hold(0.5 * self.limits.seconds)
        t, v, _ = self.knots[-1]
        seconds, speed = curve
        start = int(np.argmax(speed <= v))
        for s, x in zip(seconds[start:], speed[start:], strict=True):
            self.knots.append((t + 0.1 + s - seconds[start], float(x), 0.0))
        return self

    def leg(self, row: float, back: bool = False) -> Leg:
        """Return the commands at rows."""
        self.to(0.0).hold(self.limits.still)
        knots = np.array(self.knots)
        time = np.arange(0.0, knots[-1, 0], row)
        level, steer = (np.interp(time, knots[:, 0], knots[:, k]) for k in (1, 2))
        return Leg(time, self.gain * level, steer, back)


def menu(problem: Problem, limits: Limits, row: float) -> list[Run]:
    """Return every run that could be driven, rows being ``row`` seconds apart.

    Each is driven as often as the log's own time allows, so that all take alike.
    """
    top, a, gain = limits.top, limits.accel, limits.command / limits.top
    curve = coast_curve(problem, top) if problem.drive.imposed else None
    hold = max(0.03 * limits.seconds, 2.5)

    def begun() -> Path:
        return Path(limits, gain).hold(limits.still)

    def coast(back: bool) -> Leg:
        return begun().to(top).hold(2.0).coast(curve).leg(row, back)

    def steady(back: bool) -> Leg:
        return begun().to(0.7 * top).hold(4 * hold).leg(row, back)

    def levels() -> Leg:
        path = begun()
        for share in (0.25, 0.45, 0.65, 0.85, 1.0, 0.5):
            path.to(share * top).hold(hold)
        return path.leg(row)

    def ladder() -> Leg:
        path = begun()
        for share in (0.33, 0.66, 1.0):
            path.to(top, share * a).hold(1.0).to(0.2 * top, share * a).hold(1.0)
        return path.leg(row)

    def jumps() -> Leg:
        path = begun()
        for share in (0.3, 0.6, 0.4, 1.0, 0.6, 0.8, 0.2):
            path.jump(share * top).hold(hold)
        return path.jump(0.0).hold(hold).leg(row)

    def waiting() -> Leg:
        time = np.arange(0.0, 60.0, row)
        return Leg(time, 0 * time, 0 * time)

    runs = [
        Run(f"hold six speeds up to {top:.3g} m/s, straight ahead", (levels(),)),
        Run(
            f"speed up and slow down at a third, two thirds and all of {a:.2g} m/s2",
            (ladder(),),
        ),
        Run("stand still with the electronics on", (waiting(),)),
        Run(
            f"drive a stretch at {0.7 * top:.3g} m/s out and back",
            (steady(False), steady(True)),
        ),
        Run(
            f"speed up and slow down with a known load of {LOAD:.0%} of the mass",
            (ladder(),),
            LOADED,
        ),
    ]
    if limits.coasts:
        words = f"coast down from {top:.3g} m/s"
        runs.append(Run(words, (coast(False),)))
        runs.append(Run(f"{words} in both directions", (coast(False), coast(True))))
    if not problem.drive.imposed:
        runs.append(Run("step the command up and down, straight ahead", (jumps(),)))
        if "road_load" not in problem.vehicle.effects:
            words = "spin the wheels off the ground at several speeds"
            runs.append(Run(words, (jumps(),), STAND))
    if limits.steer:
        runs += cornering(limits, begun, hold, row)
    often = [max(round(limits.seconds / r.once), 1) for r in runs]
    return [replace(r, times=n) for r, n in zip(runs, often, strict=True)]


def cornering(
    limits: Limits, begun: Callable[[], Path], hold: float, row: float
) -> list[Run]:
    """Return the runs that steer."""
    top = limits.top

    def circle() -> Leg:
        path, angle = begun(), limits.angle(top)
        for side in (1.0, -1.0):
            for share in (0.3, 0.5, 0.7, 0.85, 1.0):
                path.to(share * top).hold(hold, side * angle)
            path.hold(1.0).to(0.3 * top)
        return path.leg(row)

    def steps() -> Leg:
        path = begun()
        for share in (0.35, 0.65, 1.0):
            angle = limits.angle(share * top)
            path.to(share * top).hold(1.0)
            for side in (1.0, -1.0, 0.5, -0.5):
                path.hold(0.5 * hold, side * angle).hold(0.5 * hold)
        return path.leg(row)

    def slalom() -> Leg:
        path = begun()
        for share in (0.4, 0.7, 1.0):
            angle = limits.angle(share * top)
            path.to(share * top)
            for period in (0.5 * hold, 0.2 * hold):
                for k in range(8):
                    path.hold(0.5 * period, angle * (-1.0) ** k)
            path.hold(1.0)
        return path.leg(row)

    return [
        Run("hold a constant radius at rising speed, both ways round", (circle(),)),
        Run("step the steering at three speeds, both ways", (steps(),)),
        Run("slalom at three speeds, slowly and quickly", (slalom(),)),
    ]


def coast_curve(problem: Problem, top: float) -> Array:
    """Return time [s] and speed [m/s] of a coast, by the nominal vehicle.

    From the motor's torque in two imposed ramps down, the deceleration at which it is
    nought at each speed follows on a straight line.
    """
    speeds = np.linspace(top, 0.05 * top, 40)
    tau = []
    ramps = np.array([0.1, 0.5])
    for a in ramps:
        time = np.arange(0.0, 0.95 * top / a, 0.1)
        log = Trace({"time_s": time, "speed_mps": top - a * time})
        out = replay(problem.vehicle, drive_of(log, problem.vehicle))
        tau.append(
            np.interp(-speeds[1:], -log["speed_mps"][1:], out["motor_torque_nm"][1:])
        )
    slope = (tau[1] - tau[0]) / (ramps[1] - ramps[0])
    rate = np.maximum(ramps[0] - tau[0] / np.minimum(slope, -1e-12), SLOWEST_COAST)
    seconds = np.concatenate([[0.0], np.cumsum(-np.diff(speeds) / rate)])
    return np.stack([seconds, speeds])


def at_place(
    vehicle: Vehicle, figures: dict[str, float], where: str
) -> dict[str, float]:
    """Return the figures of a vehicle as they act where it is driven."""
    if where != LOADED:
        return figures
    stated = vehicle.figures().get(PAYLOAD)
    load = figures.get(PAYLOAD, stated.value if stated else 0.0)
    return figures | {PAYLOAD: load + LOAD * vehicle.body.mass_kg.value}


PAYLOAD = "effects.payload.mass_kg"
