"""What physics asks of two channels at once: the factor between them is one.

Each relation compares a channel with what other channels say it should be, over short
means, and gives the factor between the two. A wrong unit or sign shows as the same
factor in every relation that the channel takes part in (`units.py` puts the blame).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import NamedTuple

import numpy as np

from rcc_sim.analyse.logcheck.finding import Array, Columns
from rcc_sim.definitions.vehicle import Vehicle
from rcc_sim.units import G

MOST = 20_000
"""Means that a relation is judged by."""

WINDOW = 0.4
"""Length of a mean, where the rows are denser. [s]"""


WHEELBASE = 1.3
"""Between a scaled car's and a van's: within 20 times of either, understeer too. [m]"""


WORK = 3.0
"""Factor either way by which a battery's power may differ from what moves the mass:
losses, friction brakes, hills and a load that the file does not know. Speeds in mph
make it five times too little, in km/h thirteen times."""


STILL = 0.01
"""Share of the largest speed below which a car stands."""

AUXILIARY, FEW = 30.0, 2e-3
"""Times more than what a log calls its auxiliaries that a standing car may draw without
doubt; and share of what it draws, above which they may be a fan alone that is logged:
a factor of a thousand is less than that."""


class Relation(NamedTuple):
    """A channel against what others say it should be.

    ``low`` and ``high`` bound the factor: noise on one side or the other draws a slope
    towards zero, so the truth lies between the slope and the inverse of the inverse
    slope. A relation that tells a sign alone has ``loose`` infinite.
    """

    what: str
    powers: Mapping[str, int]  # channel -> power that its own mistake enters with
    low: float
    high: float
    correlation: float
    loose: float  # factor either way that is no mistake

    @property
    def middle(self) -> float:
        """Factor in between."""
        return float(np.sign(self.low) * np.sqrt(abs(self.low * self.high)))

    def allows(self, factor: float) -> bool:
        """Tell whether a factor explains what was found."""
        if np.sign(factor) != np.sign(self.low):
            return False
        if np.isinf(self.loose):
            return True
        ratio = abs(factor)
        return abs(self.low) / self.loose <= ratio <= abs(self.high) * self.loose


class Means(NamedTuple):
    """Channels as means over short windows, and their rates of change."""

    step: float  # between means [s]
    columns: dict[str, Array]
    rates: dict[str, Array]  # change per second


def means(time: Array, columns: Columns) -> Means:
    """Return window means of the channels on even steps, and their central slopes."""
    row = float(np.median(np.diff(time)))
    n = len(time)
    width = max(1, round(WINDOW / row))
    blocks = n // width
    skip = max(1, blocks // MOST)
    if skip > 1:  # whole stretches of neighbouring means, spread over the log
        each = MOST // 20 * width
        starts = np.linspace(0, n - each, 20).astype(int)
        pick = np.concatenate([np.arange(s, s + each) for s in starts])
        blocks = len(pick) // width
    else:
        pick = np.arange(blocks * width)
    clock = time[pick].reshape(blocks, width).mean(axis=1)
    steps = np.gradient(clock) if blocks > 1 else np.ones(blocks)
    usual = float(np.median(steps)) if blocks else 1.0
    broken = (steps > 1.5 * usual) | (steps <= 0)
    out, rates = {}, {}
    for name, values in columns.items():
        if not name.endswith(FOLLOWED):
            continue
        some = values[pick]
        if name == "yaw_rad":
            some = np.unwrap(some) if np.isfinite(some).all() else some
        mean = _mean(some.reshape(blocks, width))
        rate = np.gradient(mean, clock) if blocks > 2 else np.zeros(blocks)
        mean[broken] = np.nan
        rate[broken] = np.nan
        out[name], rates[name] = mean, rate
    return Means(usual, out, rates)


def _mean(rows: Array) -> Array:
    """Return the mean of each row's values, as far as there are any."""
    there = np.isfinite(rows)
    if there.all():
        return np.asarray(rows.mean(axis=1))
    count = there.sum(axis=1)
    total = np.where(there, rows, 0.0).sum(axis=1)
    return np.where(count > 0, total / np.maximum(count, 1), np.nan)


FOLLOWED = (
    *("speed_mps", "speed_ref_mps", "steer_cmd_rad", "yaw_rate_radps", "yaw_rad"),
    *("accel_x_mps2", "accel_y_mps2", "motor_speed_radps", "motor_current_a"),
    *("motor_torque_nm", "battery_current_a", "battery_voltage_v", "slope"),
    *("battery_power_w", "aux_power_w", "x_m", "y_m", "distance_m"),
)


