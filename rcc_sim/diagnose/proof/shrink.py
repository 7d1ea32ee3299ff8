"""How much of a gap is gone on rows that no fit saw, in units of the sensors' noise.

Noise is here what no cause can feed: what sensors scatter, and a rough road at random,
whatever a fit leaves. What a cause does there is also held against what stated figures
do within their sds, in nats.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from rcc_sim.analyse.gap import AVERAGED
from rcc_sim.analyse.gap_channels import scatter
from rcc_sim.analyse.gap_regimes import Scale
from rcc_sim.channel import rows_in
from rcc_sim.definitions.figure import Z_90
from rcc_sim.diagnose.fitting.engine import Engine
from rcc_sim.diagnose.fitting.fit import Fit
from rcc_sim.diagnose.fitting.knobs import figures_of
from rcc_sim.diagnose.judge.energies import TELLS_NOTHING
from rcc_sim.diagnose.noise.whitener import log_density
from rcc_sim.diagnose.proof.folds import Mask, restricted

Array = NDArray[np.float64]
Left = list[Array]
"""Residuals, a track each."""

PIECES = 20
"""Pieces of the rows that are judged, over which the interval is taken."""

TINY = 1e-9
"""Mean square beyond noise that is none."""


@dataclass(frozen=True)
class Shrink:
    """Mean square of residuals beyond noise, in units of noise, on rows held out.

    MSE / noise² - 1 of each channel, the mean over all of them.

    Parameters
    ----------
    before, after : float
        Of the nominal vehicle, and of the mended one.
    explained, low, high : float
        1 - after/before, with its 90 % interval over pieces of these rows.
    nats : float
        By which causes are likelier there than stated figures alone, and these figures
        where they then are: by the noise that the causes leave, or what kept-back logs
        have.
    """

    before: float
    after: float
    explained: float
    low: float
    high: float
    nats: float = 0.0

    @property
    def may_be_none(self) -> bool:
        """Whether causes may do nothing there that stated figures do not.

        Of 111 drives of the blind plant with causes that act and were found, the least
        such interval begins at 0.29.
        """
        return self.nats <= 0.0 or (self.low < 0.0 and self.tells)

    @property
    def tells(self) -> bool:
        """Whether enough is beyond noise, row by row, to tell what of it is gone."""
        return self.high - self.low < TELLS_NOTHING


UNPROVEN = Shrink(0.0, 0.0, 0.0, -1.0, 1.0)
"""Where no row that could be judged was held out."""


def noise_in(engine: Engine, *left: Left) -> list[float]:
    """Return the noise of each track, of which a gap is no part. [its unit]

    What differs from repeats of the drive; else what the vehicle's file says of the
    sensor, or second differences, and at least how far a rough road makes measured and
    predicted stray within some rows. Of several vehicles' residuals (``left``) by the
    least of them: what a wrong one makes of it is no noise.
    """
    return [_noise(engine, k, [some[k] for some in left]) for k in range(len(left[0]))]


def _noise(engine: Engine, track: int, left: list[Array]) -> float:
    log, channel = engine.tracks[track]
    p = engine.problems[log]
    apart = p.noise.get(channel)
    if apart is not None:
        return float(np.nanstd(apart))
    rows = engine.valid[track]
    some = [np.where(rows, e, np.nan) for e in left]
    memory = rows_in(p.log["time_s"], AVERAGED * Scale.of(p.vehicle).time)
    stated = None if p.charge is not None else p.vehicle.noise_sd(channel)
    return scatter(stated, some, some, memory)


def mean_squares(
    engine: Engine, left: Left, noise: Sequence[float], rows: list[Mask], pieces: int
) -> list[float]:
    """Return MSE / noise² - 1 of pieces of some rows, the mean over the channels."""
    found = []
    for log, mine in enumerate(rows):
        tracks = [k for k, (i, _) in enumerate(engine.tracks) if i == log and noise[k]]
        for piece in np.array_split(np.flatnonzero(mine), pieces):
            each = []
            for k in tracks:
                e = left[k][piece[engine.valid[k][piece]]]
                if len(e):
                    each.append(float(np.mean((e / noise[k]) ** 2)) - 1.0)
            if each:
                found.append(float(np.mean(each)))
    return found


def shrink_of(before: Sequence[float], after: Sequence[float], nats: float) -> Shrink:
    """Return what mean squares of pieces, before and after, come to.

    The interval is that of a ratio of two means over the same pieces.
    """
    b, a = np.array(before), np.array(after)
    if not len(b) or b.mean() <= TINY:
        return replace(UNPROVEN, nats=nats)
    total, left = float(b.mean()), max(float(a.mean()), 0.0)
    explained = max(1 - left / total, -1.0)
    apart = a - a.mean() / total * b
    spread = Z_90 * float(apart.std() / np.sqrt(len(a))) / total
    low, high = max(explained - spread, -1.0), min(explained + spread, 1.0)
    return Shrink(total, left, explained, low, high, nats)


def hold_out(
    acting: Engine,
    nominal: Engine,
    fit: Fit,
    mended: Sequence[tuple[Fit, list[Mask]]],
    tolerated: Sequence[tuple[Fit, list[Mask]]],
) -> Shrink:
    """Judge figures found on half of the stretches by the rows of the other half.

    ``nominal`` holds the same logs without the profiles that were found; the nominal
    vehicle is judged there, as its file states it. ``mended`` and ``tolerated`` are
    halves of the ``fit`` with causes, and of that without.
    """
    stated = nominal.residuals({})
    noise = noise_in(nominal, stated, fit.residuals)
    before: list[float] = []
    after: list[float] = []
    nats = 0.0
    for (half, rows), (none, _) in zip(mended, tolerated, strict=True):
        before += mean_squares(nominal, stated, noise, rows, PIECES // 2)
        after += mean_squares(acting, half.residuals, noise, rows, PIECES // 2)
        judged = restricted(fit.noise, acting, rows)
        nats += float(
            np.sum(log_density(acting.white(half.residuals, fit.noise))[judged])
            - np.sum(log_density(nominal.white(none.residuals, fit.noise))[judged])
        )
        nats += (half.prior - none.prior) / len(mended)
    return shrink_of(before, after, nats)


def kept_back(
    other: Engine, values: dict[str, float], tolerated: dict[str, float]
) -> Shrink:
    """Judge figures by logs that were kept back; ``tolerated`` are without causes.

    Nats are by the noise of what the likelier of both leaves there: by what the mended
    vehicle leaves, a cause that those logs lack would gain what it made itself.
    """
    stated, *both = (
        other.residuals(figures_of(figures)) for figures in ({}, tolerated, values)
    )
    noises = [other.learn_noise(e) for e in both]
    without, mended = map(other.loglik, both, noises)
    likelier = noises[mended >= without]
    nats = other.loglik(both[1], likelier) - other.loglik(both[0], likelier)
    noise = noise_in(other, stated, both[1])
    rows = [np.ones(len(p.log), bool) for p in other.problems]
    before, after = (
        mean_squares(other, e, noise, rows, PIECES) for e in (stated, both[1])
    )
    return shrink_of(before, after, nats)
