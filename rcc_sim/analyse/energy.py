"""The energy report: ledger, consumption, range, and where over the drive it went."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rcc_sim.definitions.vehicle import Vehicle, load_vehicle
from rcc_sim.errors import InputError
from rcc_sim.physics.ledger import left_open
from rcc_sim.similitude.scale import Scales
from rcc_sim.similitude.unlikely import DENSEST
from rcc_sim.simulate.holes import bridged_but_holes
from rcc_sim.trace import Trace, integral_of
from rcc_sim.units import J_PER_WH

STANDS = 0.002
"""Share of the drive's top speed below which the vehicle stands."""

STEADY = 0.02
"""Share of the drive's largest acceleration below which it cruises."""

REGIMES = ("standstill", "acceleration", "cruise", "deceleration")

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Regime:
    """What one kind of driving took."""

    name: str
    time_s: float
    distance_m: float
    energy_wh: float


@dataclass(frozen=True)
class EnergyReport:
    """Where the energy of one drive went.

    Parameters
    ----------
    name : str
        The trace.
    energy_wh : float
        Energy that left the battery's terminals, less what came back. [Wh]
    distance_m, duration_s : float
        Of the whole trace. [m], [s]
    ledger : dict
        Sink -> energy [Wh]; empty for a measured trace, which has none. With the
        loss inside the battery it sums to ``energy_wh`` plus that loss.
    residual : float or None
        What the ledger leaves open, as a fraction of the throughput.
    regimes : tuple of Regime
        The same energy by kind of driving.
    bridged : int
        Rows without a reading of the power, over which it was drawn straight.
    """

    name: str
    energy_wh: float
    distance_m: float
    duration_s: float
    ledger: dict[str, float]
    residual: float | None
    regimes: tuple[Regime, ...] = field(default=())
    bridged: int = 0

    @property
    def wh_per_km(self) -> float | None:
        """Energy per distance [Wh/km]; None for a vehicle that never moved."""
        if self.distance_m <= 0:
            return None
        return self.energy_wh / (self.distance_m / 1000)

    def range_km(self, capacity_wh: float) -> float | None:
        """Distance that a full battery lasts at this consumption. [km]"""
        per_km = self.wh_per_km
        return capacity_wh / per_km if per_km is not None and per_km > 0 else None


def energy_report(trace: Trace) -> EnergyReport:
    """Return the energy report of a trace, simulated or measured.

    A trace with ledger columns (``battery_energy_j``, ``energy_<sink>_j``) is
    closed; one without is integrated from ``battery_power_w``, or voltage times
    current, by the trapezoidal rule. Up to five rows without a reading are bridged.

    Raises
    ------
    InputError
        If the trace holds no energy at all, or is without a reading for longer.
    LedgerError
        If its ledger does not close to 1e-6 of the throughput.
    """
    time = trace["time_s"]
    joules = cumulative_energy(trace)
    ledger = {
        column.removeprefix("energy_").removesuffix("_j"): float(values[-1] - values[0])
        for column, values in trace.columns.items()
        if column.startswith("energy_") and column.endswith("_j")
    }
    counted = "battery_energy_j" in trace
    residual = _residual(trace, ledger) if counted else None
    distance = cumulative_distance(trace)
    return EnergyReport(
        name=trace.name,
        energy_wh=float(joules[-1] - joules[0]) / J_PER_WH,
        distance_m=float(distance[-1] - distance[0]),
        duration_s=float(time[-1] - time[0]),
        ledger={sink: energy / J_PER_WH for sink, energy in ledger.items()},
        residual=residual,
        regimes=_regimes(trace, joules, distance),
        bridged=0 if counted else int(np.isnan(_battery_power(trace)).sum()),
    )


def cumulative_energy(trace: Trace) -> Array:
    """Return the energy [J] that left the battery's terminals up to each row.

    Raises
    ------
    InputError
        If no column tells, or one that does has gaps.
    """
    if "battery_energy_j" in trace:
        inside = trace.columns.get("energy_battery_resistance_j")
        cells = _without_gaps(trace, trace["battery_energy_j"], "battery_energy_j")
        return cells if inside is None else cells - inside
    return _integral(trace, _battery_power(trace), "battery power")


