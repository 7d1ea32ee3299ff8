"""The energy gap cut up along the power chain, wherever the log measured between."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from rcc_sim.analyse.gap_energy import (
    POWER,
    EnergyGap,
    energy_noise,
    energy_tolerance,
    shaft_torque,
)
from rcc_sim.analyse.gap_regimes import Scale
from rcc_sim.analyse.gap_replays import Tolerances
from rcc_sim.channel import moving_mean, rows_in
from rcc_sim.definitions.vehicle import Vehicle
from rcc_sim.simulate.drive import Drive, drive_of
from rcc_sim.trace import Trace
from rcc_sim.units import J_PER_WH

Array = NDArray[np.float64]
Power = Callable[[Drive], tuple[Array, Array]]

DRIVEN = ("speed_ref_mps", "throttle")
"""Columns without which a log is driven by its motion."""

SLOW = 0.02
"""Share of the top speed below which a gyro reads its own offset. [1]"""


@dataclass(frozen=True)
class StageGap:
    """What one stage of the power chain has of the gap; all stages sum to it.

    ``u_val_wh`` is the standard uncertainty of it: by the scatter of its power from
    stretch to stretch, by the file's sds, by a bias of the battery's sensors where it
    ends in what was measured.
    """

    stage: str
    gap_wh: float
    share: float
    u_val_wh: float = 0.0


def stage_gaps(
    log: Trace,
    vehicle: Vehicle,
    drive: Drive,
    power: Power,
    *,
    simulated: Array,
    measured: Array | None,
    weights: Array,
    moved: Tolerances,
    energy: EnergyGap,
) -> list[StageGap]:
    """Cut the gap up by driving the model with ever more of what was measured.

    The commanded model, the model on the measured speed (the rest to the former is
    *control*), on the measured yaw rate (*lateral*), with the measured torque
    (*mechanical*), and what was measured at last (*electrical*). What the log does
    not tell apart stays one stage, named for both.

    Parameters
    ----------
    power : callable
        The simulated power [W] of a drive, and how the file's sds move it at the rows
        of ``moved``.
    simulated, measured : ndarray, shape (n,)
        Power of the drive as it is, and as logged; None where none was. [W]
    weights : ndarray, shape (n,)
        Time that each row stands for. [s]
    moved : Tolerances
        How the file's sds move the power of the drive as it is, as column ``power``.
    energy : EnergyGap
        Of the whole drive: where it was measured, and its uncertainties.
    """
    if measured is None:
        return []
    levels: list[tuple[str, Array, Array]] = []
    at_battery = energy.at == "battery"
    now = drive
    if not drive.imposed and log.has("speed_mps"):
        now = _moved(log, vehicle, drive)
        levels.append(("control", *power(now)))
    if now.imposed and now.steered and log.has("yaw_rate_radps"):
        rows = rows_in(drive.time, Scale.of(vehicle).time)
        now = _yawed(now, rows)
        levels.append(("lateral", *power(now)))
    torque = shaft_torque(log.columns, vehicle)
    rest = "mechanical" if not at_battery else "mechanical and electrical"
    if at_battery and torque is not None and now.imposed:
        levels.append(("mechanical", *power(now.known_as(torque=torque))))
        rest = "electrical"
    if not now.imposed:
        rest = f"control, {rest}"
    start = moved.moved[POWER]
    levels.append((rest, measured, np.zeros_like(start)))
    found = []
    before, shifts = simulated, start
    for place, (name, after, moves) in enumerate(levels):
        # where no speed was logged nothing is told apart before the end of the chain
        after = np.where(np.isfinite(after), after, before)
        change = np.where(weights > 0, after - before, 0.0)
        own = replace(moved, moved={POWER: shifts - moves})
        parts = [
            energy_tolerance(weights, own, POWER),
            energy_noise(change, weights, own, POWER),
            energy.numerical_wh,
        ]
        if place == len(levels) - 1:
            parts.append(energy.bias_wh)
        u_val = float(np.sqrt(sum(part * part for part in parts)))
        found.append((name, float((change * weights).sum()) / J_PER_WH, u_val))
        before, shifts = after, moves
    total = sum(abs(gap) for _, gap, _ in found) or 1.0
    return [StageGap(name, gap, gap / total, u_val) for name, gap, u_val in found]


def untorqued(drive: Drive) -> Drive:
    """Return the drive without the torque that was measured."""
    return drive.known_as(torque=np.full(len(drive.time), np.nan))


def _moved(log: Trace, vehicle: Vehicle, drive: Drive) -> Drive:
    """Return the drive with its measured motion imposed, its commands forgotten."""
    kept = {n: values for n, values in log.columns.items() if n not in DRIVEN}
    moved = drive_of(Trace(kept, name=log.name), vehicle, window=drive.window)
    return untorqued(moved)


def _yawed(drive: Drive, rows: int) -> Drive:
    """Return the drive with its measured yaw rate in place of its steering."""
    speed, yaw_rate = drive.measured.speed, drive.measured.yaw_rate
    calm = moving_mean(yaw_rate, rows)
    still = speed < SLOW * float(np.max(speed))
    if still.any():
        calm = calm - float(np.median(calm[still]))
    known = drive.known_as(yaw_rate=np.ascontiguousarray(calm))
    return replace(known, steered=False)
