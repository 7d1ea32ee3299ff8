"""Measured efficiency maps of motors: CSV to a grid."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from rcc_sim.errors import InputError

COLUMNS = ("torque_nm", "speed_radps", "efficiency")


def read_motor_map(
    path: Path,
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Return torque (n,) [N m], speed (k,) [rad/s] and efficiency (n, k) of a map.

    One row a point, in any order; the points must fill a rectangular grid.

    Raises
    ------
    InputError
        Naming file and line if a cell is not a number, an efficiency is not in
        (0, 1], a point is double, or the grid has holes.
    """
    points: dict[tuple[float, float], float] = {}
    try:
        with open(path, encoding="utf-8-sig", newline="") as file:
            reader = csv.DictReader(file)
            missing = [c for c in COLUMNS if c not in (reader.fieldnames or ())]
            if missing:
                raise InputError(
                    f"{path}: no column {', '.join(missing)}",
                    f"a motor map has the columns {', '.join(COLUMNS)}",
                )
            for row in reader:
                _add(points, row, f"{path}: line {reader.line_num}")
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror}") from None
    except (UnicodeDecodeError, csv.Error):
        raise InputError(f"{path}: not a CSV file") from None
    torque = np.array(sorted({key[0] for key in points}))
    speed = np.array(sorted({key[1] for key in points}))
    if len(torque) < 2 or len(speed) < 2:
        raise InputError(f"{path}: a map needs at least two torques and two speeds")
    if len(points) != len(torque) * len(speed):
        hole = next((t, w) for t in torque for w in speed if (t, w) not in points)
        raise InputError(
            f"{path}: no point at {hole[0]:g} N m, {hole[1]:g} rad/s",
            "the points should fill a rectangular grid",
        )
    eta = np.array([[points[t, w] for w in speed] for t in torque])
    return torque, speed, eta


def _add(
    points: dict[tuple[float, float], float], row: dict[str, str], at: str
) -> None:
    try:
        torque, speed, eta = (float(row[c]) for c in COLUMNS)
    except (TypeError, ValueError):
        raise InputError(f"{at}: a cell is not a number") from None
    if not 0 < eta <= 1:
        hint = "a fraction is meant, not percent" if eta > 1 else ""
        raise InputError(f"{at}: efficiency should lie in (0, 1]: {eta:g}", hint)
    if torque < 0 or speed < 0:
        raise InputError(f"{at}: torque and speed should not be negative")
    if (torque, speed) in points:
        raise InputError(f"{at}: the point {torque:g} N m, {speed:g} rad/s is double")
    points[torque, speed] = eta
