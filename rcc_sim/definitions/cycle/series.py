"""A drive cycle: speed over time, cut, repeated and joined."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rcc_sim.errors import InputError

SEAM_TOLERANCE = 2e-5
"""Speeds that differ by no more than two files' rounding are one speed. [m/s]"""

MAX_ROWS = 20_000_000
"""Most rows that a cycle may be repeated or joined to: 320 MB. [1]"""


@dataclass(frozen=True, eq=False)
class Cycle:
    """Speed of a vehicle over time; straight lines between its rows.

    Attributes
    ----------
    name : str
        What it is called, or the words that made it: ``udds[20:125]``.
    time_s : ndarray, shape (n,)
        Strictly increasing; starts anywhere, steps as it likes. Read-only. [s]
    speed_mps : ndarray, shape (n,)
        Never negative. Read-only. [m/s]
    source : str
        Where the figures come from.
    others : tuple of str
        Columns beside them in the file as it was read, which are no part of it.

    Raises
    ------
    InputError
        If there are fewer than two rows, or a row breaks one of these rules.
    """

    name: str
    time_s: NDArray[np.float64]
    speed_mps: NDArray[np.float64]
    source: str = ""
    others: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        time = _column(self.name, self.time_s)
        speed = _column(self.name, self.speed_mps)
        if time.shape != speed.shape:
            sizes = f"{time.size} and {speed.size}"
            raise InputError(
                f"{self.name}: should have as many speeds as times: {sizes}"
            )
        if time.size < 2:
            raise InputError(f"{self.name}: should have at least 2 rows: {time.size}")
        fault = first_fault(time, speed)
        if fault:
            raise InputError(
                f"{self.name}: row {fault.row + 1}: {fault.message}", fault.hint
            )
        object.__setattr__(self, "time_s", time)
        object.__setattr__(self, "speed_mps", speed)

    @property
    def duration(self) -> float:
        """From the first row to the last. [s]"""
        return float(self.time_s[-1] - self.time_s[0])

    @property
    def distance(self) -> float:
        """Integral of the speed, by trapezoids. [m]"""
        return float(np.trapezoid(self.speed_mps, self.time_s))

    @property
    def max_speed(self) -> float:
        """Greatest speed. [m/s]"""
        return float(self.speed_mps.max())

    @property
    def max_acceleration(self) -> float:
        """Greatest gain of speed over one step; 0 if it never gains any. [m/s²]"""
        return float(max(self._slopes().max(), 0.0))

    @property
    def max_deceleration(self) -> float:
        """Greatest loss of speed over one step, positive; 0 if none. [m/s²]"""
        return float(max(-self._slopes().min(), 0.0))

    def slice(self, start: float | None = None, stop: float | None = None) -> Cycle:
        """Part of the cycle, its ends interpolated, its time counted from 0.

        Parameters
        ----------
        start, stop : float, optional
            Seconds after the cycle's first row, whatever its clock says there; its
            beginning and its end unless given. [s]

        Returns
        -------
        part : Cycle

        Raises
        ------
        InputError
            Unless 0 <= start < stop <= duration.
        """
        first = 0.0 if start is None else float(start)
        last = self.duration if stop is None else float(stop)
        words = ("" if end is None else f"{end:g}" for end in (start, stop))
        name = f"{self.name}[{':'.join(words)}]"
        if not 0 <= first < last <= self.duration:
            raise InputError(
                f"{name}: should lie inside the cycle, its start before its end",
                f"`{self.name}` lasts {self.duration:g} s, counted from its first row",
            )
        elapsed = self.time_s - self.time_s[0]
        inside = (elapsed > first) & (elapsed < last)
        time = np.concatenate(([first], elapsed[inside], [last]))
        speed = np.interp(time, elapsed, self.speed_mps)
        return Cycle(name, time - first, speed, self.source, self.others)

    def repeat(self, n: int) -> Cycle:
        """The cycle `n` times over, joined as by `join`.

        Raises
        ------
        InputError
            If `n` is below 1, the seam is a jump, or the result is beyond reason.
        """
        if n < 1:
            raise InputError(f"{self.name}: should be repeated at least once: {n}")
        _refuse_length(f"{self.name}*{n}", n * self.time_s.size)
        return replace(join(*[self] * n), name=f"{self.name}*{n}")

    def _slopes(self) -> NDArray[np.float64]:
        """Acceleration over each step, shape (n - 1,). [m/s²]"""
        return np.diff(self.speed_mps) / np.diff(self.time_s)