def slope(
    what: str,
    powers: dict[str, int],
    measured: Array,
    expected: Array,
    *,
    loose: float,
    least: float,
    through_zero: bool = False,
) -> Relation | None:
    """Return the factor of one channel on what it should be; None if it cannot tell.

    ``least`` is the correlation that is asked for.
    """
    both = np.isfinite(measured) & np.isfinite(expected)
    if both.sum() < 20:
        return None
    y, x = measured[both], expected[both]
    cap_x, cap_y = (np.quantile(np.abs(v), 0.999) for v in (x, y))
    fine = (np.abs(x) <= cap_x) & (np.abs(y) <= cap_y)
    y, x = y[fine], x[fine]
    if len(y) < 20:
        return None
    if not through_zero:
        y, x = y - y.mean(), x - x.mean()
    xx, yy, xy = float(x @ x), float(y @ y), float(x @ y)
    if xx <= 0 or yy <= 0 or xy == 0:
        return None
    correlation = xy / np.sqrt(xx * yy)
    if abs(correlation) < least:
        return None
    return Relation(what, powers, xy / xx, yy / xy, correlation, loose)


def relations(m: Means, vehicle: Vehicle | None) -> list[Relation]:
    """Return every relation that the channels (and the vehicle) allow."""
    found: list[Relation | None] = []
    for build in (_motion, _turning, _pose, _drive, _power, _resting):
        found += build(m, vehicle)
    return [relation for relation in found if relation is not None]


Build = Callable[[Means, Vehicle | None], list[Relation | None]]


def _motion(m: Means, vehicle: Vehicle | None) -> list[Relation | None]:
    c, d = m.columns, m.rates
    out: list[Relation | None] = []
    if "speed_mps" not in c:
        return out
    if "accel_x_mps2" in c:
        a = c["accel_x_mps2"]
        swing = float(np.nanmax(np.abs(a), initial=0.0))
        hill = G * c["slope"] if "slope" in c and swing > 1.0 else 0.0  # not in g
        out.append(
            slope(
                "acceleration against the change of speed",
                {"accel_x_mps2": 1, "speed_mps": -1, "time_s": 1},
                a - hill,
                d["speed_mps"],
                loose=1.6,
                least=0.75,
            )
        )
    return out + _follows(c, d)


def _follows(c: Columns, d: Columns) -> list[Relation | None]:
    out: list[Relation | None] = []
    v = c["speed_mps"]
    if "speed_ref_mps" in c:
        out.append(
            slope(
                "speed against its reference",
                {"speed_mps": 1, "speed_ref_mps": -1},
                v,
                c["speed_ref_mps"],
                loose=1.7,
                least=0.9,
                through_zero=True,
            )
        )
    if "distance_m" in c:
        out.append(
            slope(
                "change of distance against speed",
                {"distance_m": 1, "speed_mps": -1, "time_s": -1},
                d["distance_m"],
                v,
                loose=1.5,
                least=0.9,
                through_zero=True,
            )
        )
    return out


def _turning(m: Means, vehicle: Vehicle | None) -> list[Relation | None]:
    c, d = m.columns, m.rates
    out: list[Relation | None] = []
    if "yaw_rate_radps" not in c:
        return out
    r = c["yaw_rate_radps"]
    if "speed_mps" in c and "accel_y_mps2" in c:
        out.append(
            slope(
                "lateral acceleration against speed times yaw rate",
                {"accel_y_mps2": 1, "speed_mps": -1, "yaw_rate_radps": -1},
                c["accel_y_mps2"],
                c["speed_mps"] * r,
                loose=1.6,
                least=0.75,
            )
        )
    if "speed_mps" in c and "steer_cmd_rad" in c:
        l = vehicle.wheelbase if vehicle is not None else WHEELBASE
        out.append(
            slope(
                "yaw rate against speed times steering",
                {"yaw_rate_radps": 1, "speed_mps": -1, "steer_cmd_rad": -1},
                r,
                c["speed_mps"] * c["steer_cmd_rad"] / l,
                loose=6.0 if vehicle is not None else 20.0,
                least=0.6,
            )
        )
    if "yaw_rad" in c:
        out.append(
            slope(
                "change of heading against yaw rate",
                {"yaw_rad": 1, "yaw_rate_radps": -1, "time_s": -1},
                d["yaw_rad"],
                r,
                loose=1.6,
                least=0.75,
            )
        )
    return out


def _pose(m: Means, vehicle: Vehicle | None) -> list[Relation | None]:
    c, d = m.columns, m.rates
    if not {"x_m", "y_m", "speed_mps"} <= set(c):
        return []
    pace = np.hypot(d["x_m"], d["y_m"])
    return [
        slope(
            "speed of the pose against speed",
            {"x_m": 1, "speed_mps": -1, "time_s": -1},
            pace,
            np.abs(c["speed_mps"]),
            loose=1.8,
            least=0.8,
            through_zero=True,
        )
    ]


