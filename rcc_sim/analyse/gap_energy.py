"""The energy gap of a drive, and how large it may be while the model is right."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from rcc_sim.analyse.gap_replays import Tolerances
from rcc_sim.analyse.offsets import offset_sd
from rcc_sim.definitions.kernel import motor_torque_constant
from rcc_sim.definitions.vehicle import Vehicle
from rcc_sim.simulate.holes import bridged_but_holes
from rcc_sim.simulate.smooth import HOLE
from rcc_sim.trace import Trace
from rcc_sim.units import J_PER_WH

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

COVERAGE = 2.0
"""Standard uncertainties within which a gap is none: 95 %."""

POWER = "power"
"""Column of the tolerances that holds the power in question, of battery or shaft."""

BLOCKS = 40
"""Stretches between which the scatter of the power is judged."""

VAGUE, SETTLES = 10.0, 4
"""Sd of that power's mean, in its usual sizes: it is as good as free. And rounds in
which mean, shifts of tolerances and scatter are found from one another."""


@dataclass(frozen=True)
class EnergyGap:
    """Measured against simulated energy, after ASME V&V 20.

    Parameters
    ----------
    at : str
        Where it is measured: ``battery``, ``shaft``, or empty where nowhere.
    measured_wh, simulated_wh : float or None
        Over the same rows. [Wh]
    noise_wh, tolerance_wh, numerical_wh : float
        Standard uncertainties: of the data and the road, of the file's figures, of
        the time step. [Wh]
    bias_wh : float
        The part of ``noise_wh`` that is a constant bias of the battery's sensors. [Wh]
    by_figure : dict
        Figure of the file -> what one sd more of it adds to the simulated energy,
        largest first; ``tolerance_wh`` is the root of their squares' sum. [Wh]
    """

    at: str
    measured_wh: float | None
    simulated_wh: float | None
    noise_wh: float = 0.0
    tolerance_wh: float = 0.0
    numerical_wh: float = 0.0
    bias_wh: float = 0.0
    by_figure: dict[str, float] = field(default_factory=dict)

    @property
    def gap_wh(self) -> float | None:
        """Measured less simulated. [Wh]"""
        if self.measured_wh is None or self.simulated_wh is None:
            return None
        return self.measured_wh - self.simulated_wh

    @property
    def gap_percent(self) -> float | None:
        """The gap in percent of what was measured."""
        return percent_of(self.measured_wh, self.simulated_wh)

    @property
    def u_val(self) -> float:
        r"""Standard uncertainty of the gap. [Wh]

        .. math:: u_{val}^2 = u_D^2 + u_{input}^2 + u_{num}^2
        """
        parts = (self.noise_wh, self.tolerance_wh, self.numerical_wh)
        return float(np.sqrt(sum(part * part for part in parts)))

    @property
    def expanded(self) -> float:
        """Expanded uncertainty: 95 % of sound drives have a smaller gap. [Wh]"""
        return COVERAGE * self.u_val

    @property
    def within(self) -> bool | None:
        """Whether the gap is none: at most its expanded uncertainty."""
        return None if self.gap_wh is None else not self.beyond(1.0)

    def beyond(self, times: float) -> bool:
        """Whether the gap is more than some times its expanded uncertainty."""
        allowed = times * self.expanded
        return self.gap_wh is not None and not abs(self.gap_wh) <= allowed


def logged_power(log: Trace) -> Array | None:
    """Return the power at the battery's terminals [W], where the log tells.

    Of voltage and current that were read in turn, at the current's rows.
    """
    if log.has("battery_power_w"):
        return log["battery_power_w"]
    if log.has("battery_voltage_v") and log.has("battery_current_a"):
        voltage = bridged_but_holes(log["time_s"], log["battery_voltage_v"])
        return voltage * log["battery_current_a"]
    return None


def without_offsets(log: Trace, offsets: Mapping[str, float]) -> Trace:
    """Return a log as its meters would read without these offsets, by column.

    A power that was logged beside its voltage and current, and has no offset of its
    own, has theirs.
    """
    columns = {c: x - offsets.get(c, 0.0) for c, x in log.columns.items()}
    power, parts = "battery_power_w", ("battery_voltage_v", "battery_current_a")
    if power in log and power not in offsets and all(c in log for c in parts):
        u, i = parts
        more = log[u] * log[i] - columns[u] * columns[i]
        columns[power] = columns[power] - np.nan_to_num(more)
    return replace(log, columns=columns)


def shaft_power(columns: Mapping[str, Array], vehicle: Vehicle) -> Array | None:
    """Return the power at the motor's shaft [W], from torque or current, and speed."""
    torque = shaft_torque(columns, vehicle)
    if torque is None:
        return None
    if "motor_speed_radps" in columns:
        return torque * columns["motor_speed_radps"]
    if "speed_mps" not in columns:
        return None
    return torque * columns["speed_mps"] * vehicle.rad_per_m


def shaft_torque(columns: Mapping[str, Array], vehicle: Vehicle) -> Array | None:
    """Return the motor's torque [N m] as logged, or from its current."""
    torque = columns.get("motor_torque_nm")
    if torque is not None and np.isfinite(torque).any():
        return torque
    current = columns.get("motor_current_a")
    K_t = motor_torque_constant(vehicle)
    if current is None or not np.isfinite(current).any() or not K_t:
        return None
    return K_t * current


