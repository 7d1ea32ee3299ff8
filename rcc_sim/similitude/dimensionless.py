"""A trace without dimensions, so that two sizes can be laid over each other."""

from __future__ import annotations

import csv
import gzip
import math
import zlib
from collections.abc import Iterable, Iterator, Sequence
from contextlib import AbstractContextManager, nullcontext
from fractions import Fraction
from pathlib import Path
from typing import Any, NamedTuple, TextIO, cast

from rcc_sim.definitions.vehicle import Vehicle
from rcc_sim.errors import InputError
from rcc_sim.similitude.dimensional import (
    NONE,
    REPEATING,
    Dimension,
    dimension_of,
    exponents_of,
    pi_groups,
)
from rcc_sim.similitude.quantities import figures_of, product
from rcc_sim.similitude.scale import SHAFT, without_unit
from rcc_sim.units import unit_of

NUMBERED = {
    "battery_energy_j": "E_b",
    "battery_energy_wh": "E_b",
    "steer_cmd_rad": "delta",
    "steer_rad": "delta",
    "accel_x_mps2": "a",
    "time_s": "t",
    "speed_mps": "v_x",
    "speed_ref_mps": "v_x",
    "speed_y_mps": "v_y",
    "lateral_speed_mps": "v_y",
    "yaw_rate_radps": "r",
}
"""Column -> the paper's variable that it is; energies are E_b by their prefix."""


class DimensionlessTrace(NamedTuple):
    """A trace without dimensions.

    Attributes
    ----------
    rows : list of dict
        Column -> number, or None where the cell was empty.
    left_out : list of str
        Columns with an electrical or thermal unit, which have no place in it.
    """

    rows: list[dict[str, float | None]]
    left_out: list[str]


class _Column(NamedTuple):
    at: int
    name: str
    factor: float


def dimensionless_trace(
    source: str | TextIO, vehicle: Vehicle, repeating: Sequence[str] = REPEATING
) -> DimensionlessTrace:
    """Read a trace and return it dimensionless.

    A column with a unit of mass, length and time becomes ``pi_NAME`` by the repeating
    variables of the vehicle, with its group's number where the paper has one
    (``time_s`` -> ``pi_8_time``, ``speed_mps`` -> ``pi_9_speed``, ``accel_x_mps2`` ->
    ``pi_2_accel_x``, ``yaw_rate_radps`` -> ``pi_11_yaw_rate``, ``energy_*_j`` ->
    ``pi_4_energy_*``). Torque and speed of the motor shaft are taken to the road by the
    vehicle's r_w/N_d, as in `Scales`: force over C_F, speed as in pi_9. Columns
    without a unit stay as they are.

    Parameters
    ----------
    source : str or TextIO
        Path of a CSV file, compressed if it ends in ``.gz``, or a text stream.
    vehicle : Vehicle
        The one that drove.
    repeating : sequence of str
        Three figures of the vehicle that span mass, length and time.

    Raises
    ------
    InputError
        Naming file and line: no ``time_s``, a cell that is not a number, or repeating
        variables that the vehicle does not state.
    """
    where = source if isinstance(source, str) else "stdin"
    rows: list[dict[str, float | None]] = []
    try:
        with _opened(source) as file:
            reader = csv.reader(file)
            header = [cell.strip() for cell in next(reader, [])]
            columns, left_out = _columns(header, vehicle, repeating, where)
            for cells in reader:
                at = f"{where}: line {reader.line_num}"
                if cells:
                    rows.append(_row(cells, header, columns, at))
    except OSError as error:
        raise InputError(
            f"{where}: cannot be read: {error.strerror or error}"
        ) from None
    except (UnicodeDecodeError, csv.Error, EOFError, zlib.error):
        raise InputError(f"{where}: not a CSV file") from None
    if not rows:
        raise InputError(f"{where}: should have at least one row below its header")
    return DimensionlessTrace(rows, left_out)


def _opened(source: str | TextIO) -> AbstractContextManager[Iterable[str]]:
    if not isinstance(source, str):
        return nullcontext(source)
    if not Path(source).is_file():
        raise InputError(f"{source}: no such file")
    opener: Any = gzip.open if source.endswith(".gz") else open
    file = opener(source, "rt", encoding="utf-8-sig", newline="")
    return cast(AbstractContextManager[Iterable[str]], file)


def _columns(
    header: list[str], vehicle: Vehicle, repeating: Sequence[str], where: str
) -> tuple[list[_Column], list[str]]:
    if "time_s" not in header:
        raise InputError(
            f"{where}: no column time_s", "a trace is a CSV file with a header line"
        )
    doubles = sorted({name for name in header if header.count(name) > 1})
    if doubles:
        raise InputError(f"{where}: the column {doubles[0]} is there twice")
    numbers = {g.variable.symbol: g.name for g in pi_groups(repeating)}
    columns, left_out = [], []
    for at, name in enumerate(header):
        dimension = dimension_of(name)
        if dimension is None:
            left_out.append(name)
        elif unit_of(name) == "1":
            columns.append(_Column(at, name, 1.0))
        else:
            label = _label(name, dimension, numbers)
            columns.append(
                _Column(at, label, _factor(name, dimension, vehicle, repeating))
            )
    return columns, left_out


def _label(name: str, dimension: Dimension, numbers: dict[str, str]) -> str:
    symbol = NUMBERED.get(name, "E_b" if name.startswith("energy_") else "")
    plain = without_unit(name)
    if dimension == NONE and not symbol:
        return f"pi_{plain}"
    return f"{numbers.get(symbol, 'pi')}_{plain}"


def _factor(
    name: str, dimension: Dimension, vehicle: Vehicle, repeating: Sequence[str]
) -> float:
    dimension, lever = SHAFT.get(without_unit(name), (dimension, 0))
    powers = {s: -e for s, e in exponents_of(dimension, repeating).items() if e}
    if lever:
        powers |= {"r_w": Fraction(-lever), "N_d": Fraction(lever)}
    figures = figures_of(vehicle)
    missing = figures.missing(powers)
    if missing:
        raise InputError(
            f"--repeating {','.join(repeating)}: {vehicle.name} has no figure for "
            f"{missing[0]}",
            f"the paper takes {','.join(REPEATING)}",
        )
    result = product(figures, powers)
    assert result is not None, "nothing is missing"
    if not math.isfinite(result.value):
        raise InputError(f"--repeating {','.join(repeating)}: a figure of it is 0")
    return result.value


def _row(
    cells: list[str], header: list[str], columns: list[_Column], at: str
) -> dict[str, float | None]:
    if len(cells) != len(header):
        raise InputError(f"{at}: should have {len(header)} cells: {len(cells)}")
    return dict(_scaled(cells, header, columns, at))


def _scaled(
    cells: list[str], header: list[str], columns: list[_Column], at: str
) -> Iterator[tuple[str, float | None]]:
    for column in columns:
        text = cells[column.at].strip()
        if text in ("", "nan", "NaN"):
            yield column.name, None
            continue
        try:
            yield column.name, float(text) * column.factor
        except ValueError:
            raise InputError(
                f"{at}: {header[column.at]} should be a number: {text[:40]!r}"
            ) from None
