"""A diagnosis drawn: measured, simulated as stated and mended, and what varies."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from rcc_sim.analyse.gap_energy import logged_power
from rcc_sim.diagnose.diagnosis import Diagnosis
from rcc_sim.report.diagnosis_page import mended
from rcc_sim.report.findings import Report
from rcc_sim.report.lines import Array, Line, shown
from rcc_sim.report.panels import Panel, charts_of
from rcc_sim.report.sheet import (
    COLOURS,
    POINTS,
    head,
    legend_above,
    name_upright,
    sheet,
)
from rcc_sim.report.text import probable, short
from rcc_sim.trace import integral_of
from rcc_sim.units import J_PER_WH

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

DRAWN: dict[str, dict[str, Any]] = {
    "m": {"label": "measured", "color": "#AAAAAA", "lw": 2.2},
    "b": {"label": "simulated as stated", "color": COLOURS[1], "lw": 0.9, "ls": "--"},
    "a": {"label": "mended", "color": COLOURS[0], "lw": 0.9},
}
"""Kind of line -> how it is drawn: the measured one wide and pale, under the others."""


def plot_diagnosis(found: Diagnosis, page: Report) -> Figure:
    """Draw what a page shows over time, below the energy gap as it adds up.

    Measured, simulated by the vehicle as it is stated, and once it is mended; of a
    cause that varies its course with a 90 % band. Stretches where most of the gap sits
    are shaded.
    """
    charts = charts_of(page)
    since = charts is not None and charts.since_start
    panels = [p for p in charts.panels if p.place == "time"] if charts else []
    panels = [*_energy_gap(found, since_start=since), *panels]
    figure, axes = sheet(max(len(panels), 1), height=1.45, sharex=True)
    for axis, panel in zip(axes, panels, strict=False):
        _draw(axis, panel)
    told = {
        line.get_label(): line for axis in axes for line in reversed(axis.get_lines())
    }
    names = [how["label"] for how in DRAWN.values() if how["label"] in told]
    legend_above(axes[0], [told[name] for name in names], names)
    axes[-1].set_xlabel("Time since the log's start [s]" if since else "Time [s]")
    head(figure, _title(found))
    return figure


def _energy_gap(found: Diagnosis, *, since_start: bool) -> list[Panel]:
    """Return how far measured energy has run off the simulated one, up to each row."""
    gap = found.gap
    power, time = logged_power(gap.measured), gap.measured["time_s"]
    if power is None or "battery_power_w" not in gap.simulated:
        return []

    def off(simulated: Array) -> Array:
        missed = np.nan_to_num(power - simulated)
        return integral_of(time, missed) / J_PER_WH

    start = float(time[0]) if since_start else 0.0
    both = {"b": gap.simulated, "a": mended(found)}
    lines = (
        Line(kind, kind, time - start, off(part["battery_power_w"]))
        for kind, part in both.items()
    )
    return [Panel("gap", "Energy gap [Wh]", "Wh", tuple(lines))]


def _draw(axis: Axes, panel: Panel) -> None:
    found = [line for line in panel.lines if line.kind not in DRAWN]
    for line in panel.lines:
        if line.kind in DRAWN:
            x, y = shown(line.x, line.y, POINTS)
            axis.plot(x, y, **DRAWN[line.kind])
    if found:  # the ends of a profile's band
        low, high = (line.y for line in found)
        colour = DRAWN["a"]["color"]
        axis.fill_between(found[0].x, low, high, color=colour, alpha=0.25, lw=0)
    for span in panel.flagged:
        axis.axvspan(span.start_s, span.end_s, color=COLOURS[4], alpha=0.15, lw=0)
    name_upright(axis, panel.title.removeprefix("Found: ").replace(", ", ",\n"))


def _title(found: Diagnosis) -> str:
    """Return what was found, in a line."""
    of = f"{short(found.gap.log)} against {found.gap.vehicle}"
    causes = [
        f"{' or '.join((a.cause.effect, *a.cause.tied))} {probable(a.probability)}"
        for a in found.asserted
    ]
    return f"{of}: {', '.join(causes) or found.status.replace('_', ' ')}"
