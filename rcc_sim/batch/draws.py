"""Draws of what is not known: by the sds and ranges of a vehicle's file, or a table."""

from __future__ import annotations

import csv
import math
from collections.abc import Sequence
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from rcc_sim.batch.pack import changed_places
from rcc_sim.definitions.figure import Figure
from rcc_sim.definitions.kernel import kernel_params
from rcc_sim.definitions.vehicle import Vehicle
from rcc_sim.errors import InputError

Array = NDArray[np.float64]
Method = Literal["lhs", "sobol", "random"]

METHODS: tuple[Method, ...] = ("lhs", "sobol", "random")

LARGEST = 50_000_000
"""Most numbers that may be drawn: 400 MB."""

EDGE = 1e-12
"""Least distance of a draw from the ends of the unit interval. [1]"""


def uncertain_figures(
    vehicle: Vehicle, *, commanded: bool, fixed: Sequence[str] = ()
) -> dict[str, Figure]:
    """Return the figures that a draw moves: with an sd or a range, and with an effect.

    Parameters
    ----------
    vehicle : Vehicle
        Whose file states them.
    commanded : bool
        Whether its controller drives; if not, the controller's figures do nothing.
    fixed : sequence of str
        Keys that are set otherwise.
    """
    base = kernel_params(vehicle, commanded=commanded)
    found = {}
    for key, figure in vehicle.figures().items():
        if key in fixed or not (figure.sd > 0 or spread_of(figure) > 0):
            continue
        near = quantiles(figure, np.array([0.4]), bounds_of(vehicle, key))
        at = vehicle.changed(settings={key: float(near[0])})
        moved = changed_places(base, kernel_params(at, commanded=commanded))
        if any(commanded or table != "control" for table, _ in moved):
            found[key] = figure
    return found


def spread_of(figure: Figure) -> float:
    """Return the width of the range that a figure states; 0 if none."""
    if figure.low is None or figure.high is None:
        return 0.0
    return figure.high - figure.low


def bounds_of(vehicle: Vehicle, key: str) -> tuple[float, float]:
    """Return the least and greatest value with a meaning."""
    if not key.startswith("effects."):
        return 0.0, math.inf
    return vehicle.effect_bounds(key)


def quantiles(figure: Figure, u: Array, bounds: tuple[float, float]) -> Array:
    """Return the values of a figure at the levels u of its distribution.

    Normal about the value where an sd is stated, cut to the range where one is stated
    too and to what has a meaning; else uniform over the range.
    """
    low, high = bounds
    if figure.low is not None and figure.high is not None:
        low, high = max(low, figure.low), min(high, figure.high)
        if figure.sd == 0:
            return low + u * (high - low)
    if figure.sd == 0:
        return np.full_like(u, figure.value)
    from scipy.special import ndtr, ndtri

    cut = ndtr((np.array([low, high]) - figure.value) / figure.sd)
    within = np.clip(cut[0] + u * (cut[1] - cut[0]), EDGE, 1.0 - EDGE)
    values = figure.value + figure.sd * np.asarray(ndtri(within))
    return np.asarray(np.clip(values, low, high))


def unit_draws(n: int, d: int, method: Method, seed: int) -> Array:
    """Return n points of the unit cube of d dimensions, shape (n, d).

    Raises
    ------
    InputError
        If there are none, or more than memory is meant for.
    """
    if n < 1:
        raise InputError(f"draws: should be at least 1: {n}")
    if n * d > LARGEST:
        raise InputError(
            f"draws: {n:,} of {d} figures are too many to hold at once",
            f"{LARGEST // d:,} would do; a grid (--set) holds none of its values",
        )
    if method == "random":
        return np.random.default_rng(seed).random((n, d))
    from scipy.stats import qmc

    if method == "lhs":
        return np.asarray(qmc.LatinHypercube(d, seed=seed).random(n))
    if method == "sobol":
        whole = max(n - 1, 1).bit_length()
        return np.asarray(qmc.Sobol(d, seed=seed).random_base2(whole))[:n]
    raise InputError(
        f"--method {method}: no such method", f"there are {', '.join(METHODS)}"
    )


def file_draws(
    vehicle: Vehicle, n: int, method: Method, seed: int, figures: dict[str, Figure]
) -> tuple[tuple[str, ...], Array]:
    """Return keys and n draws of figures, a row a draw.

    Raises
    ------
    InputError
        If there is no figure to draw.
    """
    if not figures:
        raise InputError(
            f"{vehicle.where}: states no sd and no range of what acts on this run",
            "give a figure as { value = 3.8, sd = 0.1 } or as a range, [3.6, 4.0]",
        )
    u = unit_draws(n, len(figures), method, seed)
    return tuple(figures), at_levels(vehicle, figures, u)


def at_levels(vehicle: Vehicle, figures: dict[str, Figure], u: Array) -> Array:
    """Return the values of figures at levels u of their distributions, shape (n, d)."""
    values = np.empty_like(u)
    for i, (key, figure) in enumerate(figures.items()):
        values[:, i] = quantiles(figure, u[:, i], bounds_of(vehicle, key))
    return values


def read_draws(path: Path) -> tuple[tuple[str, ...], Array]:
    """Return keys and rows of a CSV of draws: a header of keys, a row a draw.

    Raises
    ------
    InputError
        Naming file and line, if it is no such table.
    """
    try:
        with path.open(newline="", encoding="utf-8-sig") as file:
            rows = [(line, row) for line, row in enumerate(csv.reader(file), 1) if row]
    except (OSError, UnicodeDecodeError) as error:
        what = getattr(error, "strerror", None) or "not text in UTF-8"
        raise InputError(f"{path}: cannot be read: {what}") from None
    if len(rows) < 2:
        raise InputError(f"{path}: should have a header of keys and a row a draw")
    keys = tuple(key.strip() for key in rows[0][1])
    if len(set(keys)) < len(keys):
        raise InputError(f"{path}: line 1: names a key twice")
    values = np.empty((len(rows) - 1, len(keys)))
    for i, (line, row) in enumerate(rows[1:]):
        if len(row) != len(keys):
            raise InputError(
                f"{path}: line {line}: should have {len(keys)} figures: {len(row)}"
            )
        for k, text in enumerate(row):
            values[i, k] = _number(f"{path}: line {line}: {keys[k]}", text)
    return keys, values


def _number(where: str, text: str) -> float:
    try:
        number = float(text)
    except ValueError:
        number = math.nan
    endless = where.endswith("lanes.every") and number == math.inf
    if not (math.isfinite(number) or endless):
        raise InputError(f"{where}: should be a number: {text.strip()!r}")
    return number
