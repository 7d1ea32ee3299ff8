"""Clocks of channels against each other, by cross-correlation."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from rcc_sim.analyse.logcheck.finding import Array, Columns, Finding

MOST = 40_000
"""Rows that are looked at: the liveliest stretch of a longer log."""

FARTHEST = 10.0
"""Longest offset that is looked for. [s]"""

LEAST = 0.03
"""Offset that is worth a word. [s]"""

SLIP = 0.8
"""Offset of the lateral acceleration that sideslip cannot explain. [s]"""

GRAVE = 0.35
"""Offset beyond what sensors and their filters take. [s]"""


def offsets(time: Array, columns: Columns) -> list[Finding]:
    """Return the channels whose clock is not that of the speed (or the yaw rate)."""
    if "speed_mps" not in columns or len(time) < 100:
        return []
    step = float(np.median(np.diff(time)))
    part = _liveliest(columns["speed_mps"])
    clock = np.arange(time[part][0], time[part][-1], step)[:MOST]
    if len(clock) < 100:
        return []
    c = {
        name: _even(clock, time[part], values[part], turns=name == "yaw_rad")
        for name, values in columns.items()
        if name in SEEN and np.isfinite(values[part]).mean() > 0.8
    }
    if "speed_mps" not in c:
        return []
    found = []
    for name, (late, early, words) in _pairs(c, step).items():
        lag = _lag(late, early, step)
        least = max(2.5 * step, SLIP if name == "accel_y_mps2" else LEAST)
        if lag is not None and abs(lag[0]) >= least:
            found.append(_offset(name, words, lag[0], lag[1]))
    return _one_clock(found, c, step)


def _offset(name: str, other: str, seconds: float, correlation: float) -> Finding:
    grave = abs(seconds) > GRAVE
    mend = "its clock is another one: mend it with convert"
    mend = mend if grave else "sensor_delay stands for it in diagnose"
    return Finding(
        "clock_offset",
        name,
        f"comes {abs(seconds):.3g} s {'after' if seconds > 0 else 'before'} {other}",
        sure=round(min(0.95, correlation), 2),
        action=f"not shifted; {mend}",
        severity="warning" if grave else "info",
    )


def _one_clock(found: list[Finding], c: Columns, step: float) -> list[Finding]:
    """Put the blame for a lateral acceleration out of step where it belongs.

    It is compared with the yaw rate: where that is out of step with the heading, or
    with the steering by as much the other way, the yaw rate's clock is the odd one.
    """
    lateral = next((f for f in found if f.channel == "accel_y_mps2"), None)
    if lateral is None:
        return found
    rest = [f for f in found if f is not lateral]
    if any(f.channel == "yaw_rate_radps" for f in rest):
        return rest
    if "steer_cmd_rad" in c:
        steered = c["speed_mps"] * c["steer_cmd_rad"]
        behind = _lag(c["yaw_rate_radps"], steered, step)
        after = _lag(c["accel_y_mps2"], steered, step)
        if behind is not None and (after is None or abs(behind[0]) > abs(after[0])):
            what = f"comes {abs(behind[0]):.3g} s "
            what += "after" if behind[0] > 0 else "before"
            changed = replace(
                lateral,
                channel="yaw_rate_radps",
                what=f"{what} speed times steering, which accel_y_mps2 keeps up with",
            )
            return [*rest, changed]
    return found


SEEN = (
    *("steer_cmd_rad", "speed_mps", "yaw_rate_radps", "accel_x_mps2", "accel_y_mps2"),
    *("motor_speed_radps", "x_m", "y_m", "yaw_rad"),
)


def _pairs(c: Columns, step: float) -> dict[str, tuple[Array, Array, str]]:
    v = c["speed_mps"]
    out: dict[str, tuple[Array, Array, str]] = {}
    if "accel_x_mps2" in c:
        out["accel_x_mps2"] = (c["accel_x_mps2"], _slope(v, step), "the speed's change")
    if "accel_y_mps2" in c and "yaw_rate_radps" in c:
        turn = v * c["yaw_rate_radps"]
        out["accel_y_mps2"] = (c["accel_y_mps2"], turn, "speed times yaw rate")
    if "motor_speed_radps" in c:
        spins = _slope(c["motor_speed_radps"], step)
        out["motor_speed_radps"] = (spins, _slope(v, step), "the speed")
    if "yaw_rad" in c and "yaw_rate_radps" in c:
        turn = _slope(c["yaw_rad"], step)
        out["yaw_rate_radps"] = (c["yaw_rate_radps"], turn, "the heading's change")
    return out


def _liveliest(speed: Array) -> slice:
    n = len(speed)
    if n <= MOST:
        return slice(0, n)
    pieces = np.nan_to_num(speed[: n // MOST * MOST]).reshape(-1, MOST)
    k = int(np.argmax(pieces.std(axis=1)))
    return slice(k * MOST, (k + 1) * MOST)


def _even(clock: Array, time: Array, values: Array, *, turns: bool) -> Array:
    there = np.isfinite(values)
    seen = np.unwrap(values[there]) if turns else values[there]
    return np.interp(clock, time[there], seen)


def _slope(values: Array, step: float) -> Array:
    """Return the slope over about 0.1 s, so that noise does not drown it."""
    k = max(1, round(0.05 / step))
    out = np.zeros_like(values)
    out[k:-k] = (values[2 * k :] - values[: -2 * k]) / (2 * k * step)
    return out


def _lag(late: Array, early: Array, step: float) -> tuple[float, float] | None:
    """Return by how much one signal comes after another, and their correlation.

    None where they are not alike, or alike without any shift.
    """
    n = len(late)
    reach = min(int(FARTHEST / step), n // 4)
    size = 1 << int(np.ceil(np.log2(n + reach + 1)))
    a, b = late - late.mean(), early - early.mean()
    scale = float(np.sqrt((a @ a) * (b @ b)))
    if scale <= 0:
        return None
    product = np.fft.rfft(a, size) * np.conj(np.fft.rfft(b, size))
    whole = np.fft.irfft(product, size)
    corr = np.concatenate([whole[-reach:], whole[: reach + 1]]) / scale
    size_of = np.abs(corr)
    k = int(np.argmax(size_of))
    peak, now = float(size_of[k]), float(size_of[reach])
    shift = k - reach
    if corr[k] < 0.6 or abs(shift) == reach or peak - now < 0.1 * (1 - peak) + 0.002:
        return None
    return shift * step, peak
