"""A trace without dimensions, so that two sizes can be laid over each other."""

from __future__ import annotations

import math
from collections.abc import Sequence
from fractions import Fraction
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

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
from rcc_sim.trace import Trace
from rcc_sim.units import unit_of

Array = NDArray[np.float64]

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
    columns : dict of ndarray, each of shape (n,)
        By the name of each.
    left_out : list of str
        Columns with an electrical or thermal unit, which have no place in it.
    """

    columns: dict[str, Array]
    left_out: list[str]

    def rows(self) -> list[dict[str, float | None]]:
        """Return one dict a row; None where a number was not known."""
        values = [
            [x if math.isfinite(x) else None for x in column.tolist()]
            for column in self.columns.values()
        ]
        rows = zip(*values, strict=True)
        return [dict(zip(self.columns, row, strict=True)) for row in rows]


def dimensionless_trace(
    trace: Trace, vehicle: Vehicle, repeating: Sequence[str] = REPEATING
) -> DimensionlessTrace:
    """Return a trace without dimensions.

    A column with a unit of mass, length and time becomes ``pi_NAME`` by the repeating
    variables of the vehicle, with its group's number where the paper has one
    (``time_s`` -> ``pi_8_time``, ``speed_mps`` -> ``pi_9_speed``, ``accel_x_mps2`` ->
    ``pi_2_accel_x``, ``yaw_rate_radps`` -> ``pi_11_yaw_rate``, ``energy_*_j`` ->
    ``pi_4_energy_*``). Torque and speed of the motor shaft are taken to the road by the
    vehicle's r_w/N_d, as in `Scales`: force over C_F, speed as in pi_9. Columns
    without a unit stay as they are.

    Parameters
    ----------
    trace : Trace
        What was driven.
    vehicle : Vehicle
        The one that drove.
    repeating : sequence of str
        Three figures of the vehicle that span mass, length and time.

    Raises
    ------
    InputError
        If the vehicle does not state one of the repeating variables.
    """
    numbers = {g.variable.symbol: g.name for g in pi_groups(repeating)}
    columns, left_out = {}, []
    for name, values in trace.columns.items():
        dimension = dimension_of(name)
        if dimension is None:
            left_out.append(name)
        elif unit_of(name) == "1":
            columns[name] = values
        else:
            factor = _factor(name, dimension, vehicle, repeating)
            columns[_label(name, dimension, numbers)] = values * factor
    return DimensionlessTrace(columns, left_out)


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
