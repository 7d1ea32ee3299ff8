"""Plots for papers and screens: units on every axis, safe for the colour-blind."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from rcc_sim.analyse.energy import EnergyReport, cumulative_distance, cumulative_energy
from rcc_sim.errors import InputError
from rcc_sim.files import atomic
from rcc_sim.report.channels import title_of
from rcc_sim.report.lines import extremes
from rcc_sim.report.sheet import (
    COLOURS,
    DASHES,
    POINTS,
    draw_line,
    head,
    legend_above,
    name_upright,
    sheet,
)
from rcc_sim.trace import Trace
from rcc_sim.units import J_PER_WH, unit_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

FORMATS = (".png", ".svg", ".pdf")

RUN_PANELS = (
    ("Speed", ("speed_mps", "speed_ref_mps"), ("driven", "reference")),
    ("Motor current", ("motor_current_a",), ("",)),
    ("Motor torque", ("motor_torque_nm",), ("",)),
    ("Battery power", ("battery_power_w",), ("",)),
    ("Battery current", ("battery_current_a",), ("",)),
    ("Battery voltage", ("battery_voltage_v",), ("",)),
    ("Steer", ("steer_cmd_rad",), ("",)),
    ("Yaw rate", ("yaw_rate_radps",), ("",)),
    ("Lateral place", ("y_m",), ("",)),
)

SAID_BY = {
    "Motor torque": "motor_current_a",
    "Battery current": "battery_power_w",
    "Battery voltage": "battery_power_w",
}
"""Panel -> the column that says as much, where a trace has it."""


def save(figure: Figure, path: Path) -> None:
    """Write a figure, whole or not at all; the suffix says how.

    Raises
    ------
    InputError
        If the suffix is not that of a picture, or the file cannot be written.
    """
    import io

    kind, picture = format_of(path), io.BytesIO()
    undated = {"png": {}, "svg": {"Date": None}, "pdf": {"CreationDate": None}}[kind]
    figure.savefig(picture, format=kind, metadata=undated, bbox_inches="tight")
    with atomic(path, "wb") as file:
        file.write(picture.getvalue())


def format_of(path: Path) -> str:
    """Return in what format a picture is written, by the suffix of its name.

    Raises
    ------
    InputError
        If the suffix is not that of a picture.
    """
    if path.suffix.lower() not in FORMATS:
        raise InputError(
            f"{path}: cannot draw into a {path.suffix or 'nameless'} file",
            f"name it {', '.join(f'*{f}' for f in FORMATS)}",
        )
    return path.suffix[1:].lower()


def plot_run(*traces: Trace, columns: Sequence[str] = ()) -> Figure:
    """Draw runs over time: speed, current, power, and steering where there is any.

    Parameters
    ----------
    traces : Trace
        The first is drawn on top.
    columns : sequence of str
        What to draw instead.

    Raises
    ------
    InputError
        If no trace has one of the columns.
    """
    panels = _asked_for(traces, columns) or [
        panel
        for panel in RUN_PANELS
        if any(panel[1][0] in t and np.any(t[panel[1][0]]) for t in traces)
        and SAID_BY.get(panel[0]) not in traces[0].columns
    ]
    figure, axes = sheet(len(panels), height=1.45, sharex=True)
    for axis, (title, names, labels) in zip(axes, panels, strict=True):
        for k, trace in enumerate(traces):
            for column, label in zip(names, labels, strict=True):
                if column in trace and not (k > 0 and label == "reference"):
                    draw_line(axis, trace, column, label, k)
        name_upright(axis, f"{title} [{unit_of(names[0])}]")
    if len(traces) == 1:
        legend_above(axes[0], *axes[0].get_legend_handles_labels())
    else:
        driven = [line for line in axes[0].lines if line.get_label() == "driven"]
        asked = [x for x in axes[0].lines if x.get_label() == "reference"]
        drives = [trace.name for trace in traces if panels[0][1][0] in trace]
        legend_above(axes[0], driven + asked, drives + ["reference"] * len(asked))
    axes[-1].set_xlabel("Time [s]")
    head(figure, traces[0].name if len(traces) == 1 else "")
    return figure


def _asked_for(
    traces: Sequence[Trace], columns: Sequence[str]
) -> list[tuple[str, tuple[str, ...], tuple[str, ...]]]:
    """Return a panel for each column; the first names the traces."""
    for column in columns:
        if not any(column in trace for trace in traces):
            raise InputError(
                f"--column {column}: {traces[0].name} does not have it",
                f"there are {', '.join(traces[0].columns)}",
            )
    return [
        (title_of(c), (c,), ("driven" if k == 0 else "",))
        for k, c in enumerate(columns)
    ]


def plot_energy(traces: Sequence[Trace], reports: Sequence[EnergyReport]) -> Figure:
    """Draw where the energy went: by sink, and along the way."""
    sinks = list(dict.fromkeys(sink for report in reports for sink in report.ledger))
    figure, (bars, way) = sheet(2, height=2.0 + 0.6 * len(reports))
    if sinks:
        _sink_bars(bars, sinks, reports)
    else:
        bars.text(0.5, 0.5, "a measured trace has no ledger", ha="center")
    for k, trace in enumerate(traces):
        distance = cumulative_distance(trace)
        energy = cumulative_energy(trace) / J_PER_WH
        colour, dash = COLOURS[k % len(COLOURS)], DASHES[k % len(DASHES)]
        x, y = extremes(distance - distance[0], energy - energy[0], POINTS)
        way.plot(x, y, label=reports[k].name, color=colour, ls=dash)
    way.set_xlabel("Distance [m]")
    way.set_ylabel("Battery energy [Wh]")
    way.legend(frameon=False)
    return figure


def _sink_bars(
    axis: Axes, sinks: Sequence[str], reports: Sequence[EnergyReport]
) -> None:
    height = 0.8 / len(reports)
    for k, report in enumerate(reports):
        km = max(report.distance_m, 1e-9) / 1000
        values = [report.ledger.get(sink, 0.0) / km for sink in sinks]
        places = np.arange(len(sinks)) + k * height
        colour = COLOURS[k % len(COLOURS)]
        drawn = axis.barh(places, values, height, color=colour, label=report.name)
        size = 8 if len(reports) < 3 else 6
        texts = [f"{value:.3g}" if value else "" for value in values]
        axis.bar_label(drawn, texts, padding=3, fontsize=size)
    axis.set_yticks(np.arange(len(sinks)) + 0.4 - height / 2)
    axis.set_yticklabels([sink.replace("_", " ") for sink in sinks])
    axis.invert_yaxis()
    axis.margins(x=0.12)
    axis.set_xlabel("Energy per distance [Wh/km]")
