"""What a check says about a log, and what the checks share."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from rcc_sim.definitions.sensors import INERTIAL
from rcc_sim.trace import Trace

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
Severity = Literal["info", "warning", "error"]

ORDER: tuple[Severity, ...] = ("error", "warning", "info")

COMMANDS = ("speed_ref_mps", "throttle", "steer_cmd_rad")
"""What was commanded: may hold, step and sit at a limit."""

KINEMATIC = (
    *("speed_mps", "motor_speed_radps", "yaw_rate_radps"),
    *("x_m", "y_m", "yaw_rad", "elevation_m"),
)
"""What mass keeps from jumping."""

ELECTRICAL = (
    *("motor_current_a", "motor_torque_nm", "battery_current_a"),
    *("battery_voltage_v", "battery_power_w", "current_d_a", "current_q_a"),
    *("voltage_d_v", "voltage_q_v"),
)
"""What may jump from row to row."""

MEASURED = (*dict.fromkeys((*KINEMATIC, *INERTIAL, *ELECTRICAL)),)

USED = "used as it is"
DROPPED = "gap and diagnose leave the channel out"
UNUSED = "not used"

TURNS, TWICE = 0.25, 0.02
"""Shares of rows at which noise turns at least, and turns again at once: noise behind a
second-order low-pass at 0.2 of the Nyquist rate turns at 0.27 and again at 0.027.
"""

SAMPLES = 50_000
"""Rows that a look at a channel's nature takes; long logs are seen in parts."""


@dataclass(frozen=True)
class Finding:
    """One thing that a check found.

    Parameters
    ----------
    kind : str
        Slug, such as ``gap``, ``unit``, ``sign``, ``bias``, ``dead``.
    channel : str
        Column it is about.
    what : str
        One plain sentence.
    where : str
        Rows or seconds, for people.
    sure : float
        How sure, 0 to 1.
    action : str
        What rccsim does about it.
    severity : str
        ``info``, ``warning``, or ``error``: the column would be wrong to use.
    start_s, end_s : float or None
        When, where it has a place. [s]
    factor : float or None
        What the column would have to be multiplied by, where that would mend it.
    """

    kind: str
    channel: str
    what: str
    where: str = "whole log"
    sure: float = 1.0
    action: str = USED
    severity: Severity = "info"
    start_s: float | None = None
    end_s: float | None = None
    factor: float | None = None

    @property
    def mend(self) -> str:
        """What would mend it, where the channel cannot be left out."""
        return self.action.removeprefix(f"{DROPPED}; ").removeprefix(f"{UNUSED}; ")


@dataclass(frozen=True)
class Checked:
    """A log after its check.

    Parameters
    ----------
    trace : Trace
        What can be used: time strictly increasing, dead channels out, glitches NaN.
    findings : tuple of Finding
        Worst first.
    rate : float
        Median rows per second. [Hz]
    """

    trace: Trace
    findings: tuple[Finding, ...]
    rate: float

    @property
    def unusable(self) -> tuple[str, ...]:
        """Columns that would be wrong to use as they are."""
        wrong = (f.channel for f in self.findings if f.severity == "error")
        return tuple(dict.fromkeys(wrong))


Columns = Mapping[str, Array]


def by_map(factor: float, of: str = "") -> str:
    """Return how a column map mends a channel: by its sign, by its unit or a factor.

    ``of`` names another channel, by whose factor it is mended.
    """
    draft = "rccsim convert LOG --suggest-map"
    if of:
        entry = f"factor = {factor:.6g}{of}"
        return f"to mend it, give a --map; write {entry} in what {draft} drafts"
    entry = "sign = -1" if factor == -1 else f"its unit (a factor of {factor:.6g})"
    return f"to mend it, give a --map; {draft} --vehicle CAR drafts one with {entry}"


def parts(n: int, size: int = SAMPLES) -> list[slice]:
    """Return stretches of at most ``size`` rows in all, spread over ``n`` rows."""
    if n <= size:
        return [slice(0, n)]
    pieces = 10
    each = size // pieces
    starts = np.linspace(0, n - each, pieces).astype(int)
    return [slice(int(s), int(s) + each) for s in starts]


def sampled(values: Array, size: int = SAMPLES) -> Array:
    """Return stretches of a channel, one after the other, for its statistics."""
    return np.concatenate([values[part] for part in parts(len(values), size)])


def runs(mask: Mask) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Return first and one-past-last row of every stretch where ``mask`` holds."""
    edges = np.flatnonzero(np.diff(np.pad(mask.astype(np.int8), 1)))
    return edges[::2], edges[1::2]


def is_noisy(values: Array) -> bool:
    """Tell whether neighbouring rows scatter, as a sensor's do and a model's do not.

    White noise turns at two rows of three, and at two in succession at five of twelve;
    a smooth signal of a few rows a period turns as often, but never twice in
    succession.
    """
    some = sampled(values, 20_000)
    steps = np.diff(some[np.isfinite(some)])
    steps = steps[steps != 0]
    if len(steps) <= 20:
        return False
    turns = steps[1:] * steps[:-1] < 0
    again = turns[1:] & turns[:-1]
    return bool(np.mean(turns) > TURNS and np.mean(again) > TWICE)


def is_constant(values: Array) -> bool:
    """Tell whether a channel holds one value, or none at all."""
    there = values[np.isfinite(values)] if np.isnan(values[0]) else values
    if not len(there):
        return True
    return bool(np.nanmin(there) == np.nanmax(there))


def spread(values: Array) -> float:
    """Return the range that holds the middle 98 % of a channel."""
    some = sampled(values)
    some = some[np.isfinite(some)]
    if not len(some):
        return 0.0
    low, high = np.quantile(some, [0.01, 0.99])
    return float(high - low)


def counted(n: int, what: str = "row") -> str:
    """Return a number of rows, or of something else, in words."""
    return f"{n} {what}{'' if n == 1 else 's'}"


def when(time: Array, rows: NDArray[np.intp]) -> str:
    """Return when a set of rows is, in words."""
    first, last = time[rows[0]], time[rows[-1]]
    if len(rows) == 1:
        return f"{at(time, first)} s"
    return f"{counted(len(rows))}, {at(time, first)}–{at(time, last)} s"


def at(time: Array, moment: float) -> str:
    """Return a moment in words: of the log's clock, or after its start if that is 1970.

    Seconds since 1970 have too many digits to compare by eye.
    """
    late = float(time[0]) > 1e6
    return f"+{moment - time[0]:.6g}" if late else f"{float(moment):.6g}"
