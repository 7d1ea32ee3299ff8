"""What a channel of a log is often wrong by: units, signs, poles for pole pairs."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations
from math import degrees, pi
from typing import NamedTuple

import numpy as np

from rcc_sim.analyse.logcheck.finding import Array, Columns, sampled
from rcc_sim.definitions.vehicle import Vehicle
from rcc_sim.readers.suggest import STEERING_RATIO
from rcc_sim.units import G


class Mistake(NamedTuple):
    """A factor that a channel is often wrong by, and what people call it."""

    channel: str
    kind: str  # unit, sign or poles
    factor: float
    words: str
    prior: float  # the smaller, the less usual
    also: tuple[str, ...] = ()  # channels that are wrong by it with this one

    @property
    def factors(self) -> dict[str, float]:
        """Factor by each channel that is wrong."""
        return dict.fromkeys((self.channel, *self.also), self.factor)


DEG = degrees(1.0)
LARGEST_MODEL = 1.0
"""Wheelbase below which no vehicle has a steering wheel. [m]"""

RPM = 30 / pi

UNITS: dict[str, tuple[tuple[float, str], ...]] = {
    "speed_mps": (
        (3.6, "km/h"),
        (2.2369, "mph"),
        (1000.0, "mm/s"),
        (100.0, "cm/s"),
        (1 / 3.6, "m/s that were taken for km/h"),
    ),
    "speed_ref_mps": ((3.6, "km/h"), (2.2369, "mph"), (1000.0, "mm/s")),
    "steer_cmd_rad": ((DEG, "degrees"),),
    "yaw_rate_radps": ((DEG, "deg/s"),),
    "yaw_rad": ((DEG, "degrees"),),
    "accel_x_mps2": ((1 / G, "g"), (1000 / G, "mg"), (100.0, "cm/s²")),
    "accel_y_mps2": ((1 / G, "g"), (1000 / G, "mg"), (100.0, "cm/s²")),
    "motor_speed_radps": ((RPM, "rpm"),),
    "motor_torque_nm": ((1000.0, "mN m"), (100.0, "N cm")),
    "motor_current_a": ((1000.0, "mA"), (0.001, "kA")),
    "battery_voltage_v": ((1000.0, "mV"), (0.001, "kV")),
    "battery_current_a": ((1000.0, "mA"), (0.001, "kA")),
    "battery_power_w": ((0.001, "kW"), (1000.0, "mW")),
    "aux_power_w": ((0.001, "kW"),),
    "x_m": ((1000.0, "mm"), (100.0, "cm")),
    "distance_m": ((1000.0, "mm"), (0.001, "km")),
    "time_s": ((1e3, "ms"), (1e6, "µs"), (1e9, "ns")),
}

DRIVING = ("battery_current_a", "battery_power_w", "motor_current_a", "motor_torque_nm")
"""What drives the car, and is negative where it brakes it."""

SIGNED = (
    *DRIVING,
    *("accel_x_mps2", "accel_y_mps2", "steer_cmd_rad", "yaw_rate_radps", "yaw_rad"),
    *("motor_speed_radps", "speed_ref_mps", "speed_mps"),
)
"""What may have the other sign, the likelier first."""

TOGETHER = {
    ("speed_mps", "speed_ref_mps"): -0.1,
    ("yaw_rate_radps", "steer_cmd_rad", "yaw_rad"): -0.1,
    ("accel_x_mps2", "accel_y_mps2"): 0.1,
}
"""Channels that one display, one habit or one chip gives in the same wrong unit, and
how much more usual that is than the first of them alone."""

LARGE = dict.fromkeys(
    ("battery_voltage_v", "battery_current_a", "motor_current_a"), 1500.0
)
"""What a channel must reach before thousandths of its unit are believed. [V], [A]"""


QUICKEST = 5e-4
"""Least time between a car's rows that is believed of a clock in another unit. [s]"""


