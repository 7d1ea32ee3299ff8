"""How far each channel is from its prediction, and how far noise alone puts it."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rcc_sim.analyse.iso18571 import rating
from rcc_sim.channel import sensor_noise
from rcc_sim.definitions.vehicle import Vehicle
from rcc_sim.errors import InputError
from rcc_sim.trace import Trace

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
Noise = tuple[float, str]
"""Size of a channel's noise, and where it is taken from."""

SAMPLE = 200_000
"""Rows from which the size of a noise is judged."""

CALM = 20
"""Stretches of a drive of which the calmer ones tell its noise."""

FEWEST = 20
"""Points without which it has none."""

ALIKE = 0.8
"""Correlation of their speeds at equal times below which two logs are not of the same
drive: half a second apart, two runs of a city cycle have 0.97 or more."""

ALIKE_BY = ("speed_ref_mps", "throttle", "speed_mps")
"""Columns that tell whether two drives are the same; the first that both have."""

RATED = 800
"""Points that a channel is thinned to for its ISO score."""


@dataclass(frozen=True)
class Theil:
    """Shares of a mean square error, after Theil; they sum to 1."""

    bias: float
    variance: float
    covariance: float


@dataclass(frozen=True)
class ChannelGap:
    """One channel, measured less simulated.

    Parameters
    ----------
    channel : str
        Column; its unit is that of rmse, bias, noise and tolerance.
    rows : int
        Rows compared.
    rmse, bias : float
        Root mean square and mean of the difference.
    noise : float
        Standard deviation of what no model foresees.
    noise_from : str
        ``repeats``, ``vehicle file``, ``rough road`` where the log strays at random by
        more than that states, or ``guess`` from the log itself.
    tolerance : float
        Root mean square of what the file's sds do to the channel.
    theil : Theil or None
        None where the two do not differ.
    score : float or None
        Rating of ISO/TS 18571; None where the channel is constant or too short.
    """

    channel: str
    rows: int
    rmse: float
    bias: float
    noise: float
    noise_from: str
    tolerance: float
    theil: Theil | None
    score: float | None

    @property
    def ratio(self) -> float | None:
        """The difference in units of noise and tolerance together."""
        size = float(np.hypot(self.noise, self.tolerance))
        return self.rmse / size if size > 0 else None


def channel_gap(
    name: str,
    measured: Array,
    simulated: Array,
    ok: Mask,
    *,
    noise: tuple[float, str],
    band: Array | float,
) -> ChannelGap:
    """Compare one channel over the rows that are ``ok``."""
    m, s = measured[ok], simulated[ok]
    e = m - s
    tolerance = np.broadcast_to(band, len(measured))[ok]
    return ChannelGap(
        name,
        len(e),
        float(np.sqrt(np.mean(e * e))),
        float(np.mean(e)),
        *noise,
        float(np.sqrt(np.mean(tolerance**2))),
        theil(m, s),
        iso_score(m, s),
    )


def theil(measured: Array, simulated: Array) -> Theil | None:
    r"""Split a mean square error into bias, variance and covariance.

    .. math:: MSE = (\bar s - \bar m)^2 + (\sigma_s - \sigma_m)^2
              + 2 (1 - \rho) \sigma_s \sigma_m

    References
    ----------
    .. [1] H. Theil, Applied Economic Forecasting, North-Holland, 1966.
    """
    mean_square = float(np.mean((measured - simulated) ** 2))
    if mean_square <= 0:
        return None
    bias = float(np.mean(simulated) - np.mean(measured)) ** 2 / mean_square
    spread = float(np.std(simulated) - np.std(measured)) ** 2 / mean_square
    return Theil(bias, spread, max(1 - bias - spread, 0.0))