def _battery_power(trace: Trace) -> Array:
    """Return the power at the battery's terminals, as logged, else V I. [W]"""
    if "battery_power_w" in trace:
        return trace["battery_power_w"]
    if "battery_voltage_v" in trace and "battery_current_a" in trace:
        return trace["battery_voltage_v"] * trace["battery_current_a"]
    raise InputError(
        f"{trace.name}: no energy in it",
        "it needs battery_power_w, or battery_voltage_v and battery_current_a",
    )


def cumulative_distance(trace: Trace) -> Array:
    """Return the distance [m] up to each row: ``distance_m``, else ∫ speed dt.

    Raises
    ------
    InputError
        If the trace has neither, or what it has has gaps.
    """
    if "distance_m" in trace:
        return _without_gaps(trace, trace["distance_m"], "distance_m")
    return _integral(trace, trace["speed_mps"], "speed_mps")


def _without_gaps(trace: Trace, values: Array, what: str) -> Array:
    """Return a column with short gaps bridged; raise at a long one, or an infinity."""
    if np.isnan(values).any() and not np.isinf(values).any():
        values = bridged_but_holes(trace["time_s"], values)
    bad = ~np.isfinite(values)
    if bad.any():
        row, count = int(bad.argmax()), int(bad.sum())
        found = "missing" if np.isnan(values[row]) else f"{values[row]:g}"
        raise InputError(
            f"{trace.name}: {what}, row {row + 1}: {found} ({count} of {len(values)} "
            "rows)",
            "an energy over so long a gap would be a guess; fill or cut the rows first",
        )
    return values


def _integral(trace: Trace, values: Array, what: str) -> Array:
    return integral_of(trace["time_s"], _without_gaps(trace, values, what))


def _residual(trace: Trace, ledger: dict[str, float]) -> float:
    cells = trace["battery_energy_j"]
    given = float(cells[-1] - cells[0])
    through = float(np.abs(np.diff(cells)).sum())
    return left_open(trace.name, given, ledger, through)


def _regimes(trace: Trace, joules: Array, distance: Array) -> tuple[Regime, ...]:
    if "speed_mps" not in trace or len(trace) < 2:
        return ()
    dt = np.diff(trace["time_s"])
    kind = kinds_of_driving(trace)
    return tuple(
        Regime(
            name,
            float(dt[kind == k].sum()),
            float(np.diff(distance)[kind == k].sum()),
            float(np.diff(joules)[kind == k].sum()) / J_PER_WH,
        )
        for k, name in enumerate(REGIMES)
    )


def kinds_of_driving(trace: Trace) -> NDArray[np.intp]:
    """Return which of REGIMES each step from row to row is, shape (n - 1,).

    -1 where no speed tells.
    """
    speed = trace["speed_mps"]
    middle = 0.5 * (speed[1:] + speed[:-1])
    change = np.diff(speed) / np.diff(trace["time_s"])
    stands = middle <= STANDS * max(float(np.nanmax(np.abs(speed))), 1e-9)
    steady = np.abs(change) <= STEADY * max(float(np.nanmax(np.abs(change))), 1e-9)
    kinds = np.select([stands, steady, change > 0], [0, 2, 1], 3)
    return np.where(np.isfinite(change), kinds, -1)


def battery_capacity(vehicle: Vehicle) -> float:
    """Return the energy of a full battery, as its file states it. [Wh]

    Raises
    ------
    InputError
        If the vehicle's file does not state them.
    """
    capacity = vehicle.figure("battery.capacity_ah", "range needs it").value
    joules = vehicle.battery_energy
    if joules is None:
        vehicle.figure("battery.nominal_voltage_v", "range needs it")  # raises
    assert joules is not None
    energy = joules / J_PER_WH
    if energy > DENSEST * vehicle.body.mass_kg.value:
        raise InputError(
            f"{vehicle.where}: battery.capacity_ah: {capacity:g} A h at "
            f"{energy / capacity:g} V does not go with "
            f"{vehicle.body.mass_kg.value:g} kg",
            "ampere-hours of the whole pack are meant; 5000 mAh are 5",
        )
    return energy


