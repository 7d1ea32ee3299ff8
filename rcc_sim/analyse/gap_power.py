"""The power that a gap is in, simulated and moved by the file's sds, and its energy."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from rcc_sim.analyse.gap_energy import (
    POWER,
    EnergyGap,
    bias_noise,
    energy_noise,
    energy_of,
    energy_shifts,
    logged_power,
    row_weights,
    shaft_power,
)
from rcc_sim.analyse.gap_replays import PIECE, Tolerances, predicted, tolerances
from rcc_sim.definitions.vehicle import Vehicle
from rcc_sim.simulate.drive import Drive
from rcc_sim.trace import Trace
from rcc_sim.units import J_PER_WH

Array = NDArray[np.float64]

POWERS = ("battery_power_w", "motor_torque_nm", "motor_speed_radps")
"""Columns from which a simulated power follows."""


def measured_power(log: Trace, vehicle: Vehicle) -> tuple[str, Array | None]:
    """Return where a log measured the power, battery or else shaft, and it. [W]"""
    power = logged_power(log)
    if power is not None:
        return "battery", power
    return "shaft", shaft_power(log.columns, vehicle)


def power_of(at: str, columns: Mapping[str, Array]) -> Array:
    """Return the simulated power at the battery or at the shaft. [W]"""
    if at == "battery":
        return columns["battery_power_w"]
    return columns["motor_torque_nm"] * columns["motor_speed_radps"]


def power_and_shifts(vehicle: Vehicle, drive: Drive, at: str) -> tuple[Array, Array]:
    """Return the simulated power of a drive, and how the file's sds move it. [W]"""
    columns = predicted(vehicle, drive, POWERS)
    moved = tolerances(vehicle, drive, columns)
    return power_of(at, columns), _power_moved(moved, columns, at).moved[POWER]


def energy_gap(
    log: Trace,
    vehicle: Vehicle,
    drive: Drive,
    simulated: dict[str, Array],
    *,
    moved: Tolerances,
) -> tuple[EnergyGap, Array | None, Array, Tolerances]:
    """Return the energy gap, the measured power, the time that each row stands for.

    And, last, how the file's sds move the simulated power, as column ``power``. The
    power is None where neither battery nor shaft was logged.
    """
    none = EnergyGap("", None, None)
    at, measured = measured_power(log, vehicle)
    if measured is None:
        return none, None, np.zeros(len(log)), moved
    model = power_of(at, simulated)
    ok = np.isfinite(measured) & np.isfinite(model)
    weights = row_weights(drive.time, ok)
    if not weights.any():
        return none, None, weights, moved
    moved = _power_moved(moved, simulated, at)
    noise = energy_noise(measured - model, weights, moved, POWER)
    shifts = energy_shifts(weights, moved, POWER)
    bias = bias_noise(log, vehicle, weights) if at == "battery" else 0.0
    energy = EnergyGap(
        at,
        energy_of(measured, weights) / J_PER_WH,
        energy_of(model, weights) / J_PER_WH,
        noise_wh=float(np.hypot(noise, bias)),
        tolerance_wh=float(np.linalg.norm(shifts)),
        bias_wh=bias,
        by_figure=_by_figure(moved, shifts),
    )
    step = _step_error(vehicle, drive, at, model, weights)
    return replace(energy, numerical_wh=step), measured, weights, moved


def _by_figure(moved: Tolerances, shifts: Array) -> dict[str, float]:
    found = [(k, float(x)) for k, x in zip(moved.keys, shifts, strict=True) if x]
    return dict(sorted(found, key=lambda pair: -abs(pair[1])))


def _power_moved(
    moved: Tolerances, simulated: Mapping[str, Array], at: str
) -> Tolerances:
    if at == "battery":
        return replace(moved, moved={POWER: moved.moved["battery_power_w"]})
    tau, omega = (
        simulated[c][moved.rows] for c in ("motor_torque_nm", "motor_speed_radps")
    )
    shifts = (tau + moved.moved["motor_torque_nm"]) * (
        omega + moved.moved["motor_speed_radps"]
    ) - tau * omega
    return replace(moved, moved={POWER: shifts})


def _step_error(
    vehicle: Vehicle, drive: Drive, at: str, model: Array, weights: Array
) -> float:
    """Return what half the time step does to the energy [Wh].

    Of the first rows of a long log, and where a speed was read, for all of it.
    """
    rows = slice(0, min(len(model), PIECE))
    part = drive if rows.stop == len(model) else drive.part(rows)
    fine = power_of(at, predicted(vehicle, part, POWERS, substeps=2))
    seen = np.where(np.isfinite(fine - model[rows]), weights[rows], 0.0)
    change = np.where(seen > 0, fine - model[rows], 0.0) * seen
    whole = float(weights.sum() / max(seen.sum(), 1e-30))
    return abs(float(change.sum())) * whole / J_PER_WH
