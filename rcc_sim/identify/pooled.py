"""Several logs of one vehicle, one after another, as one."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from rcc_sim.errors import InputError
from rcc_sim.identify.series import Array
from rcc_sim.trace import Trace

APART = 60.0
"""Time between one log and the next, by which nothing runs across. [s]"""


@dataclass(frozen=True)
class Pooled:
    """Rows of several logs on one clock that only grows.

    Parameters
    ----------
    columns : dict of ndarray, shape (n,)
        ``time_s`` and the wanted columns that every log has.
    names : tuple of str
        Of the logs.
    starts, offsets : ndarray, shape (logs,)
        First time of each log on this clock, and what was added to its own. [s]
    """

    columns: dict[str, Array]
    names: tuple[str, ...]
    starts: Array
    offsets: Array

    def own(self, time: float) -> tuple[str, float]:
        """Return the log and the time in it of a time on this clock. [s]"""
        k = int(np.searchsorted(self.starts, time, side="right")) - 1
        return self.names[k], time - float(self.offsets[k])


def pooled(traces: Sequence[Trace], wanted: Sequence[str]) -> Pooled:
    """Put logs one after another, :data:`APART` seconds between them.

    A log alone keeps its own times.

    Parameters
    ----------
    traces : sequence of Trace
        At least one; time increases.
    wanted : sequence of str
        Columns to keep where every log has a value of them.

    Raises
    ------
    InputError
        If a log has no speed; says which.
    """
    for trace in traces:
        if not trace.has("speed_mps"):
            there = ", ".join(trace.columns)
            raise InputError(f"{trace.name}: no column speed_mps", f"there are {there}")
    kept = [name for name in wanted if all(trace.has(name) for trace in traces)]
    columns: dict[str, list[Array]] = {name: [] for name in ("time_s", *kept)}
    offsets, starts = [], []
    end = 0.0
    for k, trace in enumerate(traces):
        time = trace["time_s"]
        known = time[np.isfinite(time)]
        if not len(known):
            raise InputError(f"{trace.name}: time_s: no row has a time")
        offset = 0.0 if k == 0 else end + APART - float(known[0])
        offsets.append(offset)
        starts.append(float(known[0]) + offset)
        end = float(known[-1]) + offset
        columns["time_s"].append(time + offset)
        for name in kept:
            columns[name].append(np.asarray(trace[name], dtype=float))
    return Pooled(
        {name: np.concatenate(parts) for name, parts in columns.items()},
        tuple(trace.name for trace in traces),
        np.array(starts),
        np.array(offsets),
    )
