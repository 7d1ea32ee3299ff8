"""A gap drawn: measured and simulated, channel by channel, regimes shaded."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from rcc_sim.analyse.gap import Gap
from rcc_sim.analyse.gap_regimes import REGIMES
from rcc_sim.analyse.logcheck.finding import runs
from rcc_sim.channel import interval_of
from rcc_sim.report.channels import title_of
from rcc_sim.report.lines import shown
from rcc_sim.report.sheet import COLOURS, POINTS, head, name_upright, sheet
from rcc_sim.simulate.smooth import HOLE
from rcc_sim.units import unit_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

SHADES = {
    "standstill": "#bbbbbb",
    "launch": "#E69F00",
    "acceleration": "#F0E442",
    "coast": "#56B4E9",
    "braking": "#0072B2",
    "corner_entry": "#CC79A7",
    "corner_mid": "#CC79A7",
    "corner_exit": "#CC79A7",
}
"""Regime -> colour behind the lines; cruising has none."""

MOST = 400
"""Stretches that are shaded; of a longer drive the longest."""


def plot_gap(gap: Gap) -> Figure:
    """Draw what was measured and simulated over time, a panel a channel."""
    figure, axes = sheet(max(len(gap.channels), 1), height=1.45, sharex=True)
    time = gap.measured["time_s"]
    for axis, channel in zip(axes, gap.channels, strict=False):
        name = channel.channel
        both = (("measured", gap.measured[name]), ("simulated", gap.simulated[name]))
        for k, (label, values) in enumerate(both):
            x, y = shown(time, values, POINTS)
            axis.plot(x, y, label=label, color=COLOURS[k], lw=0.9, zorder=2.5)
        name_upright(axis, f"{title_of(name)} [{unit_of(name)}]")
        _shade(axis, gap)
    handles, names = axes[0].get_legend_handles_labels()
    axes[0].legend(
        handles,
        names,
        ncols=4,
        frameon=False,
        loc="lower right",
        bbox_to_anchor=(1.0, 1.0),
    )
    axes[-1].set_xlabel("Time [s]")
    head(figure, f"{gap.log} against {gap.vehicle}")
    return figure


def _shade(axis: Axes, gap: Gap) -> None:
    time = gap.measured["time_s"]
    after = np.minimum(np.append(time[1:], time[-1]), time + HOLE * interval_of(time))
    stretches = []
    for k, regime in enumerate(REGIMES):
        if regime in SHADES:
            starts, ends = runs(gap.kinds == k)
            stretches += [
                (after[b - 1] - time[a], time[a], SHADES[regime], regime)
                for a, b in zip(starts, ends, strict=True)
            ]
    stretches.sort(key=lambda s: -s[0])
    named: set[str] = set()
    for lasts, start, colour, regime in stretches[:MOST]:
        label = regime.split("_")[0]
        axis.axvspan(
            start,
            start + lasts,
            color=colour,
            alpha=0.25,
            lw=0,
            zorder=0,
            label=None if label in named else label,
        )
        named.add(label)
    axis.set_xlim(float(np.min(time)), float(np.max(time)))