def scaled_trace(trace: Trace, from_: str | None, to: str | None) -> Trace:
    """Return a drive of one vehicle at the size of another, by their π groups.

    Currents and voltages have no size: where they alone tell the battery's power, that
    takes their place.

    Raises
    ------
    InputError
        If only one of the two vehicles is named, or the trace holds no energy.
    """
    if from_ is None or to is None:
        raise InputError("--from and --to: both are needed to change the size")
    columns = dict(trace.columns)
    if "battery_energy_j" not in trace:
        columns["battery_power_w"] = _battery_power(trace)
    scales = Scales.between(load_vehicle(to), load_vehicle(from_))
    return Trace(scales.columns(columns)[0], name=f"{trace.name} (as {to})")


def compared(reports: Sequence[EnergyReport]) -> list[dict[str, Any]]:
    """Return how each report differs from the first, in percent and by sink."""
    first, *others = reports
    return [
        {
            "trace": other.name,
            "wh_per_km_percent": _percent(other.wh_per_km, first.wh_per_km),
            "energy_percent": _percent(other.energy_wh, first.energy_wh),
            "ledger_wh_per_km": {
                sink: _per_km(other, sink) - _per_km(first, sink)
                for sink in dict.fromkeys((*first.ledger, *other.ledger))
            },
        }
        for other in others
    ]


def table(
    reports: Sequence[EnergyReport], capacity_wh: float | None = None
) -> list[dict[str, Any]]:
    """Return rows for people: a line a sink, then totals; a column a report."""
    sinks = dict.fromkeys(sink for report in reports for sink in report.ledger)
    lines: list[tuple[str, str, list[float | None]]] = [
        (sink, "Wh", [report.ledger.get(sink) for report in reports]) for sink in sinks
    ]
    lines += [
        ("energy", "Wh", [r.energy_wh for r in reports]),
        ("distance", "m", [r.distance_m for r in reports]),
        ("consumption", "Wh/km", [r.wh_per_km for r in reports]),
    ]
    if len(reports) > 1:
        against = [None, *(c["wh_per_km_percent"] for c in compared(reports))]
        lines.append(("consumption against the first", "%", against))
    if capacity_wh is not None:
        lines.append(("range", "km", [r.range_km(capacity_wh) for r in reports]))
    if sinks:  # what was measured has none
        lines.append(("ledger left open", "1", [r.residual for r in reports]))
    if len(reports) == 1:
        total = reports[0].energy_wh or 1.0
        return [
            {
                "what": what,
                "value": values[0],
                "unit": unit,
                "share_percent": 100 * values[0] / total
                if what in sinks and values[0] is not None
                else None,
            }
            for what, unit, values in lines
        ]
    names = [f"{k}: {r.name}" for k, r in enumerate(reports, start=1)]
    return [
        {"what": what, **dict(zip(names, values, strict=True)), "unit": unit}
        for what, unit, values in lines
    ]


def regime_table(reports: Sequence[EnergyReport]) -> list[dict[str, Any]]:
    """Return rows by kind of driving: time, distance, energy, share."""
    return [
        {
            "trace": report.name,
            "regime": r.name,
            "time_s": r.time_s,
            "distance_m": r.distance_m,
            "energy_wh": r.energy_wh,
            "share_percent": 100 * r.energy_wh / (report.energy_wh or 1.0),
        }
        for report in reports
        for r in report.regimes
    ]


def _percent(value: float | None, of: float | None) -> float | None:
    if value is None or not of:
        return None
    return 100 * (value - of) / abs(of)


def _per_km(report: EnergyReport, sink: str) -> float:
    km = report.distance_m / 1000
    return report.ledger.get(sink, 0.0) / km if km > 0 else 0.0
