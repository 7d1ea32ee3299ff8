"""What the sensors read while the car stands, and commands that come late."""

from __future__ import annotations

import numpy as np

from rcc_sim.analyse.logcheck.finding import (
    COMMANDS,
    Array,
    Columns,
    Finding,
    Mask,
    at,
    runs,
    sampled,
    spread,
    when,
)
from rcc_sim.analyse.logcheck.glitches import median_of_five
from rcc_sim.channel import is_nil, is_rough, sensor_noise
from rcc_sim.units import G

FLOORS = {
    "yaw_rate_radps": 0.002,
    "accel_x_mps2": 0.02,
    "accel_y_mps2": 0.02,
    "motor_current_a": 0.1,
}
"""Bias below which nobody cares. [the channel's unit]"""

STILL, CRAWLS = 0.005, 0.003
"""Speed below which a car stands: share of the drive's largest, and at least. [m/s]"""

REST = 0.4
"""Standstill that is cut off at either end, while the car still settles. [s]"""

STANDS_FOR = {
    "yaw_rate_radps": "yaw_rate_bias",
    "accel_x_mps2": "accelerometer_bias",
    "accel_y_mps2": "accelerometer_bias",
}


def standing(time: Array, columns: Columns) -> Mask:
    """Return the rows at which the car surely stands: still, and told to be."""
    speed = columns.get("speed_mps")
    if speed is None:
        return np.zeros(len(time), dtype=bool)
    top = float(np.nanmax(np.abs(sampled(speed)), initial=0.0))
    still = np.abs(speed) <= max(STILL * top, CRAWLS)
    if is_rough(speed):
        still |= is_nil(time, speed, sensor_noise(speed))
    for name in ("speed_ref_mps", "throttle"):
        if name in columns:
            still &= columns[name] == 0
    sure = np.zeros(len(time), dtype=bool)
    step = float(np.median(np.diff(time)))
    edge = max(2, round(REST / step))
    starts, ends = runs(still)
    long = ends - starts > 2 * edge + 3
    for first, end in zip(starts[long], ends[long], strict=True):
        begin = first if first == 0 else first + edge
        sure[begin : end - edge] = True
    return sure


def biases(time: Array, columns: Columns) -> list[Finding]:
    """Return what the sensors read at rest where zero is right."""
    rest = standing(time, columns)
    count = int(rest.sum())
    if count < 5:
        return []
    found = []
    for name, floor in FLOORS.items():
        if name not in columns:
            continue
        seen = columns[name][rest]
        if name == "accel_x_mps2" and "slope" in columns:
            seen = seen - G * columns["slope"][rest]
        seen = seen[np.isfinite(seen)]
        if len(seen) < 5:
            continue
        bias, sd = float(np.median(seen)), float(np.std(seen))
        doubt = 1.25 * sd / np.sqrt(len(seen))
        if abs(bias) < max(floor, 4 * doubt):
            continue
        effect = STANDS_FOR.get(name)
        slope = " (or the ground slopes)" if name.startswith("accel") else ""
        found.append(
            Finding(
                "bias",
                name,
                f"reads {bias:.3g} ± {doubt:.1g} at rest{slope}",
                when(time, np.flatnonzero(rest)),
                sure=0.9,
                action=f"used as it is; {effect} stands for it in diagnose"
                if effect
                else "used as it is",
            )
        )
    return found


def late_commands(time: Array, columns: Columns) -> list[Finding]:
    """Return the commands that are empty or zero while the car already drives."""
    found = []
    speed = columns.get("speed_mps")
    for name in COMMANDS:
        if name not in columns or speed is None:
            continue
        values = columns[name]
        given = np.flatnonzero(np.isfinite(values) & (values != 0))
        if not len(given) or given[0] < 3:
            continue
        first = int(given[0])
        top = float(np.nanmax(np.abs(sampled(speed)), initial=0.0))
        before = speed[:first]
        drives = np.abs(before) > 0.15 * top
        drives &= _acts(name, columns, first)
        lasts = float(drives.sum()) * float(np.median(np.diff(time)))
        if lasts < 0.4:
            continue
        found.append(
            Finding(
                "late_command",
                name,
                f"starts at {at(time, time[first])} s; before, the car drives for "
                f"{lasts:.3g} s without it",
                when(time, np.arange(first)),
                sure=0.85,
                action="used as it is: until then nothing is asked of the model; "
                f"`--span {at(time, time[first])}:` leaves that out",
                severity="warning",
                start_s=float(time[0]),
                end_s=float(time[first]),
            )
        )
    return found


def _turns(columns: Columns, first: int) -> Mask:
    """Tell at which of the first rows the car turns as it otherwise does by command.

    By yaw rate and by curvature, each less its median: neither a gyro's bias nor a
    steering offset is a command.
    """
    speed, steer = np.abs(columns["speed_mps"]), columns["steer_cmd_rad"]
    moving = speed > 0.15 * float(np.nanmax(speed))
    moving &= np.isfinite(columns["yaw_rate_radps"])
    before = moving[:first]
    count = int(before.sum())
    if count < 5 or float(np.nanmax(np.abs(steer))) < 0.005:
        return np.zeros(first, dtype=bool)
    yaw = columns["yaw_rate_radps"][moving]
    off = np.ones(count, dtype=bool)
    for motion in (median_of_five(yaw), median_of_five(yaw / speed[moving])):
        usual = np.median(motion[:count])
        off &= np.abs(motion[:count] - usual) > 0.4 * spread(motion)
    turned = np.zeros(first, dtype=bool)
    turned[before] = off
    return _lasting(turned, 5)


def _lasting(mask: Mask, rows: int) -> Mask:
    """Return a mask without its stretches shorter than so many rows."""
    starts, ends = runs(mask)
    out = mask.copy()
    for first, end in zip(starts, ends, strict=True):
        if end - first < rows:
            out[first:end] = False
    return out


def _acts(name: str, columns: Columns, first: int) -> Mask:
    """Tell at which of the first rows the car does what only a command explains."""
    if name == "steer_cmd_rad":
        if "yaw_rate_radps" not in columns:
            return np.zeros(first, dtype=bool)
        return _turns(columns, first)
    speed = columns["speed_mps"]
    back = max(3, min(first // 4, 50))
    rise = np.full(first, False)
    if first > 2 * back:
        rise[back:] = speed[back:first] >= speed[: first - back]
    return rise
