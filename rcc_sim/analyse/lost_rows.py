"""Rows that a logger lost, while the vehicle was commanded as ever.

A command that holds from row to row changed in them as in all others: to let the last
one that was logged hold on would be a command that comes late, some hundred nats of it
where twenty rows of seven thousand are lost. And what a meter averages, it averages
since the row before, whether that arrived or not.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from rcc_sim.analyse.logcheck.timebase import loses_rows, may_be_a_pause
from rcc_sim.channel import interval_of
from rcc_sim.definitions.vehicle import Vehicle
from rcc_sim.simulate.drive import has_commands
from rcc_sim.trace import Trace

NEAR = 0.25
"""Rows by which a step of the clock may be off a whole number of them."""

SELDOM = 0.1
"""Share of the steps of a clock that are longer, below which rows were lost; a logger
that writes what changes has such steps all along, and loses none."""


def with_lost_rows(log: Trace, vehicle: Vehicle) -> Trace:
    """Return a commanded log with the rows that its clock shows to be lost, empty.

    Commands are bridged there like others that are not known, and nothing is compared.
    """
    if not has_commands(log, vehicle) or len(log) < 2:
        return log
    time = log["time_s"]
    row, steps = interval_of(time), np.diff(time)
    whole = np.round(steps / row)
    lost = (whole > 1) & (np.abs(steps / row - whole) < NEAR)
    lost &= ~may_be_a_pause(steps, row)
    if not 0 < np.mean(lost) < SELDOM or not loses_rows(steps / row):
        return log
    each = np.where(lost, whole, 1.0).astype(int)
    first = np.concatenate([[0], np.cumsum(each)])  # where the rows that came stand now
    filled = {name: np.full(first[-1] + 1, np.nan) for name in log.columns}
    for name, values in log.columns.items():
        filled[name][first] = values
    filled["time_s"] = np.interp(np.arange(first[-1] + 1), first, time)
    return replace(log, columns=filled)
