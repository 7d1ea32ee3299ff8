"""Channels that were logged at rates of their own: a log on one of their clocks."""

from __future__ import annotations

import numpy as np

from rcc_sim.analyse.logcheck.finding import KINEMATIC, Array, Finding
from rcc_sim.readers import on_one_clock
from rcc_sim.trace import Trace

BLANK = 0.2
"""Share of rows without a value of the clock above which a log holds several."""


def one_clock(trace: Trace) -> tuple[Trace, tuple[Finding, ...]]:
    """Return rows of one clock, where channels came at rates of their own.

    The clock is the speed's; without a speed, that of the channel of motion with most
    rows. A log whose channels share their rows is returned as it is.

    Parameters
    ----------
    trace : Trace
        As read: a stamp of any channel is a row, blank where a channel has no value.

    Returns
    -------
    trace : Trace
        On one clock; see :func:`rcc_sim.readers.on_one_clock`.
    findings : tuple of Finding
        That there were several, and the rate of each channel; empty for one clock.
    """
    there = {
        name: np.isfinite(values)
        for name, values in trace.columns.items()
        if name != "time_s" and np.isfinite(values).any()
    }
    clocks = [name for name in KINEMATIC if name in there]
    if not clocks:
        return trace, ()
    clock = "speed_mps"
    if clock not in there:
        clock = max(clocks, key=lambda name: int(there[name].sum()))
    known = float(there[clock].mean())
    shared = [
        float(there[clock][mask].mean())
        for name, mask in there.items()
        if name != clock
    ]
    if known > 1 - BLANK or min(shared, default=1.0) > 1 - BLANK:
        return trace, ()
    rates: dict[str, list[str]] = {}
    for name, mask in there.items():
        rates.setdefault(_rate(trace["time_s"][mask]), []).append(name)
    each = "; ".join(f"{', '.join(names)}: {rate}" for rate, names in rates.items())
    found = Finding(
        "clocks",
        clock,
        f"channels come at rates of their own ({each})",
        action=f"looked at in the rows of {clock}; others held or interpolated there",
    )
    return on_one_clock(trace, clock), (found,)


def _rate(time: Array) -> str:
    steps = np.diff(time[np.isfinite(time)])
    steps = steps[steps > 0]
    return f"{1 / np.median(steps):.3g} Hz" if len(steps) else "once"