def join(*cycles: Cycle) -> Cycle:
    """One cycle after the other: each starts where the one before it ended.

    Where the speeds on both sides of a seam are the same, to within the rounding of
    the files, the two rows become one. A difference that the cycles themselves could
    cover in one time step is driven in one: the next cycle then starts one step later,
    the step being the last of the cycle before. A greater one is refused.

    Parameters
    ----------
    *cycles : Cycle
        At least one.

    Returns
    -------
    joined : Cycle
        Its time starts at the first cycle's start.

    Raises
    ------
    InputError
        If the speed jumps at a seam by more than the greatest acceleration (or
        deceleration, where it falls) of the two cycles makes in one time step.
    """
    if not cycles:
        raise InputError("should be given at least one cycle to join")
    name = "+".join(cycle.name for cycle in cycles)
    _refuse_length(name, sum(cycle.time_s.size for cycle in cycles))
    times, speeds = [cycles[0].time_s], [cycles[0].speed_mps]
    end = float(cycles[0].time_s[-1])
    for before, after in pairwise(cycles):
        step = _seam(before, after)
        begin = 1 if step == 0 else 0
        times.append(end + step + (after.time_s - after.time_s[0])[begin:])
        speeds.append(after.speed_mps[begin:])
        end = float(times[-1][-1])
    sources = dict.fromkeys(cycle.source for cycle in cycles if cycle.source)
    return Cycle(
        name, np.concatenate(times), np.concatenate(speeds), "; ".join(sources)
    )


class Fault(NamedTuple):
    """A row (from 0) that breaks a rule of `Cycle`, which one, and how to mend it."""

    row: int
    message: str
    hint: str = ""


def first_fault(time: NDArray[np.float64], speed: NDArray[np.float64]) -> Fault | None:
    """The first row that breaks a rule; None if all are sound."""
    back = np.concatenate(([False], ~(np.diff(time) > 0)))
    bad = ~np.isfinite(time) | ~np.isfinite(speed) | (speed < 0) | back
    if not bad.any():
        return None
    row = int(bad.argmax())
    t, v = time[row], speed[row]
    if not np.isfinite(t):
        return Fault(row, f"time_s should be finite: {t:g}")
    if not np.isfinite(v):
        hint = "leave the row out, or put in what was driven"
        return Fault(row, f"speed should be finite: {v:g}", hint)
    if v < 0:
        hint = "a cycle does not go backwards; cut the log where it does"
        return Fault(row, f"speed should be at least 0: {v:g}", hint)
    rule = f"time_s should be greater than the row before's {time[row - 1]:.10g}"
    return Fault(row, f"{rule}: {t:.10g}", "sort by time; keep one row of each time")


def _column(name: str, values: ArrayLike) -> NDArray[np.float64]:
    """A read-only copy as floats, shape (n,)."""
    try:
        column = np.array(values, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise InputError(f"{name}: should hold numbers: {error}") from error
    if column.ndim != 1:
        raise InputError(f"{name}: should be one column: {column.ndim} dimensions")
    column.flags.writeable = False
    return column


def _seam(before: Cycle, after: Cycle) -> float:
    """Time from the end of one cycle to the start of the next. [s]"""
    jump = float(after.speed_mps[0] - before.speed_mps[-1])
    if abs(jump) <= SEAM_TOLERANCE:
        return 0.0
    step = float(before.time_s[-1] - before.time_s[-2])
    if jump > 0:
        limit = max(before.max_acceleration, after.max_acceleration)
    else:
        limit = max(before.max_deceleration, after.max_deceleration)
    if abs(jump) > limit * step:
        raise InputError(
            f"{before.name}+{after.name}: the speed should not jump at the seam: "
            f"{before.speed_mps[-1]:g} to {after.speed_mps[0]:g} m/s",
            "cut both where they stand still or go equally fast",
        )
    return step


def _refuse_length(name: str, rows: int) -> None:
    if rows > MAX_ROWS:
        raise InputError(f"{name}: should have at most {MAX_ROWS:,} rows: {rows:,}")