def iso_score(measured: Array, simulated: Array) -> float | None:
    """Return the rating of ISO/TS 18571, thinned by means; None where it has none."""
    size = -(-len(measured) // RATED)
    rows = len(measured) // size
    m, s = (x[: rows * size].reshape(rows, size).mean(1) for x in (measured, simulated))
    if rows < FEWEST or min(np.ptp(m), np.ptp(s)) <= 0:
        return None
    return rating(m, s)


def noise_of(
    name: str,
    log: Trace,
    residual: Array,
    vehicle: Vehicle,
    repeats: Sequence[Trace],
    memory: int,
) -> Noise:
    """Return the noise of a channel, and where its size is taken from.

    Repeats of the drive know best. A vehicle file's ``[sensors]`` knows the sensor but
    not the road; without one the log's own second differences have to do. To both is
    added what the difference to the model does at random over a short while, which is
    where a rough road and what it makes of speed and current show.
    """
    spread = _repeated(name, log, repeats)
    if spread is not None:
        return spread, "repeats"
    stated = vehicle.noise_sd(name)
    size = scatter(stated, (log[name], residual), (residual,), memory)
    if stated is None:
        return size, "guess"
    return size, "rough road" if size > stated else "vehicle file"


def scatter(
    stated: float | None,
    readings: Iterable[Array],
    residuals: Iterable[Array],
    memory: int,
) -> float:
    """Return what a sensor scatters, or a rough road at random, whichever is more.

    The sensor as ``stated``, else by the calmest of some readings' second differences;
    the road by the difference to a model that strays least within some rows.
    """
    sensor = min(map(sensor_noise, readings)) if stated is None else stated
    return max(sensor, min(wander(e[:SAMPLE], memory) for e in residuals))


def wander(residual: Array, memory: int) -> float:
    """Return how far a difference strays at random within some rows.

    Half the variance of its change over 1, 2, 4 … rows, the largest; by the median
    within each of :data:`CALM` stretches and the lower quartile of these, for a road
    is rough throughout, while what a wrong model does comes and goes.
    """
    size, lag = 0.0, 1
    while lag <= max(memory, 1) and lag < len(residual) // (2 * CALM):
        change = np.abs(residual[lag:] - residual[:-lag])
        middles = medians(change, CALM, more_than=10)
        if len(middles):
            calm = float(np.quantile(middles, 0.25))
            size = max(size, 1.4826 * calm / float(np.sqrt(2)))
        lag *= 2
    return size


def medians(x: Array, count: int, more_than: int) -> Array:
    """Return the medians of so many stretches with more finite values than some."""
    known = np.where(np.isfinite(x), x, np.nan)
    rows, longer = divmod(len(x), count)
    parted = longer * (rows + 1)
    found = []
    for some in (
        known[:parted].reshape(longer, rows + 1),
        known[parted:].reshape(count - longer, rows),
    ):
        ordered = np.sort(some, axis=1)  # NaN last
        k = np.count_nonzero(np.isfinite(some), axis=1)
        which = np.flatnonzero(k > more_than)
        k = k[which]
        found.append((ordered[which, (k - 1) // 2] + ordered[which, k // 2]) / 2)
    return np.concatenate(found)


def refuse_other_drives(log: Trace, repeats: Sequence[Trace]) -> None:
    """Raise if a log that is to repeat another is of another drive.

    What it was asked tells, else how fast it went.

    Raises
    ------
    InputError
        Naming the repeat and how little it is alike.
    """
    for other in repeats:
        name = next((n for n in ALIKE_BY if n in log and n in other), None)
        alike = 1.0 if name is None else _alike(name, log, other)
        if alike < ALIKE:
            raise InputError(
                f"--repeats: {other.name}: {name}: not the drive of {log.name}: "
                f"at equal times from their starts they correlate by {alike:.2f}",
                "a repeat is the same drive again; another drive may be judged "
                "with --holdout",
            )


def _alike(name: str, log: Trace, other: Trace) -> float:
    """Return the correlation of a channel in two logs; 1 where they do not tell."""
    there = _at_equal_times(name, log, other)
    both = np.isfinite(log[name]) & np.isfinite(there)
    a, b = log[name][both], there[both]
    if len(a) <= FEWEST or not (np.ptp(a) > 0 and np.ptp(b) > 0):
        return 1.0
    return float(np.corrcoef(a, b)[0, 1])


def _repeated(name: str, log: Trace, repeats: Sequence[Trace]) -> float | None:
    """Return the sd of a channel between repeats, at equal times from their starts."""
    squares = []
    for other in repeats:
        if name not in other:
            continue
        difference = log[name] - _at_equal_times(name, log, other)
        difference = difference[np.isfinite(difference)]
        if len(difference) > 10:
            squares.append(float(np.var(difference)) / 2)
    return float(np.sqrt(np.mean(squares))) if squares else None


def _at_equal_times(name: str, log: Trace, other: Trace) -> Array:
    """Return a channel of another log at a log's rows; NaN where it has ended."""
    known = np.isfinite(other[name])
    clock = (other["time_s"] - other["time_s"][0])[known]
    time = log["time_s"] - log["time_s"][0]
    there: Array = np.interp(time, clock, other[name][known], left=np.nan, right=np.nan)
    return there