def percent_of(measured: float | None, simulated: float | None) -> float | None:
    """Return measured less simulated energy, in percent of the size of the first."""
    if simulated is None or not measured:
        return None
    return 100 * (measured - simulated) / abs(measured)


def row_weights(time: Array, ok: Mask) -> Array:
    """Return the time that each row stands for, by the trapezoidal rule. [s]

    Rows that are not ``ok`` stand for none, nor does the first, before which nothing is
    known; and holes longer than five intervals of the others are left out on both sides
    alike.
    """
    weights = np.zeros(len(time))
    rows = 1 + np.flatnonzero(ok[1:])
    if len(rows) < 2:
        return weights
    steps = np.diff(time[rows])
    steps = np.where(steps > HOLE * np.median(steps), 0.0, steps)
    weights[rows[1:]] += 0.5 * steps
    weights[rows[:-1]] += 0.5 * steps
    return weights


def energy_of(power: Array, weights: Array) -> float:
    """Return the energy of a power over the rows that stand for some time. [J]"""
    return float((np.where(weights > 0, power, 0.0) * weights).sum())


def energy_noise(
    gap: Array, weights: Array, tolerances: Tolerances, column: str
) -> float:
    """Return the uncertainty of an energy that noise and a rough road leave. [Wh]

    The power's gap, less what the tolerances explain of it, scatters from stretch to
    stretch; that scatter, without its mean, adds up over the drive.
    """
    rows = tolerances.rows
    w, e = weights[rows], np.where(np.isfinite(gap[rows]), gap[rows], 0.0)
    place = np.arange(len(rows)) * BLOCKS // len(rows)
    blocks = np.bincount(place, w * e, BLOCKS)
    moved = tolerances.moved.get(column, np.zeros((0, len(rows))))
    shifts = [
        np.bincount(place, w * np.where(np.isfinite(m), m, 0.0), BLOCKS) for m in moved
    ]
    level = np.full(BLOCKS, VAGUE * np.abs(blocks).mean())
    X = np.array([*shifts, level]).T
    scatter = float(np.var(blocks)) + 1e-30
    for _ in range(SETTLES):
        N = X.T @ X / scatter + np.eye(X.shape[1])
        left = blocks - X @ np.linalg.solve(N, X.T @ blocks / scatter)
        scatter = max(float(np.var(left)), 1e-30)
    whole = float(weights.sum() / max(w.sum(), 1e-30))
    return float(np.sqrt(scatter * BLOCKS * whole)) / J_PER_WH


def bias_noise(log: Trace, vehicle: Vehicle, weights: Array) -> float:
    """Return what the offsets of the battery's sensors do to an energy. [Wh]"""
    if log.has("battery_power_w"):
        watts = offset_sd(log, vehicle, "battery_power_w")
        return watts * float(weights.sum()) / J_PER_WH
    if not log.has("battery_current_a"):
        return 0.0
    voltage = bridged_but_holes(log["time_s"], log["battery_voltage_v"])
    voltage = np.where(weights > 0, voltage, 0.0)
    joules = float((np.abs(voltage) * weights).sum())
    current = np.where(weights > 0, log["battery_current_a"], 0.0)
    ampere_seconds = abs(float((current * weights).sum()))
    by_current = offset_sd(log, vehicle, "battery_current_a") * joules
    by_voltage = offset_sd(log, vehicle, "battery_voltage_v") * ampere_seconds
    return float(np.hypot(by_current, by_voltage)) / J_PER_WH


def energy_tolerance(weights: Array, tolerances: Tolerances, column: str) -> float:
    """Return the uncertainty of a simulated energy that the file's sds leave. [Wh]"""
    return float(np.linalg.norm(energy_shifts(weights, tolerances, column)))


def energy_shifts(weights: Array, tolerances: Tolerances, column: str) -> Array:
    """Return what one sd more of each figure adds to a simulated energy. [Wh]"""
    moved = tolerances.moved.get(column)
    if moved is None or not len(moved):
        return np.zeros(0)
    w = weights[tolerances.rows]
    whole = float(weights.sum() / max(w.sum(), 1e-30)) / J_PER_WH
    return np.asarray(np.where(np.isfinite(moved), moved, 0.0) @ w * whole)


def share_uncertainty(
    kinds: NDArray[np.intp],
    count: int,
    weights: Array,
    tolerances: Tolerances,
    energy: EnergyGap,
) -> Array:
    """Return the standard uncertainty of the energy gap in each kind of row. [Wh]

    The file's sds as they act there; noise by the time that the rows last.
    """
    time = np.bincount(kinds, weights, count)
    part = time / max(float(time.sum()), 1e-30)
    noise = np.sqrt(max(energy.noise_wh**2 - energy.bias_wh**2, 0.0) * part)
    squares = noise**2 + (energy.bias_wh * part) ** 2 + energy.numerical_wh**2 * part
    moved = tolerances.moved.get(POWER)
    if moved is not None and len(moved):
        rows = tolerances.rows
        w, there = weights[rows], kinds[rows]
        seen = np.bincount(there, w, count)
        scale = np.divide(time, seen, out=np.zeros(count), where=seen > 0)
        for shift in moved:
            joules = np.bincount(
                there, w * np.where(np.isfinite(shift), shift, 0), count
            )
            squares += (joules * scale / J_PER_WH) ** 2
    return np.asarray(np.sqrt(squares))
