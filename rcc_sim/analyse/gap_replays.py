"""Replays that a gap is made of: the model's prediction, and what its sds do to it."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rcc_sim.definitions.vehicle import Vehicle
from rcc_sim.errors import InputError
from rcc_sim.side_by_side import in_turn
from rcc_sim.simulate.drive import Drive
from rcc_sim.simulate.replay import replay

Array = NDArray[np.float64]
Progress = Callable[[float], None]

PIECE = 100_000
"""Rows that are replayed at once; a longer drive goes in pieces."""

RUN_IN = 30.0
"""Time before a piece from which it is run, so that its start does not matter. [s]"""

SAMPLED = 60_000
"""Rows on which the tolerances of a longer drive are tried, in stretches."""

STRETCHES = 6
"""Stretches, evenly over the drive, that these rows are taken from."""

SHARES = (1.0, -1.0, 0.5, -0.5, 0.25, -0.25, 0.1, -0.1)
"""Shares of its sd by which a figure is moved: the first that a vehicle may have."""


def predicted(
    vehicle: Vehicle,
    drive: Drive,
    columns: Sequence[str],
    *,
    substeps: int = 1,
    progress: Progress | None = None,
) -> dict[str, Array]:
    """Return some columns of a free replay, at the log's rows.

    A drive of more than :data:`PIECE` rows runs in pieces, each from half a minute
    before its first row, which is what keeps memory small.
    """
    n = len(drive.time)
    if n <= PIECE:
        out = replay(vehicle, drive, substeps=substeps)
        return {name: out[name] for name in columns if name in out}
    pieces = list(_pieces(drive.time))
    whole: dict[str, Array] = {}

    def one(piece: tuple[int, int, int]) -> None:
        low, start, end = piece
        out = replay(vehicle, drive.part(slice(low, end)), substeps=substeps)
        for name in columns:
            if name in out:
                whole.setdefault(name, np.empty(n))[start:end] = out[name][
                    start - low :
                ]

    one(pieces[0])
    for done, _ in enumerate(in_turn(one, pieces[1:]), start=2):
        if progress is not None:
            progress(done / len(pieces))
    return whole


def _pieces(time: Array) -> Iterator[tuple[int, int, int]]:
    """Yield first row of the run-in, first row and one-past-last row of each piece."""
    for start in range(0, len(time), PIECE):
        low = int(np.searchsorted(time, time[start] - RUN_IN))
        yield min(low, start), start, min(start + PIECE, len(time))


@dataclass(frozen=True)
class Tolerances:
    """What the vehicle file's sds do to a prediction, each figure moved by its sd.

    Parameters
    ----------
    keys : tuple of str
        Figures that have an sd.
    rows : ndarray of int
        Rows that were looked at; of a long drive some stretches.
    moved : dict
        Column -> shift at those rows, shape (figures, rows).
    """

    keys: tuple[str, ...]
    rows: NDArray[np.intp]
    moved: dict[str, Array]

    def band(self, column: str, n: int) -> Array | float:
        """Return one sd of a column at all rows; its mean where not all were tried."""
        moved = self.moved.get(column)
        if moved is None or not len(moved):
            return 0.0
        squares: Array = (moved**2).sum(axis=0)
        if len(self.rows) == n:
            return np.asarray(np.sqrt(squares))
        return float(np.sqrt(np.nanmean(squares)))


def toleranced(vehicle: Vehicle) -> dict[str, tuple[float, float]]:
    """Return key -> value and sd, of the figures that the file is unsure of."""
    return {
        key: (figure.value, sd)
        for key, figure in vehicle.figures().items()
        if (sd := figure.tolerance) > 0
    }


def tolerances(
    vehicle: Vehicle,
    drive: Drive,
    columns: Collection[str],
    progress: Progress | None = None,
) -> Tolerances:
    """Push each figure's sd through one replay; linear, one figure at a time.

    They are differences alone, for which longer time steps are enough. A figure that
    cannot be an sd larger is stepped down, or by less, and its shift told as of +1 sd.

    Parameters
    ----------
    columns : collection of str
        What is looked at of the prediction.
    """
    figures = toleranced(vehicle)
    parts = list(_stretches(len(drive.time)))
    rows = np.concatenate([np.arange(p.start, p.stop) for p in parts])
    names = tuple(columns)
    drives = [drive.part(part) if len(parts) > 1 else drive for part in parts]
    start = [replay(vehicle, d, coarse=True) for d in drives]

    def one(item: tuple[str, tuple[float, float]]) -> list[Array]:
        key, (value, sd) = item
        share, other = moved_by_one(vehicle, key, value, sd)
        runs = [replay(other, d, coarse=True) for d in drives]
        pairs = list(zip(runs, start, strict=True))
        return [
            np.concatenate([(r[c] - s[c]) / share for r, s in pairs]) for c in names
        ]

    shifts = []
    for done, shift in enumerate(in_turn(one, [*figures.items()]), start=1):
        shifts.append(shift)
        if progress is not None:
            progress(done / len(figures))
    shape = (len(figures), len(rows))
    moved = {
        c: np.array([s[k] for s in shifts]).reshape(shape) for k, c in enumerate(names)
    }
    return Tolerances(tuple(figures), rows, moved)


def moved_by_one(
    vehicle: Vehicle, key: str, value: float, sd: float
) -> tuple[float, Vehicle]:
    """Return a vehicle with a figure moved by its sd, or the share of it that can be.

    Raises
    ------
    InputError
        If no such step is possible.
    """
    *some, last = (s for s in SHARES if value + s * sd != 0)
    for share in some:
        try:
            return share, vehicle.changed(settings={key: value + share * sd})
        except InputError:
            continue
    return last, vehicle.changed(settings={key: value + last * sd})


def _stretches(n: int) -> Iterable[slice]:
    if n <= SAMPLED:
        return [slice(0, n)]
    each = SAMPLED // STRETCHES
    starts = np.linspace(0, n - each, STRETCHES).astype(int)
    return [slice(int(s), int(s) + each) for s in starts]
