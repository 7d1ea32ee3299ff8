"""Plots for papers and screens: units on every axis, safe for the colour-blind."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from rcc_sim.analyse.energy import EnergyReport, cumulative_distance, cumulative_energy
from rcc_sim.errors import InputError
from rcc_sim.files import atomic
from rcc_sim.report.channels import title_of
from rcc_sim.report.lines import extremes, shown
from rcc_sim.trace import Trace
from rcc_sim.units import J_PER_WH, unit_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.typing import RcKeyType

COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9")
"""Okabe-Ito, in an order that also differs in lightness."""

DASHES = ("-", "--", "-.", ":")
FORMATS = (".png", ".svg", ".pdf")
POINTS = 4000
"""Points that a line is thinned to; each stretch keeps its least and its greatest."""

STYLE: dict[RcKeyType, Any] = {
    "figure.dpi": 110,
    "savefig.dpi": 200,
    "font.size": 9,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "grid.alpha": 0.25,
    "svg.hashsalt": "rccsim",
    "text.parse_math": False,
}

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
    figure, axes = _sheet(len(panels), height=1.45, sharex=True)
    for axis, (title, names, labels) in zip(axes, panels, strict=True):
        for k, trace in enumerate(traces):
            for column, label in zip(names, labels, strict=True):
                if column in trace and not (k > 0 and label == "reference"):
                    _line(axis, trace, column, label, k)
        axis.set_ylabel(f"{title} [{unit_of(names[0])}]")
    if len(traces) == 1:
        _legend_above(axes[0], *axes[0].get_legend_handles_labels())
    else:
        driven = [line for line in axes[0].lines if line.get_label() == "driven"]
        asked = [x for x in axes[0].lines if x.get_label() == "reference"]
        drives = [trace.name for trace in traces if panels[0][1][0] in trace]
        _legend_above(axes[0], driven + asked, drives + ["reference"] * len(asked))
    axes[-1].set_xlabel("Time [s]")
    figure.suptitle(traces[0].name if len(traces) == 1 else "", x=0.02, ha="left")
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
    figure, (bars, way) = _sheet(2, height=2.0 + 0.6 * len(reports))
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


def _legend_above(axis: Axes, lines: Sequence[Any], names: Sequence[str]) -> None:
    """Put the legend above the axes, where it hides nothing."""
    axis.legend(
        lines,
        names,
        ncols=min(len(names), 3),
        frameon=False,
        loc="lower right",
        bbox_to_anchor=(1.0, 1.0),
    )


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


def _line(axis: Axes, trace: Trace, column: str, label: str, k: int) -> None:
    x, y = shown(trace["time_s"], trace[column], POINTS)
    reference = label == "reference"
    axis.plot(
        x,
        y,
        label=label or None,
        color="#555555" if reference else COLOURS[k % len(COLOURS)],
        ls="--" if reference else "-",
        lw=0.9,
        zorder=2.9 - 0.1 * k,  # the first on top: the others show where they differ
    )


def _sheet(count: int, *, height: float, **options: Any) -> tuple[Figure, list[Axes]]:
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    plt.rcParams.update(STYLE)
    figure, axes = plt.subplots(
        count,
        1,
        figsize=(7.2, 0.8 + height * count),
        layout="constrained",
        squeeze=False,
        **options,
    )
    return figure, list(axes[:, 0])
