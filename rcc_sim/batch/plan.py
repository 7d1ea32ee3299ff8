"""What a sweep is to run: a grid, draws at each of its points, a number a run."""

from __future__ import annotations

import difflib
import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from decimal import Decimal, InvalidOperation
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from rcc_sim.batch.pack import CYCLE_KEYS, LANE_KEYS
from rcc_sim.errors import InputError

Array = NDArray[np.float64]

MOST_RUNS = 100_000_000
"""Most runs of a sweep; at 2 000 a second these are 14 hours of a core."""

MOST_VALUES = 1_000_000
"""Most values of one axis."""

NONE = "none"
"""How a user writes that there are no lane changes: a distance without end."""

SYNTAX = "write KEY=lo:hi:step, or KEY=a,b,c; body.mass_kg=3:5:0.1"


@dataclass(frozen=True)
class Axis:
    """A key, and the values that it takes."""

    key: str
    values: tuple[float, ...]

    @property
    def words(self) -> str:
        """Key, how many values, from where to where."""
        ends = f"{self.values[0]:g} to {self.values[-1]:g}"
        return f"{self.key} ({len(self.values)} from {ends})"


@dataclass(frozen=True, eq=False)
class Plan:
    """Every combination of the axes' values, each with every draw.

    Parameters
    ----------
    axes : tuple of Axis
        The grid; the last one turns fastest.
    drawn : tuple of str
        Keys of the draws.
    draws : ndarray, shape (n, d)
        A row a draw; one row of no columns where nothing is drawn.
    """

    axes: tuple[Axis, ...]
    drawn: tuple[str, ...] = ()
    draws: Array = field(default_factory=lambda: np.zeros((1, 0)))

    @property
    def keys(self) -> tuple[str, ...]:
        """Column -> key."""
        return (*(axis.key for axis in self.axes), *self.drawn)

    @property
    def shape(self) -> tuple[int, ...]:
        """Values of each axis."""
        return tuple(len(axis.values) for axis in self.axes)

    @cached_property
    def size(self) -> int:
        """Number of runs."""
        return math.prod(self.shape) * len(self.draws)

    def values(self, start: int, stop: int) -> Array:
        """Return the values of the runs from start to before stop, shape (n, k)."""
        run = np.arange(start, stop)
        point, draw = np.divmod(run, len(self.draws))
        out = np.empty((len(run), len(self.keys)))
        if self.axes:
            places = np.unravel_index(point, self.shape)
            for i, (axis, place) in enumerate(zip(self.axes, places, strict=True)):
                out[:, i] = np.asarray(axis.values)[place]
        out[:, len(self.axes) :] = self.draws[draw]
        return out

    @property
    def low(self) -> Array:
        """Least value of each key."""
        grid = [min(axis.values) for axis in self.axes]
        return np.array([*grid, *self.draws.min(axis=0)])

    @property
    def high(self) -> Array:
        """Greatest value of each key."""
        grid = [max(axis.values) for axis in self.axes]
        return np.array([*grid, *self.draws.max(axis=0)])


def make_plan(
    settings: Sequence[str], drawn: tuple[str, ...] = (), draws: Array | None = None
) -> Plan:
    """Return the plan of some ``KEY=values`` and of draws at each of their points.

    Raises
    ------
    InputError
        If an axis is empty or stated twice, or there are more runs than can be.
    """
    axes = tuple(parse_axis(text) for text in settings)
    keys = [*(axis.key for axis in axes), *drawn]
    for key in keys:
        if keys.count(key) > 1:
            raise InputError(f"{key}: is set twice", "each key has one --set or draw")
        _check_key(key)
    table = np.zeros((1, 0)) if draws is None else np.ascontiguousarray(draws)
    size = math.prod(len(axis.values) for axis in axes) * len(table)
    if size > MOST_RUNS:
        raise _too_many(size)
    return Plan(axes, drawn, table)


class NoNumbers(InputError):
    """The right side of a ``KEY=values`` holds a word."""


def parse_axis(text: str) -> Axis:
    """Return the axis that ``KEY=lo:hi:step`` or ``KEY=a,b,c`` states.

    Raises
    ------
    InputError
        If it states none, or one without a value.
    """
    key, equals, right = text.partition("=")
    key = key.strip()
    if not equals or not key or not right.strip():
        raise InputError(f"--set {text}: should be KEY=values", SYNTAX)
    values: list[float] = []
    for part in right.split(","):
        values += _range(text, part) if ":" in part else [_value(text, key, part)]
        if len(values) > MOST_VALUES:
            raise _too_many(len(values), key)
    if len(set(values)) < len(values):
        raise InputError(f"--set {text}: takes a value twice")
    return Axis(key, tuple(values))


def is_axis(text: str) -> bool:
    """Tell whether the right side of a ``KEY=values`` is numbers at all."""
    try:
        parse_axis(text)
    except NoNumbers:
        return False
    except InputError:
        return True
    return True


def _range(text: str, part: str) -> list[float]:
    try:
        low, high, step = (Decimal(word.strip()) for word in part.split(":"))
        finite = all(x.is_finite() for x in (low, high, step))
    except (InvalidOperation, ValueError):
        finite = False
    if not finite:
        raise InputError(f"--set {text}: should be lo:hi:step: {part}", SYNTAX)
    if step == 0 or (high - low) / step < 0:
        raise InputError(
            f"--set {text}: an empty grid: no value from {low} to {high} in steps of "
            f"{step}",
            SYNTAX,
        )
    count = int((high - low) // step) + 1
    if count > MOST_VALUES:
        raise _too_many(count, text.partition("=")[0])
    return [float(low + k * step) for k in range(count)]


def _value(text: str, key: str, part: str) -> float:
    if key == "lanes.every" and part.strip() in (NONE, "inf"):
        return math.inf
    try:
        value = float(part)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise NoNumbers(f"--set {text}: should be numbers: {part.strip()!r}", SYNTAX)
    return value


def _check_key(key: str) -> None:
    """Raise for a cycle's or a manoeuvre's key that does not exist."""
    table = key.partition(".")[0]
    known = {"cycle": CYCLE_KEYS, "lanes": LANE_KEYS}.get(table)
    if table == "sensors":
        raise InputError(f"{key}: a sensor touches the log alone, not what a run costs")
    if known is not None and key not in known:
        close = difflib.get_close_matches(key, known, n=1)
        hint = f"did you mean `{close[0]}`?" if close else f"there are {known}"
        raise InputError(f"{key}: no such key", hint)


def _too_many(count: int, key: str = "") -> InputError:
    where = f"{key}: " if key else ""
    much, what = (MOST_VALUES, "values") if key else (MOST_RUNS, "runs")
    return InputError(
        f"{where}{count:,} {what}: should be at most {much:,}",
        "take wider steps, or draw (--draw N) in place of a grid",
    )
