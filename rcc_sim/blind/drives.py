"""What is driven: speed and steering programmes, rough roads, hills, heaters."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rcc_sim.blind.bases import Base
from rcc_sim.blind.plant import CLOCK, Drive

Array = NDArray[np.float64]
Rows = NDArray[np.int64]
SLOPE_STEP = 5.0  # m
STRAIGHT = 0.02  # 1; share of the top speed below which none steers; fades in to twice
STYLES = {
    "rc": {"track": (1.0, 0.15), "stop_and_go": (0.75, 0.4), "brisk": (1.0, 0.25)},
    "ev": {"urban": (0.65, 0.3), "highway": (1.0, 0.1), "stop_and_go": (0.45, 0.5)},
}
"""Share of the top speed, and how often a piece ends in a stop, by style."""


@dataclass(frozen=True)
class Timing:
    """Lengths, rates and accelerations of a family's drives."""

    seconds: float
    row: float  # s between rows
    tick: float  # s, of the controller
    substeps: int
    accel: tuple[float, float]  # m/s²
    hold: tuple[float, float]  # s
    stop: tuple[float, float]  # s
    period: tuple[float, float]  # s, of a slalom
    a_y: tuple[float, float]  # m/s², aimed at
    most_steer: float  # rad
    rough: tuple[float, float]  # m/s², sd of the random acceleration
    rough_s: tuple[float, float]  # s, its correlation time


TIMING = {
    "rc": Timing(
        75.0, 0.01, 1e-3, 4, (0.4, 2.0), (1.5, 8.0), (1.5, 5.0), (0.8, 3.0),
        (1.5, 4.5), 0.2, (0.02, 0.045), (0.3, 0.8),
    ),
    "ev": Timing(
        600.0, 0.1, 1e-3, 1, (0.6, 2.2), (4.0, 30.0), (4.0, 20.0), (2.0, 8.0),
        (0.6, 2.8), 0.05, (0.012, 0.03), (0.4, 1.5),
    ),
}  # fmt: skip


@dataclass(frozen=True)
class Road:
    """What stays the same on every drive of a case."""

    slope: Array  # profile over distance, every SLOPE_STEP
    aux: Array  # W, at each second
    wind: Array  # m/s against the drive, likewise
    rough: float
    rough_s: float


def speed_programme(car: Base, style: str, rng: np.random.Generator) -> Array:
    """Return a speed reference on the clock [m/s]: ramps, holds, stops."""
    how = TIMING[car.family]
    share, p_stop = STYLES[car.family][style]
    top = share * car.v_max
    times, speeds = [0.0, rng.uniform(1.2, 2.5)], [0.0, 0.0]
    while times[-1] < how.seconds:
        now = speeds[-1]
        goal = top * rng.uniform(0.35, 1.0)
        if now > 0 and rng.random() < p_stop:
            goal = 0.0
        span = abs(goal - now) / rng.uniform(*how.accel)
        times.append(times[-1] + max(span, 0.2))
        speeds.append(goal)
        rest = how.stop if goal == 0 else how.hold
        times.append(times[-1] + rng.uniform(*rest))
        speeds.append(goal)
    t = np.arange(round(how.seconds / CLOCK) + 1) * CLOCK
    reference: Array = np.interp(t, times, speeds)
    if car.family == "ev":  # a foot is not a ramp: half a second of smoothing
        kernel = np.ones(50) / 50
        padded = np.pad(reference, 25, mode="edge")
        reference = np.convolve(padded, kernel, "same")[25:-25]
        reference[reference < 1e-9] = 0.0
    return reference


def steering_programme(car: Base, speed: Array, rng: np.random.Generator) -> Array:
    """Return a steering command on the clock [rad]: slaloms, lane changes, arcs.

    The amplitude aims at a lateral acceleration, A = l a_y / v², within a limit. It
    never jumps, so that samples of it tell what it was in between.
    """
    how = TIMING[car.family]
    steer = np.zeros(len(speed))
    wheelbase = car.l_F + car.l_R
    t = float(rng.uniform(2.5, 5.0))
    while t < how.seconds:
        k = min(round(t / CLOCK), len(speed) - 1)
        since = k - (800 if car.regen == 0 else 0)  # it coasts: still at that speed
        v = max(speed[max(since, 0) : k + 300].max(), 0.3 * car.v_max)
        most = min(how.most_steer, wheelbase * rng.uniform(*how.a_y) / v**2)
        A = most * rng.choice([-1.0, 1.0])
        period = rng.uniform(*how.period)
        kind = rng.choice(["slalom", "lane", "arc", "step"], p=[0.35, 0.3, 0.25, 0.1])
        long = period * (rng.integers(2, 6) if kind == "slalom" else 1)
        if kind in ("arc", "step"):
            long = 2.0 * period
        x = np.arange(round(long / CLOCK)) * CLOCK
        if kind in ("slalom", "lane"):
            shape = A * np.sin(2 * np.pi * x / period)
        else:
            ramp = 0.05 if kind == "step" else 0.3 * period
            shape = A * np.clip(np.minimum(x, long - x) / ramp, 0.0, 1.0)
        end = min(k + len(shape), len(steer))
        steer[k:end] = shape[: end - k]
        t += long + rng.uniform(0.3, 1.5) * how.period[1]
    fades = np.clip(speed / (STRAIGHT * car.v_max) - 1.0, 0.0, 1.0)
    return np.asarray(steer * fades, dtype=np.float64)


