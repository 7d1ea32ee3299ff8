"""Stretches of the logs that are held out in turn, and fits that did not see them."""

from __future__ import annotations

from collections.abc import Sequence
from math import inf

import numpy as np
from numpy.typing import NDArray

from rcc_sim.diagnose.fitting import descent
from rcc_sim.diagnose.fitting.descent import SHORTER
from rcc_sim.diagnose.fitting.engine import Engine
from rcc_sim.diagnose.fitting.fit import Fit
from rcc_sim.diagnose.fitting.knobs import Knob
from rcc_sim.diagnose.noise.whitener import Whitener
from rcc_sim.side_by_side import each

Mask = NDArray[np.bool_]

STRETCHES = 8
"""Stretches that a log is cut into; every other one is held out in turn."""

FARTHEST = 3.0
"""Standard deviations by which half of a log may move a figure: beyond, it is bent."""

BORDER = 1.5
"""Time around a border between stretches that neither side uses: half of what noise
remembers each. Of logs under 48 s less, a quarter of a stretch. [s]"""


def folds(engine: Engine) -> list[tuple[list[Mask], list[Mask]]]:
    """Rows to fit on and rows to judge on, per log, for each of two folds."""
    out = []
    for odd in (0, 1):
        train, test = [], []
        for p in engine.problems:
            t = p.log["time_s"]
            edges = np.linspace(t[0], t[-1], STRETCHES + 1)
            inner = edges[1:-1]
            which = np.searchsorted(inner, t, side="right")
            border = min(BORDER, 0.25 * float(edges[1] - edges[0]))
            near = np.abs(t[:, None] - inner[None, :]).min(axis=1) < border
            held = which % 2 == odd
            train.append(~held & ~near)
            test.append(held & ~near)
        out.append((train, test))
    return out


def restricted(noise: Sequence[Whitener], engine: Engine, rows: list[Mask]) -> Mask:
    """Which of all whitened residuals lie on some rows."""
    return np.concatenate(
        [rows[log][w.valid] for w, (log, _) in zip(noise, engine.tracks, strict=True)]
    )


def refitted(engine: Engine, fit: Fit, rows: list[Mask]) -> Fit:
    """A fit moved to what these rows alone ask for, to first order.

    The step ends where no vehicle could have them together. What acts in steps keeps
    what all rows told of it, unless it is a cause: it has no slope, and a threshold
    that a hair moves takes a whole launch with it.
    """
    part = restricted(fit.noise, engine, rows)
    moves = np.array([not is_step(knob) for knob in fit.knobs], dtype=bool)
    free = fit.holding(*(knob.key for knob in fit.knobs if is_step(knob)))
    along = engine.whitened(free.signals, fit.noise)
    asked, _ = descent.newton_step(engine, free, along.white, part)
    far = FARTHEST * free.sds()
    step = np.zeros(len(fit.knobs))
    step[moves] = np.clip(asked, -far, far)
    for share in SHORTER:
        moved = descent.stepped(engine, fit, share * step)
        if moved is not None:
            return moved
    return fit


def is_step(knob: Knob) -> bool:
    """Tell whether a figure that the file states acts in steps, as a threshold does."""
    return knob.is_stepped and knob.sd < inf


def halves(*fits: tuple[Engine, Fit]) -> list[list[tuple[Fit, list[Mask]]]]:
    """For each fit, those that half of the stretches asks for and the other's rows."""
    parts = [(engine, fit, *fold) for engine, fit in fits for fold in folds(engine)]
    found = each(lambda part: (refitted(*part[:3]), part[3]), parts)
    return [found[k : k + 2] for k in range(0, len(found), 2)]
