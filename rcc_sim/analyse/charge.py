"""Power at the battery from its state of charge, where no other column tells it.

A state of charge comes in steps. Between two rows some steps apart it tells the mean
power in between, the better the more steps they are.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from rcc_sim.analyse.gap_replays import Tolerances, toleranced
from rcc_sim.definitions.vehicle import Vehicle
from rcc_sim.trace import Trace

Array = NDArray[np.float64]
Rows = NDArray[np.intp]

COLUMN, POWER = "state_of_charge_percent", "battery_power_w"

STEPS = 4
"""Steps that the charge falls by in a typical stretch: rounding, which moves either
end by a uniform part of a step, is then 10 % of its energy.

Of 2, 3, 4, 6, 10 and 20 steps, 3 and 4 gain most nats for the roads of measured trips.
"""

FEWEST = 12
"""Stretches below which a log tells nothing by its charge."""

ROUNDING = 1e-6
"""Difference below which two states of charge [%], or two times [s], are the same."""


@dataclass(frozen=True)
class Charge:
    """Mean power over stretches of a log, from its state of charge.

    Parameters
    ----------
    edges : ndarray of int, shape (k + 1,)
        Rows between which the stretches lie.
    time : ndarray, shape (n,)
        Of the log's rows. [s]
    power : ndarray, shape (k,)
        Mean power of each stretch, NaN where the charge jumped. [W]
    noise : ndarray, shape (k,)
        Standard deviation of it that rounding leaves. [W]
    """

    edges: Rows
    time: Array
    power: Array
    noise: Array

    def means(self, x: Array) -> Array:
        """Mean per stretch of what is known per row as a mean since the row before."""
        known = np.isfinite(x)
        spans = np.where(known, np.diff(self.time, prepend=self.time[0]), 0.0)
        flown = np.diff(np.cumsum(np.where(known, x, 0.0) * spans)[self.edges])
        whole = np.diff(np.cumsum(spans)[self.edges])
        out = np.full(len(whole), np.nan)
        np.divide(flown, whole, out=out, where=whole > 0)
        return out

    def held(self, x: Array) -> Array:
        """What is known per stretch, at each of its rows; NaN outside all of them."""
        which = np.searchsorted(self.edges, np.arange(len(self.time))) - 1
        inside = (which >= 0) & (which < len(x))
        return np.where(inside, x[np.clip(which, 0, len(x) - 1)], np.nan)

    def noise_of(self, residual: Array) -> float:
        """Noise of the power [W]: by rounding, or by how its residual scatters."""
        e = residual[self.edges[1:]]
        change = np.diff(e[np.isfinite(e)])
        scatter = float(np.median(np.abs(change))) / 2**0.5 if len(change) else 0.0
        return max(float(np.median(self.noise)), 1.4826 * scatter)

    def as_known(self, columns: dict[str, Array]) -> dict[str, Array]:
        """Columns of a run, its power held at its mean over each stretch."""
        return {**columns, POWER: self.at_rows(columns[POWER])}

    def at_rows(self, x: Array) -> Array:
        """Mean per stretch, held at each of its rows."""
        return self.held(self.means(x))

    def shifts(self, moved: Array) -> Array:
        """The same of what tolerances move, unless it is known on some rows alone."""
        if moved.shape[-1] < len(self.time):
            return moved
        return np.array([self.at_rows(x) for x in moved])

    def tolerances(self, moved: Tolerances, vehicle: Vehicle) -> Tolerances:
        """Tolerances of a run whose power is known per stretch.

        The battery's energy moves what was measured, so the other way round.
        """
        if len(moved.rows) < len(self.time):
            return moved
        shifts = self.shifts(moved.moved[POWER])
        for key, (value, sd) in toleranced(vehicle).items():
            if key in vehicle.battery_energy_of:
                drawn = self.held(self.power) * sd / value
                shifts[moved.keys.index(key)] -= drawn
        return replace(moved, moved={**moved.moved, POWER: shifts})


def charge_of(log: Trace, vehicle: Vehicle) -> Charge | None:
    r"""Return the power that a log's state of charge tells, if nothing else does.

    .. math:: \bar P = -\frac{E}{100} \frac{\Delta s}{\Delta t}

    with E the energy of the full battery [J] and s the state of charge [%]. A stretch
    is as long as the charge takes to fall by some of its steps; one in which it jumps
    by as much between two rows is left out.
    """
    energy = vehicle.battery_energy
    if energy is None or not log.has(COLUMN) or log.has(POWER):
        return None
    if log.has("battery_current_a"):
        return None
    time, charge = log["time_s"], log[COLUMN]
    known = np.flatnonzero(np.isfinite(charge))
    steps = np.abs(np.diff(charge[known]))
    moved = steps > ROUNDING
    fallen = abs(float(charge[known[0]] - charge[known[-1]]))
    if not moved.any() or fallen == 0:
        return None
    step = float(np.quantile(steps[moved], 0.1))
    count = min(int(fallen / (STEPS * step)), len(known) // 2)
    if count < FEWEST:
        return None
    at = np.linspace(time[known[0]], time[known[-1]], count + 1)
    near = np.searchsorted(time[known], at - ROUNDING)
    edges = np.unique(known[np.clip(near, 0, len(known) - 1)])
    seconds = np.diff(time[edges])
    watts = energy / 100 / seconds
    power = -np.diff(charge[edges]) * watts
    jumped = known[1:][steps > STEPS * step]
    power[np.clip(np.searchsorted(edges, jumped) - 1, 0, len(power) - 1)] = np.nan
    return Charge(edges, time, power, watts * step / 6**0.5)
