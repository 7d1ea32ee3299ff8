"""The factor between a channel and what others say it should be, over short means."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from rcc_sim.analyse.logcheck.finding import Array, Columns

MOST = 20_000
"""Means that a relation is judged by."""

WINDOW = 0.4
"""Length of a mean, where the rows are denser. [s]"""


class Relation(NamedTuple):
    """A channel against what others say it should be.

    ``low`` and ``high`` bound the factor: noise on one side or the other draws a slope
    towards zero, so the truth lies between the slope and the inverse of the inverse
    slope. A relation that tells a sign alone has ``loose`` infinite; one ``by_vehicle``
    rests on the figures of a vehicle's file.
    """

    what: str
    powers: Mapping[str, int]  # channel -> power that its own mistake enters with
    low: float
    high: float
    correlation: float
    loose: float  # factor either way that is no mistake
    by_vehicle: bool = False

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

    row: float  # between the log's rows [s]
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
        mean = mean_of_known(some.reshape(blocks, width))
        rate = np.gradient(mean, clock) if blocks > 2 else np.zeros(blocks)
        mean[broken] = np.nan
        rate[broken] = np.nan
        out[name], rates[name] = mean, rate
    return Means(row, usual, out, rates)


def mean_of_known(rows: Array) -> Array:
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
    *("battery_power_w", "aux_power_w", "x_m", "y_m", "distance_m", "on_stand"),
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
    by_vehicle: bool = False,
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
    return Relation(what, powers, xy / xx, yy / xy, correlation, loose, by_vehicle)
