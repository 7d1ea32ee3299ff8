"""The sheet that every plot is drawn on: its style, its axes, what is put on them."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from rcc_sim.report.lines import shown
from rcc_sim.trace import Trace

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.typing import RcKeyType

COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9")
"""Okabe-Ito, in an order that also differs in lightness."""

WIDE = 90
"""Letters that a line above a sheet may hold."""

DASHES = ("-", "--", "-.", ":")
POINTS = 4000
"""Points that a line is thinned to; each stretch keeps its least and its greatest."""

LONG = 22
"""Letters from which on the unit of an axis stands in a line of its own."""

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


def sheet(count: int, *, height: float, **options: Any) -> tuple[Figure, list[Axes]]:
    """Return a figure and its axes, one under the other, each of some height. [in]"""
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


def head(figure: Figure, *lines: str) -> None:
    """Put lines above a sheet, folded where they are too long for it."""
    folded = [part for line in lines for part in textwrap.wrap(line, WIDE) or [""]]
    figure.suptitle("\n".join(folded), x=0.02, ha="left")


def name_upright(axis: Axes, title: str) -> None:
    """Name an upright axis; the unit of a long title stands in a line of its own."""
    is_long = max(map(len, title.splitlines())) > LONG
    axis.set_ylabel(title.replace(" [", "\n[") if is_long else title)


def legend_above(axis: Axes, lines: Sequence[Any], names: Sequence[str]) -> None:
    """Put the legend above the axes, where it hides nothing."""
    axis.legend(
        lines,
        names,
        ncols=min(len(names), 3),
        frameon=False,
        loc="lower right",
        bbox_to_anchor=(1.0, 1.0),
    )


def draw_line(axis: Axes, trace: Trace, column: str, label: str, k: int) -> None:
    """Draw a column of a trace over time, in the k-th colour or as a reference."""
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
