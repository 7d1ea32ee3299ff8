"""What is given to a run: its rows, and profiles over time and over distance."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rcc_sim.definitions.cycle import Cycle
from rcc_sim.definitions.vehicle import Vehicle
from rcc_sim.errors import InputError
from rcc_sim.physics.effects.road_grade import STEEPEST, rise_over_run
from rcc_sim.trace import Trace

Profile = tuple[ArrayLike, ArrayLike]

OUTPUT_RATE = {"speed": 100.0, "torque": 10.0, "throttle": 100.0}
"""Rows per second where neither user nor file says so. [Hz]"""


def road_profile(road: Trace) -> Profile:
    """Return the slope over distance of a surveyed road, from slope or elevation.

    Where elevation is known, the slope at the middle of two points is rise over run.

    Raises
    ------
    InputError
        If the road has neither, or rises as no road does.
    """
    distance = road["distance_m"] - road["distance_m"][0]
    if "slope" in road:
        return distance, road["slope"]
    height = road["elevation_m"]
    if len(height) < 2:
        raise InputError(f"{road.name}: elevation_m: one row gives no slope")
    way, rise = np.diff(distance), np.diff(height)
    steep = np.abs(rise) > STEEPEST * way
    if steep.any():
        row = int(steep.argmax())
        raise InputError(
            f"{road.name}: elevation_m, row {row + 2}: {rise[row]:+.3g} m in "
            f"{way[row]:.3g} m is steeper than any road",
            "even the heights out over distance, or give the slope",
        )
    middle = 0.5 * (distance[1:] + distance[:-1])
    return middle, rise_over_run(rise, way)


def throttle_drive(log: Trace) -> tuple[Cycle, Profile]:
    """Return duration and speed at the start, and the throttle, of a logged drive."""
    time = log["time_s"]
    first = float(log["speed_mps"][0]) if "speed_mps" in log else 0.0
    speed = np.concatenate([[max(first, 0.0)], np.zeros(len(time) - 1)])
    return Cycle(log.name, time, speed), (time, log["throttle"])


def at_rate(
    cycle: Cycle, yaw_rate: ArrayLike | None, rate: float
) -> tuple[Cycle, ArrayLike | None]:
    """Return a cycle, and the yaw rate at its rows, with so many rows a second.

    Between rows both are straight lines, which is what an imposed run takes them for:
    where the rate is a multiple of the cycle's, losses are but taken at more places.

    Raises
    ------
    InputError
        If the cycle has more rows than that.
    """
    refuse_rate(rate)
    step = float(np.diff(cycle.time_s).min())
    if rate * step < 1 - 1e-9:
        raise InputError(
            f"output rate: {rate:g} Hz is less than {cycle.name} has, a row each "
            f"{step:g} s, and an imposed drive is none without its rows",
            f"{1 / step:g} Hz would be",
        )
    start, end = float(cycle.time_s[0]), float(cycle.time_s[-1])
    rows = math.ceil((end - start) * rate - 1e-9)
    time = np.append(start + np.arange(rows) / rate, end)
    speed = np.interp(time, cycle.time_s, cycle.speed_mps)
    if yaw_rate is not None:
        yaw_rate = np.interp(time, cycle.time_s, yaw_rate_of(cycle, yaw_rate))
    return replace(cycle, time_s=time, speed_mps=speed), yaw_rate


def yaw_rate_of(cycle: Cycle, yaw_rate: ArrayLike | None) -> NDArray[np.float64]:
    """Return a yaw rate at the cycle's rows; a single 0 where there is none."""
    if yaw_rate is None:
        return np.zeros(1)
    yaw = np.ascontiguousarray(yaw_rate, dtype=float)
    if yaw.shape != cycle.time_s.shape:
        raise InputError(
            f"{cycle.name}: yaw rate: should have {len(cycle.time_s)} rows: {yaw.size}"
        )
    return yaw


def sampling(
    vehicle: Vehicle, cycle: Cycle, T_loop: float, rate: float | None
) -> tuple[int, int]:
    """Return the ticks of the control loop per row, and the number of rows."""
    assert vehicle.controller is not None
    if rate is None:
        period = vehicle.effects.get("reference_sampling", {}).get("period_s")
        default = OUTPUT_RATE[vehicle.controller.mode]
        held = getattr(period, "value", 0.0)
        rate = 1 / held if held > 0 and vehicle.controller.mode == "speed" else default
        rate = 1 / (max(round(1 / (rate * T_loop)), 1) * T_loop)  # one the loop has
    refuse_rate(rate)
    every = round(1 / (rate * T_loop))
    if every < 1 or abs(every * rate * T_loop - 1) > 1e-6:
        raise InputError(
            f"output rate: {rate:g} Hz is no whole part of the control loop's "
            f"{1 / T_loop:g} Hz",
            f"{1 / T_loop / max(every, 1):g} Hz would be",
        )
    return every, math.ceil(cycle.duration / (every * T_loop) - 1e-9) + 1


def refuse_rate(rate: float) -> None:
    """Raise if rows cannot come at a rate. [Hz]"""
    if not (math.isfinite(rate) and rate > 0):
        raise InputError(f"output rate: should be positive: {rate:g} Hz")


def refuse_degrees(angle: NDArray[np.float64]) -> None:
    """Raise if a steering angle can only be in degrees."""
    worst = float(np.abs(angle).max())
    if worst > math.pi / 2:
        raise InputError(
            f"steer: row {int(np.abs(angle).argmax()) + 1}: should be below π/2 rad: "
            f"{worst:g}",
            f"radians are meant; {worst:g}° would be {math.radians(worst):.4g}",
        )


def profile_of(
    profile: Profile | None, start: float, what: str
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return a profile as two arrays that start from 0; (0, 0) where there is none."""
    if profile is None:
        return np.zeros(1), np.zeros(1)
    x, y = (np.ascontiguousarray(part, dtype=float) for part in profile)
    if x.shape != y.shape or x.ndim != 1 or len(x) == 0:
        raise InputError(f"{what}: should be two columns of the same length")
    if not (np.isfinite(x).all() and np.isfinite(y).all()):
        raise InputError(f"{what}: should be finite throughout")
    if (np.diff(x) <= 0).any():
        row = int((np.diff(x) <= 0).argmax()) + 2
        raise InputError(f"{what}: row {row}: the first column should increase")
    return x - start, y