def _drive(m: Means, vehicle: Vehicle | None) -> list[Relation | None]:
    c, d = m.columns, m.rates
    out: list[Relation | None] = []
    if "speed_mps" not in c:
        return out
    if "motor_speed_radps" in c:
        n = 1.0
        if vehicle is not None:
            n = vehicle.drivetrain.gear_ratio.value / vehicle.tyres.radius_m.value
        out.append(
            slope(
                "motor speed against speed",
                {"motor_speed_radps": 1, "speed_mps": -1},
                c["motor_speed_radps"],
                c["speed_mps"] * n,
                loose=1.7 if vehicle is not None else np.inf,
                least=0.9,
                through_zero=True,
            )
        )
    return out + [
        slope(
            f"{name} against the change of speed",
            {name: 1, "speed_mps": -1, "time_s": 1},
            c[name],
            d["speed_mps"],
            loose=np.inf,
            least=0.35,
        )
        for name in ("motor_current_a", "motor_torque_nm")
        if name in c
    ]


def _power(m: Means, vehicle: Vehicle | None) -> list[Relation | None]:
    c, d = m.columns, m.rates
    out: list[Relation | None] = []
    electric = None
    if "battery_voltage_v" in c and "battery_current_a" in c:
        electric = c["battery_voltage_v"] * c["battery_current_a"]
    if electric is not None and "battery_power_w" in c:
        out.append(
            slope(
                "battery power against voltage times current",
                {
                    "battery_power_w": 1,
                    "battery_voltage_v": -1,
                    "battery_current_a": -1,
                },
                c["battery_power_w"],
                electric,
                loose=1.4,
                least=0.9,
            )
        )
    if "speed_mps" not in c:
        return out
    inertial = c["speed_mps"] * d["speed_mps"]
    out += [
        slope(
            f"{name} against speed times its change",
            {name: 1},
            c[name],
            inertial,
            loose=np.inf,
            least=0.35,
        )
        for name in ("battery_current_a", "battery_power_w")
        if name in c
    ]
    return out + _stated(c, inertial, vehicle)


def _watts(c: dict[str, Array]) -> tuple[tuple[str, ...], Array | None]:
    """Return the battery's power, and the columns that it is the product of."""
    if "battery_power_w" in c:
        return ("battery_power_w",), c["battery_power_w"]
    if "battery_voltage_v" in c and "battery_current_a" in c:
        pair = "battery_voltage_v", "battery_current_a"
        return pair, c[pair[0]] * c[pair[1]]
    return (), None


def _stated(
    c: dict[str, Array], inertial: Array, vehicle: Vehicle | None
) -> list[Relation | None]:
    """Return what the vehicle's own figures say of volts, amperes and watts."""
    if vehicle is None:
        return []
    out: list[Relation | None] = []
    battery = vehicle.battery
    stated = battery.open_circuit_voltage_v or battery.nominal_voltage_v
    if stated is not None and "battery_voltage_v" in c:
        volts = c["battery_voltage_v"][np.isfinite(c["battery_voltage_v"])]
        ratio = float(np.median(volts)) / stated.value if len(volts) else 0.0
        if ratio != 0:
            out.append(
                Relation(
                    "battery voltage against the vehicle file's",
                    {"battery_voltage_v": 1},
                    ratio,
                    ratio,
                    1.0,
                    2.5,
                )
            )
    kinetic = vehicle.body.mass_kg.value * inertial
    watts, power = _watts(c)
    if power is not None:
        out.append(
            slope(
                "battery power against mass times speed times its change",
                {**dict.fromkeys(watts, 1), "speed_mps": -2, "time_s": 1},
                power,
                kinetic,
                loose=WORK,
                least=0.5,
            )
        )
    return out


def _resting(m: Means, vehicle: Vehicle | None) -> list[Relation | None]:
    """Return whether a standing car draws far more than what its auxiliaries are."""
    c = m.columns
    watts, power = _watts(c)
    if power is None or not {"speed_mps", "aux_power_w"} <= set(c):
        return []
    speed = np.abs(c["speed_mps"])
    still = speed < STILL * np.nanmax(speed, initial=0.0)
    seen = slope(
        "auxiliary power against the battery's at rest",
        {"aux_power_w": 1, **dict.fromkeys(watts, -1)},
        c["aux_power_w"][still],
        power[still],
        loose=AUXILIARY,
        least=0.5,
        through_zero=True,
    )
    return [seen] if seen is not None and 0 < seen.middle < FEW else []
