"""A motor map as a picture."""

from __future__ import annotations

from typing import IO, TYPE_CHECKING

import numpy as np

from rcc_sim.errors import InputError
from rcc_sim.similitude.motor_map import MotorMap
from rcc_sim.similitude.overlay import Overlay

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.collections import QuadMesh

LEVELS = (0.3, 0.5, 0.6, 0.7, 0.75, 0.8, 0.85, 0.9, 0.925, 0.95)  # 1; labelled contours
SUFFIXES = (".png", ".svg", ".pdf")


def picture_format(name: str) -> str:
    """Return the format that a file's name asks for.

    Raises
    ------
    InputError
        If its ending is none of `SUFFIXES`.
    """
    ending = next((s for s in SUFFIXES if name.lower().endswith(s)), None)
    if ending is None:
        raise InputError(f"--plot {name}: should end in {', '.join(SUFFIXES)}")
    return ending[1:]


def draw(result: MotorMap, file: IO[bytes], picture: str) -> None:
    """Draw the map, its envelope and the scaled one to an open file."""
    from matplotlib import rc_context
    from matplotlib.figure import Figure

    figure = Figure(figsize=(7, 4.5), layout="constrained")
    axes = figure.add_subplot()
    figure.colorbar(_efficiency(axes, result), ax=axes, label="efficiency [1]")
    own = result.envelope.torque_at(result.speed)
    limit = f"limit of {result.vehicle}"
    axes.plot(result.speed, own, color="#D55E00", linewidth=2, label=limit)
    if result.against is not None:
        _other(axes, result.against)
    axes.set_xlabel("shaft speed [rad/s]")
    axes.set_ylabel("motor torque [N m]")
    axes.set_ylim(bottom=0)
    axes.set_title(f"{result.vehicle}: motor efficiency, {result.made_of}")
    axes.legend(loc="upper right", fontsize=8)
    stamp = {"svg": {"Date": None}, "pdf": {"CreationDate": None}}.get(picture, {})
    with rc_context({"svg.hashsalt": "rccsim"}):  # the same bytes each time
        figure.savefig(file, format=picture, dpi=150, metadata=stamp)


def _efficiency(axes: Axes, result: MotorMap) -> QuadMesh:
    filled = axes.pcolormesh(
        result.speed,
        result.torque,
        np.ma.masked_invalid(result.efficiency),
        shading="gouraud",
        cmap="cividis",
        vmin=0,
        vmax=1,
        rasterized=True,
    )
    lines = axes.contour(
        result.speed,
        result.torque,
        result.efficiency,
        levels=LEVELS,
        colors="black",
        linewidths=0.7,
    )
    axes.clabel(lines, fmt="%g", fontsize=8)
    return filled


def _other(axes: Axes, other: Overlay) -> None:
    label = f"{other.scaled.vehicle}, scaled"
    axes.plot(other.speed, other.asked, "--", color="#56B4E9", linewidth=2, label=label)
    if other.drive is not None:
        axes.plot(
            *other.drive,
            "o",
            markerfacecolor="white",
            markeredgecolor="black",
            markeredgewidth=0.4,
            markersize=3,
            label="driven cycle",
        )