def rough_road(n: int, sd: float, seconds: float, rng: np.random.Generator) -> Array:
    """Return a random acceleration on the clock [m/s²], of Ornstein and Uhlenbeck."""
    from scipy.signal import lfilter

    keep = np.exp(-CLOCK / seconds)
    kicks = sd * np.sqrt(1 - keep**2) * rng.standard_normal(n)
    return np.asarray(lfilter([1.0], [1.0, -keep], kicks), dtype=np.float64)


def hills(length: float, sd: float, rng: np.random.Generator) -> Array:
    """Return a slope over distance [1] with a mean near 0: eight waves of a road."""
    s = np.arange(0.0, length, SLOPE_STEP)
    waves = np.exp(rng.uniform(np.log(250.0), np.log(2500.0), 8))
    phases = rng.uniform(0, 2 * np.pi, 8)
    slope = np.sin(2 * np.pi * s[:, None] / waves + phases).sum(axis=1)
    start = np.clip(s / 50.0, 0.0, 1.0)  # level where it stands at first
    return np.asarray(sd * start * slope / slope.std(), dtype=np.float64)


def heater(seconds: float, power: float, rng: np.random.Generator) -> Array:
    """Return a heater's power at each second [W]: full at first, then by turns."""
    t = np.arange(int(seconds) + 2, dtype=np.float64)
    warm = rng.uniform(0.1, 0.3) * seconds
    cycle = rng.uniform(0.06, 0.2) * seconds
    duty = rng.uniform(0.3, 0.6)
    low = rng.uniform(0.0, 0.2)
    on = ((t - warm) % cycle) < duty * cycle
    return np.where((t < warm) | on, power, low * power)


def gusts(seconds: float, sd: float, memory: float, rng: np.random.Generator) -> Array:
    """Return a wind along the drive at each second [m/s], of Ornstein and Uhlenbeck."""
    from scipy.signal import lfilter

    keep = np.exp(-1.0 / memory)
    kicks = rng.standard_normal(int(seconds) + 2)
    kicks[1:] *= np.sqrt(1 - keep**2)
    return np.asarray(sd * lfilter([1.0], [1.0, -keep], kicks), dtype=np.float64)


def turned(
    seconds: float, speed: float, memory: float, rng: np.random.Generator
) -> Array:
    """Return the same of a steady wind on a road that turns about every so often."""
    at, way, sign = [0.0], [], float(rng.choice([-1.0, 1.0]))
    while at[-1] < seconds:
        way.append(sign * speed)
        at.append(at[-1] + memory * rng.uniform(0.5, 1.5))
        sign = -sign
    t = np.arange(int(seconds) + 2, dtype=np.float64)
    which = np.minimum(np.searchsorted(at, t, side="right") - 1, len(way) - 1)
    return np.asarray(way, dtype=np.float64)[which]


def drive(
    car: Base, road: Road, style: str, rng: np.random.Generator
) -> tuple[Drive, int]:
    """Return a drive, and the step at which its first row is written."""
    how = TIMING[car.family]
    speed = speed_programme(car, style, rng)
    steer = steering_programme(car, speed, rng)
    rough = rough_road(len(speed), road.rough, road.rough_s, rng)
    rows, first = written(how, rng)
    return (
        Drive(speed, steer, rough, road.slope, SLOPE_STEP, road.aux, road.wind, rows),
        first,
    )


def written(how: Timing, rng: np.random.Generator) -> tuple[Rows, int]:
    """Return the steps at which rows are written, and the first of them."""
    dt = how.tick / how.substeps
    per_row = round(how.row / dt)
    first = int(rng.integers(max(per_row // 20, 2), per_row - 1))
    return np.arange(first, round(how.seconds / dt), per_row, dtype=np.int64), first


def again(d: Drive, family: str, road: Road, rng: np.random.Generator) -> Drive:
    """Return the same drive on another lane: as rough, elsewhere; rows as they fall."""
    rough = rough_road(len(np.asarray(d.rough)), road.rough, road.rough_s, rng)
    return d._replace(rough=rough, rows=written(TIMING[family], rng)[0])


def smooth(d: Drive) -> Drive:
    """Return the same drive on a road that is not rough."""
    return d._replace(rough=np.zeros(len(np.asarray(d.rough))))
