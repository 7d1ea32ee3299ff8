"""What the figures of a run may be off by, given what the vehicle's file admits."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rcc_sim.analyse.energy import EnergyReport, battery_capacity
from rcc_sim.batch.batch import rows_of
from rcc_sim.batch.draws import Method, file_draws, spread_of, uncertain_figures
from rcc_sim.batch.engine import Engine
from rcc_sim.batch.plan import Axis, Plan
from rcc_sim.batch.runs import Manoeuvre, Sweep
from rcc_sim.definitions.cycle import Cycle
from rcc_sim.definitions.vehicle import Vehicle
from rcc_sim.errors import InputError
from rcc_sim.trace import Trace

Array = NDArray[np.float64]

LEVELS = (0.05, 0.95)
"""Ends of the intervals: nine draws of ten lie between."""

INPUTS = ("run", "error", "ledger_left_open")


@dataclass(frozen=True)
class Spread:
    """A figure, and where it lies over the draws.

    Parameters
    ----------
    value : float
        Of the vehicle as its file states it.
    sd, low, high : float
        Standard deviation, and the 5 % and 95 % points, of the draws.
    """

    value: float
    sd: float
    low: float
    high: float


@dataclass(frozen=True)
class Draws:
    """Figures over draws.

    Parameters
    ----------
    keys : tuple of str
        What was drawn.
    count, failed : int
        Draws, and those among them that no vehicle could be.
    spreads : dict
        Figure -> spread.
    """

    keys: tuple[str, ...]
    count: int
    failed: int
    spreads: dict[str, Spread]


def drawn_run(
    vehicle: Vehicle,
    cycle: Cycle,
    how: Manoeuvre,
    draws: int,
    *,
    method: Method = "lhs",
    seed: int = 0,
    engine: Engine | None = None,
) -> Draws:
    """Return the interval of every figure of a run.

    Parameters
    ----------
    vehicle, cycle, how
        The run.
    draws, method, seed
        How many draws, how, and from which seed.

    Raises
    ------
    InputError
        If the file states no sd and no range of anything that acts.
    """
    keys, _, columns = _drawn(vehicle, cycle, how, draws, method, seed, engine)
    names = [name for name in columns if name not in (*INPUTS, *keys)]
    spreads = {
        name: spread(float(columns[name][0]), columns[name][1:])
        for name in names
        if np.any(columns[name] != 0)
    }
    return _summed(keys, columns, spreads)


def drawn_energy(
    vehicle: Vehicle,
    trace: Trace,
    report: EnergyReport,
    draws: int,
    *,
    method: Method = "lhs",
    seed: int = 0,
) -> Draws:
    """Return the interval of every figure of a simulated trace's energy report.

    Each draw is driven along the trace, its speed, yaw rate, slope and logged
    auxiliaries imposed; what the draws differ by from the vehicle as stated, driven
    likewise, is laid about the trace's own figures.

    Raises
    ------
    InputError
        If the trace was measured, so that its energy does not hang on the file.
    """
    if not report.ledger:
        raise InputError(
            f"{trace.name}: --draws: a measured energy does not hang on the vehicle's "
            "file",
            "`rccsim simulate --draws` gives what the file predicts",
        )
    speed = np.maximum(trace["speed_mps"], 0.0)
    cycle = Cycle(trace.name, trace["time_s"], speed)
    how = Manoeuvre(
        imposed=True,
        yaw_rate=trace.columns.get("yaw_rate_radps"),
        slope=_road(trace),
        aux_power=_logged(trace, "aux_power_w"),
    )
    keys, values, columns = _drawn(
        vehicle, cycle, how, draws, method, seed, None, beside=vehicle.battery_energy_of
    )
    stated = {"energy_wh": report.energy_wh, "wh_per_km": report.wh_per_km}
    stated |= {f"energy_{sink}_wh": wh for sink, wh in report.ledger.items()}
    spreads = {}
    for name, own in stated.items():
        if own is not None and name in columns:
            off = columns[name] - columns[name][0]
            spreads[name] = spread(own, own + off[1:])
    if report.wh_per_km is not None and vehicle.battery.capacity_ah is not None:
        per_km = report.wh_per_km + columns["wh_per_km"] - columns["wh_per_km"][0]
        capacity = battery_capacity(vehicle) * _relative(vehicle, keys, values)
        reach = np.where(per_km > 0, capacity / per_km, np.nan)
        spreads["range_km"] = spread(float(reach[0]), reach[1:])
    return _summed(keys, columns, spreads)


def paired_change(
    vehicle: Vehicle,
    cycle: Cycle,
    how: Manoeuvre,
    axis: Axis,
    draws: int,
    *,
    seed: int = 0,
    engine: Engine | None = None,
) -> list[dict[str, float]]:
    """Return what each value of a key costs against its first, draw by draw.

    Each draw of the vehicle drives every value, so that what is not known about the
    vehicle cancels as far as it acts on both alike.

    Returns
    -------
    rows : list of dict
        A row a value after the first: Wh/km more in percent, median and interval, for
        the vehicle as stated, and the interval of the two consumptions themselves.
    """
    figures = uncertain_figures(vehicle, commanded=not how.imposed, fixed=(axis.key,))
    keys, values = file_draws(vehicle, draws, "lhs", seed, figures)
    stated = np.array([[figures[key].value for key in keys]])
    plan = Plan((axis,), keys, np.concatenate([stated, values]))
    sweep = Sweep(vehicle, cycle, plan, how)
    sweep.check()
    columns = _columns(sweep, engine)
    table = columns["wh_per_km"].reshape(len(axis.values), -1)
    rows = []
    for k in range(1, len(table)):
        more = 100 * (table[k] / table[0] - 1)
        found = spread(float(more[0]), more[1:])
        alone = spread(float(table[k][0]), table[k][1:])
        rows.append(
            {
                axis.key: axis.values[k],
                "wh_per_km_percent": found.value,
                "low": found.low,
                "high": found.high,
                "sd": found.sd,
                "wh_per_km": alone.value,
                "wh_per_km_low": alone.low,
                "wh_per_km_high": alone.high,
            }
        )
    return rows


def spread(value: float, draws: Array) -> Spread:
    """Return the spread of a figure over draws; those that failed are NaN."""
    good = draws[np.isfinite(draws)]
    if not len(good):
        return Spread(value, float("nan"), float("nan"), float("nan"))
    low, high = (float(end) for end in np.quantile(good, LEVELS))
    return Spread(value, float(good.std(ddof=min(1, len(good) - 1))), low, high)


def rows(draws: Draws) -> list[dict[str, Any]]:
    """Return the table: a figure a row; its unit is the end of its name."""
    return [
        {
            "what": name,
            "value": s.value,
            "low": s.low,
            "high": s.high,
            "sd": s.sd,
        }
        for name, s in draws.spreads.items()
    ]


def document(draws: Draws) -> dict[str, Any]:
    """Return what ``--json`` holds of the draws."""
    return {
        "count": draws.count,
        "failed": draws.failed,
        "drawn": list(draws.keys),
        "interval": list(LEVELS),
        "figures": {
            name: {"value": s.value, "sd": s.sd, "low": s.low, "high": s.high}
            for name, s in draws.spreads.items()
        },
    }


def _drawn(
    vehicle: Vehicle,
    cycle: Cycle,
    how: Manoeuvre,
    draws: int,
    method: Method,
    seed: int,
    engine: Engine | None,
    beside: Sequence[str] = (),
) -> tuple[tuple[str, ...], Array, dict[str, Array]]:
    """Return keys, values and result columns; the first row is the file as stated."""
    figures = uncertain_figures(vehicle, commanded=not how.imposed)
    for key in beside:
        figure = vehicle.figures().get(key)
        if figure is not None and (figure.sd > 0 or spread_of(figure) > 0):
            figures[key] = figure
    keys, values = file_draws(vehicle, draws, method, seed, figures)
    stated = np.array([[figures[key].value for key in keys]])
    plan = Plan((), keys, np.concatenate([stated, values]))
    sweep = Sweep(vehicle, cycle, plan, how)
    sweep.check()
    return keys, plan.draws, _columns(sweep, engine)


def _columns(sweep: Sweep, engine: Engine | None) -> dict[str, Array]:
    """Return the figures of every run as columns; NaN where a run failed.

    Raises
    ------
    InputError
        If the vehicle as stated fails.
    """
    import pyarrow

    table = pyarrow.concat_tables(rows_of(sweep, engine))
    first = table["error"][0].as_py()
    if first is not None:
        raise InputError(first)
    return {
        name: table[name].to_numpy().astype(float)
        for name in table.column_names
        if name != "error"
    }


def _summed(
    keys: tuple[str, ...], columns: Mapping[str, Array], spreads: dict[str, Spread]
) -> Draws:
    failed = int(np.isnan(columns["energy_wh"]).sum())
    return Draws(keys, len(columns["run"]) - 1, failed, spreads)


def _relative(vehicle: Vehicle, keys: tuple[str, ...], values: Array) -> Array:
    """Return the battery's energy in each draw over that which the file states."""
    whole = np.ones(len(values))
    for key in vehicle.battery_energy_of:
        if key in keys:
            column = values[:, keys.index(key)]
            whole = whole * column / column[0]
    return whole


def _road(trace: Trace) -> tuple[Array, Array] | None:
    if "slope" not in trace:
        return None
    distance = trace["distance_m"]
    moved = np.concatenate([[True], np.diff(distance) > 0])
    return distance[moved], trace["slope"][moved]


def _logged(trace: Trace, name: str) -> tuple[Array, Array] | None:
    return (trace["time_s"], trace[name]) if name in trace else None
