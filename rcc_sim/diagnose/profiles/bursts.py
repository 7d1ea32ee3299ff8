"""Where a log's cornering is restless: a slippery patch, a sticking rack."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from rcc_sim.analyse.logcheck.finding import runs
from rcc_sim.diagnose.fitting.engine import Engine
from rcc_sim.diagnose.fitting.fit import Fit
from rcc_sim.diagnose.noise.whitener import log_density
from rcc_sim.diagnose.residuals.shapes import LATERAL

Array = NDArray[np.float64]

BURST, BURST_ROWS = 1.0, 20
"""Shortest window [s], and fewest rows, in which cornering may be restless."""

BURST_COST = 6.0
"""Nats that a restless window costs: the log of how many there are to choose from."""

LOUDER = np.exp(np.linspace(0.05, 1.6, 16))
"""Sizes of whitened residuals that are tried."""


def bursts(engine: Engine, fit: Fit, log: int) -> tuple[Array, list[dict[str, Any]]]:
    """Return the nats of each track's restless windows in a log, and those windows.

    What comes and goes within a moment has no mean that a profile could hold, but its
    residuals are larger than elsewhere. In each window the size of the whitened
    residuals may be whatever is likeliest, for ``BURST_COST`` nats. Cornering alone is
    judged: along the road, roughness comes in bursts as well.
    """
    time = engine.problems[log].log["time_s"]
    length = max(BURST, BURST_ROWS * engine.problems[log].row)
    count = int((time[-1] - time[0]) / length) + 1
    nats = np.zeros((len(engine.tracks), count))
    for i, (of, channel) in enumerate(engine.tracks):
        if of == log and channel in LATERAL:
            w = fit.noise[i]
            which = ((time[w.valid] - time[0]) / length).astype(int)
            white = w(fit.residuals[i])
            for size in LOUDER:
                more = log_density(white / size) - log_density(white) - np.log(size)
                nats[i] = np.maximum(nats[i], np.bincount(which, more, count))
    nats = np.maximum(nats - BURST_COST, 0.0)
    by_track, total = nats.sum(1), float(nats.sum())
    loudest = engine.tracks[int(by_track.argmax())][1]
    found = [
        {
            "start_s": float(time[0] + a * length),
            "end_s": float(min(time[0] + b * length, time[-1])),
            "channel": loudest,
            "share": float(nats[:, a:b].sum()) / total,
        }
        for a, b in zip(*runs(nats.sum(0) > 0), strict=True)
    ]
    return by_track, found