def mistakes(columns: Columns, vehicle: Vehicle | None) -> list[Mistake]:
    """Return what the channels of this log may be wrong by."""
    out = []
    by_poles = follows_erpm("speed_mps", columns)
    if by_poles:
        out += _counted(vehicle.motor.poles if vehicle else None)
    for name, units in UNITS.items():
        if name not in columns or (name == "speed_mps" and by_poles):
            continue
        small = size_of(columns[name]) < LARGE.get(name, 0.0)
        row = float(np.median(np.diff(columns[name]))) if name == "time_s" else np.inf
        for rank, (factor, words) in enumerate(units):
            if (small and factor > 1) or row / factor < QUICKEST:
                continue
            out.append(Mistake(name, "unit", factor, words, 1.0 - 0.2 * rank))
    large = vehicle is None or vehicle.wheelbase > LARGEST_MODEL
    if large and "steer_cmd_rad" in columns:
        out += _at_the_steering_wheel()
    if vehicle is not None and "motor_speed_radps" in columns:
        out += _electrical(vehicle.motor.poles)
    if vehicle is not None and "motor_torque_nm" in columns:
        gear = vehicle.drivetrain.gear_ratio.value
        words = f"N m at the wheels, {gear:.4g} times the motor's by the gear ratio"
        out.append(Mistake("motor_torque_nm", "unit", gear, words, 1.0))
    mean = float(np.nanmean(sampled(columns["speed_mps"]))) if _has(columns) else 1.0
    for rank, name in enumerate(SIGNED):
        if name not in columns or (name == "speed_mps" and mean > 0):
            continue
        words = "the other sign"
        prior = 1.5 if name == "speed_mps" else 0.9 - 0.02 * rank
        out.append(Mistake(name, "sign", -1.0, words, prior))
    both = [m for m in out if m.kind == "unit" and m.channel in SIGNED]
    for m in both:
        if m.channel != "speed_mps" or mean < 0:
            words = f"{m.words} and the other sign"
            out.append(Mistake(m.channel, "unit", -m.factor, words, 0.3))
    return out + _together(out)


def _together(known: Sequence[Mistake]) -> list[Mistake]:
    """Return the units that several channels are in at once."""
    out = []
    for group, prior in TOGETHER.items():
        there = [c for c in group if any(m.channel == c for m in known)]
        for n in range(2, len(there) + 1):
            for first, *rest in combinations(there, n):
                units = set(dict(UNITS[first])).intersection(
                    *(dict(UNITS[channel]) for channel in rest)
                )
                out += [
                    m._replace(prior=m.prior + prior, also=tuple(rest))
                    for m in known
                    if m.channel == first and m.kind == "unit" and m.factor in units
                ]
    return out


def words_of(channel: str, factor: float) -> str:
    """Return what people call a unit of a channel."""
    return dict(UNITS[channel])[factor]


def _at_the_steering_wheel() -> list[Mistake]:
    """Return a steering that is told as it is in the driver's hands."""
    units = ((STEERING_RATIO, "radians"), (STEERING_RATIO * DEG, "degrees"))
    return [
        Mistake(
            "steer_cmd_rad",
            "unit",
            factor,
            f"{unit} of the steering wheel, {STEERING_RATIO:g} to one of the road "
            "wheels or so",
            0.5,
        )
        for factor, unit in units
    ]


def _electrical(poles: int | None) -> list[Mistake]:
    """Return a motor speed in electrical turns: of the poles, or of a likely number."""
    name = "motor_speed_radps"
    if poles is None:
        pairs: tuple[int, ...] = tuple(range(2, 11))
        words = "ERPM, if the motor has {} poles"
    else:
        pairs, words = (poles // 2,), "ERPM (electrical rpm; {} poles)"
    out = [
        Mistake(name, "unit", RPM * p, words.format(2 * p), 1.0 if poles else 0.7)
        for p in pairs
    ]
    if poles is not None and poles > 2:
        out.append(Mistake(name, "unit", poles / 2, "electrical rad/s", 0.8))
    return out


def _counted(poles: int | None) -> list[Mistake]:
    """Return what a speed from ERPM is wrong by where poles are taken for pairs."""
    told = {2.0: "twice", 0.5: "half"}
    pairs = (poles or 2) // 2
    factors = {2.0: 1.0, 0.5: 0.9} | ({1 / pairs: 0.8} if pairs > 2 else {})
    return [
        Mistake(
            "speed_mps",
            "poles",
            factor,
            f"{told.get(factor, f'1/{pairs} of')} what it should be: poles taken for "
            "pole pairs, or for none, in motor_speed_erpm or in the file's motor.poles",
            prior,
        )
        for factor, prior in factors.items()
    ]


def follows_erpm(name: str, columns: Columns) -> bool:
    """Tell whether a channel is the log's ERPM times a constant."""
    if name not in columns or "motor_speed_erpm" not in columns:
        return False
    x, erpm = (sampled(columns[c]) for c in (name, "motor_speed_erpm"))
    known = np.isfinite(x) & np.isfinite(erpm)
    x, erpm = x[known], erpm[known]
    times = float(x @ erpm) / (float(erpm @ erpm) or 1.0)
    return bool(len(x)) and bool(np.allclose(x, times * erpm, rtol=1e-6, atol=0.0))


def size_of(values: Array) -> float:
    """Return the largest size of a channel, but for some rows in a thousand."""
    some = np.abs(sampled(values))
    some = some[np.isfinite(some)]
    return float(np.quantile(some, 0.999)) if len(some) else 0.0


def _has(columns: Columns) -> bool:
    return "speed_mps" in columns and bool(np.isfinite(columns["speed_mps"]).any())
