"""Figures for papers: cycles at both sizes, two sizes in one, and where a gap sits."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from rcc_sim.definitions.cycle import Cycle
from rcc_sim.errors import InputError
from rcc_sim.report.lines import extremes
from rcc_sim.report.sheet import (
    COLOURS,
    DASHES,
    POINTS,
    head,
    legend_above,
    name_upright,
    sheet,
)
from rcc_sim.report.text import percent
from rcc_sim.similitude.dimensionless import DimensionlessTrace

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

OVERLAID = {
    "pi_9_speed": "π₉, speed",
    "pi_2_accel_x": "π₂, acceleration",
    "pi_motor_torque": "motor force over C_F",
    "pi_steer_cmd": "steering",
    "pi_11_yaw_rate": "π₁₁, yaw rate",
}
"""Dimensionless column -> what its axis is called; all of them are [1]."""


SLIGHT = 0.01
"""Share of the longest bar below which one is hardly seen."""


def plot_cycles(actual: Cycle, scaled: Cycle, names: tuple[str, str]) -> Figure:
    """Draw a cycle as it is and at the other vehicle's size: together, then alone."""
    figure, (both, alone) = sheet(2, height=1.9)
    for k, (cycle, name) in enumerate(zip((actual, scaled), names, strict=True)):
        x, y = extremes(cycle.time_s, cycle.speed_mps, POINTS)
        for axis in (both, alone)[: k + 1]:
            axis.plot(x, y, color=COLOURS[k], ls=DASHES[0], lw=1.0, label=name)
            axis.set_xlim(left=cycle.time_s[0])
    for axis in (both, alone):
        axis.set_ylabel("Speed [m/s]")
        axis.set_ylim(bottom=0)
    alone.set_xlabel("Time [s]")
    legend_above(both, both.lines, list(names))
    return figure


def plot_overlay(runs: Mapping[str, DimensionlessTrace]) -> Figure:
    """Draw drives of several sizes over each other, without dimensions.

    Raises
    ------
    InputError
        If they have no column in common, or none that it draws.
    """
    columns = [
        column
        for column in OVERLAID
        if all(column in run.columns for run in runs.values())
        and any(np.nan_to_num(run.columns[column]).any() for run in runs.values())
    ]
    if not columns:
        raise InputError(
            "the traces have no column in common that can be drawn",
            "speed_mps, accel_x_mps2, motor_torque_nm, steer_cmd_rad, yaw_rate_radps",
        )
    figure, axes = sheet(len(columns), height=1.6, sharex=True)
    for axis, column in zip(axes, columns, strict=True):
        for k, run in enumerate(runs.values()):
            time, values = run.columns["pi_8_time"], run.columns[column]
            x, y = extremes(time - time[0], values, POINTS)
            colour, dash = COLOURS[k % len(COLOURS)], DASHES[k % len(DASHES)]
            axis.plot(x, y, color=colour, ls=dash, lw=1.1)
        name_upright(axis, f"{OVERLAID[column]} [1]")
    legend_above(axes[0], axes[0].lines, list(runs))
    axes[-1].set_xlabel("π₈, time [1]")
    figure.align_ylabels(axes)
    return figure


def plot_gap(found: Mapping[str, Any]) -> Figure:
    """Draw where a gap sits: from simulated to measured, by regime and by stage.

    Raises
    ------
    InputError
        If the object is none that `gap --json` or `diagnose --json` prints.
    """
    where = found.get("where", found)
    if not isinstance(where, Mapping) or not isinstance(where.get("regimes"), list):
        raise InputError(
            "not a gap: where.regimes: missing", "write it with `rccsim gap LOG --json`"
        )
    kinds = [
        (kind, word, where[kind])
        for kind, word in (("regimes", "regime"), ("stages", "stage"))
        if where.get(kind)
    ]
    if not kinds:
        raise InputError("where.regimes: empty; there is nothing to draw")
    heights = [max(len(rows), 2) for _, _, rows in kinds]
    figure, axes = sheet(
        len(kinds),
        height=0.45 + 0.28 * max(heights),
        height_ratios=heights,
        sharex=True,
    )
    for axis, (_, word, rows) in zip(axes, kinds, strict=True):
        _gap_bars(axis, word, rows)
    axes[-1].set_xlabel("Gap, measured − simulated [Wh]")
    energy = where.get("energy") or {}
    told = []
    if where.get("log") and where.get("vehicle"):
        told.append(f"{where['log']} against {where['vehicle']}")
    if energy.get("gap_wh") is not None and energy.get("gap_percent") is not None:
        gap = f"{energy['gap_wh']:+.3g} Wh, {energy['gap_percent']:+.3g} % of measured"
        doubt = energy.get("u_val_wh")
        told.append(gap if doubt is None else f"{gap}; u_val {doubt:.2g} Wh")
    head(figure, *told)
    return figure


def _gap_bars(axis: Axes, word: str, rows: Sequence[Mapping[str, Any]]) -> None:
    try:
        names = [str(row[word]).replace("_", " ") for row in rows]
        gaps = [float(row["gap_wh"] or 0.0) for row in rows]
        shares = [row.get("share") for row in rows]
    except (KeyError, TypeError, ValueError, AttributeError):
        raise InputError(
            f"not a gap: each {word} should have a name and gap_wh"
        ) from None
    places = np.arange(len(rows))
    colours = [COLOURS[1] if gap >= 0 else COLOURS[0] for gap in gaps]
    axis.barh(places, gaps, 0.7, color=colours)
    least = -SLIGHT * max(map(abs, gaps), default=0.0)
    for place, gap, share in zip(places, gaps, shares, strict=True):
        right = gap >= least  # of a bar that is hardly one, too: names are at the left
        axis.annotate(
            "" if share is None else percent(share),
            (gap, place),
            xytext=(3 if right else -3, 0),
            textcoords="offset points",
            ha="left" if right else "right",
            va="center",
            fontsize=8,
        )
    axis.axvline(0.0, color="#555555", lw=0.8)
    axis.set_yticks(places, names)
    axis.set_ylabel(f"By {word}")
    axis.invert_yaxis()
    axis.margins(x=0.14)
