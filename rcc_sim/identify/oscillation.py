"""Free swings in the log of a gyro: where they are, and the period of each."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from rcc_sim.errors import InputError
from rcc_sim.identify.series import Array, correlation_time, r_squared
from rcc_sim.trace import integral_of

THRESHOLD = 0.12
"""Part of the log's largest rate below which a sample is near zero. [1]"""

REGULAR = 0.35
"""Most by which a half swing's duration may differ from its fellows'. [1]"""

GROWTH = 1.3
"""Peak against the peak before it that means a new push, not a free swing. [1]"""

HALF_SWINGS = 4
"""Fewest half swings that make a swing. [1]"""

R_SQUARED_MIN = 0.5
"""Least share of the variance that a decaying sinusoid must explain. [1]"""

T_SD_MAX = 0.02
"""Largest relative sd of a period that counts as found; noise fits worse. [1]"""

ROWS_MIN = 12
"""Fewest rows of a swing. [1]"""

WINDOWS = (1, 3, 9, 27, 81)
"""Rows of the moving means through which swings are looked for. [1]"""

ROUNDS, FINE = 4, 400
"""Fits by which a wide swing's clock settles, and moments by which it is drawn. [1]"""

OUTLIER = 6.0
"""Robust standard deviations beyond which a row is left out of the fit. [1]"""


@dataclass(frozen=True)
class Swing:
    """One free swing found in a log.

    Attributes
    ----------
    T, T_sd : float
        Undamped (natural) period and its standard deviation. [s]
    T_damped : float
        Period as observed, of the damped swing. [s]
    damping_ratio, damping_ratio_sd : float
        Share of critical damping. [1]
    angle_start, angle_end : float
        Amplitude of the yaw angle at both ends; [rad] if the rate was in rad/s.
    start_s, end_s : float
        Where in the log. [s]
    n_cycles, r_squared : float
        Swings to and fro, and the variance explained. [1]
    samples, outliers : int
        Rows fitted, and rows left out as outliers. [1]
    """

    T: float
    T_sd: float
    T_damped: float
    damping_ratio: float
    damping_ratio_sd: float
    angle_start: float
    angle_end: float
    start_s: float
    end_s: float
    n_cycles: float
    r_squared: float
    samples: int
    outliers: int


@dataclass(frozen=True)
class OscillationPeriod:
    """The period found in a log: one per swing, and their mean.

    Attributes
    ----------
    T, T_sd : float
        Mean undamped period and its standard deviation. [s]
    damping_ratio : float
        Mean share of critical damping. [1]
    n_cycles : float
        Full cycles in all swings. [1]
    r_squared : float
        Lowest of the swings'. [1]
    swings : tuple of Swing
        Each swing, in order of time.
    warnings : tuple of str
        What a reader should know before using the figure.
    """

    T: float
    T_sd: float
    damping_ratio: float
    n_cycles: float
    r_squared: float
    swings: tuple[Swing, ...]
    warnings: tuple[str, ...]

    @property
    def periods(self) -> tuple[float, ...]:
        """Undamped period of each swing, for `yaw_inertia`. [s]"""
        return tuple(swing.T for swing in self.swings)

    @property
    def period_sds(self) -> tuple[float, ...]:
        """Standard deviation of each of `periods`. [s]"""
        return tuple(swing.T_sd for swing in self.swings)


Lengthening = Callable[[Array], Array]
"""Amplitude [rad] -> period over that of a small swing [1]."""


def find_swings(
    t: Array, rate: Array, longer: Lengthening | None = None
) -> tuple[list[Swing], tuple[str, ...]]:
    """Every free swing of a log, fitted, and what a reader should know.

    Parameters
    ----------
    t : ndarray, shape (n,)
        Time, strictly increasing. [s]
    rate : ndarray, shape (n,)
        Yaw rate. [rad/s]
    longer : callable, optional
        How much longer a wide swing takes: periods are then those of small swings.

    Returns
    -------
    swings : list of Swing
        At least one, in order of time.
    warnings : tuple of str
        Runs that looked like swings and were left out.

    Raises
    ------
    InputError
        If there is none.
    """
    centred = rate - np.median(rate)
    looks = [_swings_seen(t, rate, _smooth(centred, n)) for n in _windows(rate.size)]
    fits, rejected, halves = max(looks, key=lambda look: _covered(look[0]))
    if not fits:
        halves = max(look[2] for look in looks)
        raise InputError(
            f"yaw_rate: no free oscillation in {t[-1] - t[0]:.3g} s: {halves} half"
            f" swings, {rejected} regular run(s) but none a decaying sinusoid; largest"
            f" rate {np.max(np.abs(centred)):.3g}",
            "log at least two full swings at six or more rows a period; is this the"
            " yaw axis, and was the car left alone?",
        )
    warnings: tuple[str, ...] = ()
    if rejected:
        warnings += (
            f"{rejected} run(s) of half swings are no decaying sinusoid: left out",
        )
    if longer is not None:
        again = (_fit_swing(t, rate, *_of(s), longer) for s in fits)
        fits = [new or old for new, old in zip(again, fits, strict=True)]
    outliers = sum(s.outliers for s in fits)
    if outliers:
        warnings += (f"{outliers} outlying row(s) were left out of the fit",)
    return fits, warnings


def _of(swing: Swing) -> tuple[float, float, float]:
    return swing.start_s, swing.end_s, swing.T_damped


def _windows(rows: int) -> list[int]:
    """Widths of moving means through which to look for swings; noise hides them. [1]"""
    return [n for n in WINDOWS if n == 1 or 20 * n < rows]


def _smooth(rate: Array, window: int) -> Array:
    """Moving mean over `window` rows; only for finding swings, never for fitting."""
    return np.convolve(rate, np.full(window, 1 / window), mode="same")


def _covered(fits: list[Swing]) -> float:
    """Time that the swings explain, by which ways to look are ranked. [s]"""
    return sum(s.r_squared * (s.end_s - s.start_s) for s in fits)


def _swings_seen(t: Array, rate: Array, seen: Array) -> tuple[list[Swing], int, int]:
    """Fitted swings, rejected runs and half swings that the smoothed rate shows."""
    crossings, peaks = _half_swings(t, seen)
    fits = []
    rejected = 0
    for start_s, end_s, period in _merged(t, rate, _regular_runs(crossings, peaks)):
        fit = _fit_swing(t, rate, start_s, end_s, period)
        if fit is None or fit.r_squared < R_SQUARED_MIN or fit.T_sd > T_SD_MAX * fit.T:
            rejected += 1
        else:
            fits.append(fit)
    return fits, rejected, max(len(crossings) - 1, 0)


def _half_swings(t: Array, rate: Array) -> tuple[Array, Array]:
    """Times of the zero crossings [s], and the largest rate between each two."""
    limit = THRESHOLD * float(np.quantile(np.abs(rate), 0.995))
    beyond = np.flatnonzero(np.abs(rate) > limit)
    flips = np.flatnonzero(np.diff(np.sign(rate[beyond])) != 0)
    last, first = beyond[flips], beyond[flips + 1]
    part = rate[last] / (rate[last] - rate[first])
    crossings = t[last] + part * (t[first] - t[last])
    peaks = [
        float(np.max(np.abs(rate[a : b + 1])))
        for a, b in zip(first[:-1], last[1:], strict=True)
    ]
    return crossings, np.asarray(peaks)


def _regular_runs(crossings: Array, peaks: Array) -> list[tuple[float, float, float]]:
    """Runs of alike half swings that do not grow: start, end, period. [s]"""
    durations = np.diff(crossings)
    runs = []
    start = 0
    for k in range(1, durations.size + 1):
        if k < durations.size:
            usual = np.median(durations[start:k])
            alike = abs(durations[k] / usual - 1) < REGULAR
            if alike and peaks[k] < GROWTH * peaks[k - 1]:
                continue
        count = k - start
        if count >= HALF_SWINGS:
            trim = 1 if count >= 2 * HALF_SWINGS else 0  # a hand at release and stop
            inner = slice(start + trim, k - trim)
            period = 2 * float(np.mean(durations[inner]))
            runs.append(
                (float(crossings[inner.start]), float(crossings[inner.stop]), period)
            )
        start = k
    return runs


def _merged(
    t: Array, rate: Array, runs: list[tuple[float, float, float]]
) -> list[tuple[float, float, float]]:
    """Join runs that are one swing with rows lost in between."""
    if not runs:
        return []
    merged = [runs[0]]
    for earlier, later in pairwise(runs):
        start_s, end_s, period = merged[-1]
        near = later[0] - end_s < 10 * period and abs(later[2] / period - 1) < REGULAR
        joint = _fit_swing(t, rate, start_s, later[1], period) if near else None
        parts = [_fit_swing(t, rate, *run) for run in (earlier, later)] if near else []
        enough = min((p.r_squared for p in parts if p is not None), default=1.0)
        if joint is not None and 1 - joint.r_squared < 1.5 * (1 - enough) + 0.01:
            merged[-1] = (start_s, later[1], joint.T_damped)
        else:
            merged.append(later)
    return merged


def _fit_swing(
    t: Array,
    rate: Array,
    start_s: float,
    end_s: float,
    period: float,
    longer: Lengthening | None = None,
) -> Swing | None:
    """Decaying sinusoid of one stretch; None where the fit fails."""
    inside = (t >= start_s) & (t <= end_s)
    x, y = t[inside] - start_s, rate[inside]
    if x.size < ROWS_MIN:
        return None
    fit, clock = _fitted(x, y, period, longer)
    residual = y - _model(fit, x, clock)
    scale = 1.4826 * float(np.median(np.abs(residual)))
    keep = np.abs(residual) <= max(OUTLIER * scale, 1e-12 * float(np.max(np.abs(y))))
    if not keep.all() and keep.sum() >= ROWS_MIN:
        x, y = x[keep], y[keep]
        fit, clock = _fitted(x, y, period, longer)
        residual = y - _model(fit, x, clock)
    T_d, decay, a, b, _ = fit
    jacobian = _jacobian(fit, x, clock)
    dof = x.size - fit.size
    try:
        covariance = np.linalg.inv(jacobian.T @ jacobian)
    except np.linalg.LinAlgError:
        return None
    covariance *= float(residual @ residual) / dof * correlation_time([residual])
    omega = 2 * math.pi / T_d
    natural = math.hypot(omega, decay)
    # T = 2π/natural and ζ = decay/natural, differentiated by (T_d, decay)
    to_T = 2 * math.pi / natural**3 * np.array([omega**2 / T_d, -decay])
    to_zeta = np.array([decay * omega**2 / T_d, omega**2]) / natural**3
    cov2 = covariance[:2, :2]
    amplitude = math.hypot(a, b) / natural
    return Swing(
        T=2 * math.pi / natural,
        T_sd=math.sqrt(max(float(to_T @ cov2 @ to_T), 0.0)),
        T_damped=float(T_d),
        damping_ratio=float(decay / natural),
        damping_ratio_sd=math.sqrt(max(float(to_zeta @ cov2 @ to_zeta), 0.0)),
        angle_start=amplitude,
        angle_end=amplitude * math.exp(-decay * (end_s - start_s)),
        start_s=start_s,
        end_s=end_s,
        n_cycles=(end_s - start_s) / float(T_d),
        r_squared=r_squared([y], [residual]),
        samples=int(x.size),
        outliers=int((~keep).sum()),
    )


def _fitted(
    x: Array, y: Array, period: float, longer: Lengthening | None
) -> tuple[Array, Array]:
    r"""Least-squares fit, and the clock [s] by which all its swings take as long.

    A wide swing takes longer by L of its amplitude θ: by a clock that runs at 1/L,

    .. math:: x' = \int_0^x dx / L(\theta_0 e^{-\sigma x})

    all take what a small one does. θ₀ and σ are those of the fit before.
    """
    clock = x
    fit = _decaying_sinusoid(x, y, period, clock)
    for _ in range(ROUNDS if longer is not None else 0):
        assert longer is not None
        T_d, decay, a, b, _ = fit
        fine = np.linspace(0.0, x[-1], FINE)
        narrow = math.hypot(a, b) * T_d / (2 * math.pi) * np.exp(-decay * fine)
        wide = narrow
        for _ in range(ROUNDS):  # the rate tells it by the swing's own pace
            wide = narrow * longer(wide)
        clock = np.interp(x, fine, integral_of(fine, 1.0 / longer(wide)))
        fit = _decaying_sinusoid(x, y, float(T_d), clock)
    return fit, clock


def _decaying_sinusoid(x: Array, y: Array, period: float, clock: Array) -> Array:
    """Least-squares (T_d, decay, a, b, c) from a first guess of the period."""
    from scipy.optimize import least_squares

    size = max(float(np.ptp(y)), 1e-300)

    def residual(p: Array) -> Array:
        return (_model(p, x, clock) - y) / size

    def jacobian(p: Array) -> Array:
        return _jacobian(p, x, clock) / size

    low = [0.5 * period, -10 / period, -np.inf, -np.inf, -np.inf]
    high = [2 * period, np.inf, np.inf, np.inf, np.inf]
    fits = []
    for T in (period, 0.97 * period, 1.03 * period):
        phase = 2 * np.pi * clock / T
        basis = np.column_stack([np.sin(phase), np.cos(phase), np.ones_like(x)])
        a, b, c = np.linalg.lstsq(basis, y, rcond=None)[0]
        fits.append(
            least_squares(
                residual,
                [T, 0.0, a, b, c],
                jac=jacobian,
                x_scale=[T, 1 / max(float(np.ptp(x)), T), size, size, size],
                bounds=(low, high),
            )
        )
    return np.asarray(min(fits, key=lambda fit: fit.cost).x, dtype=float)


def _model(p: Array, x: Array, clock: Array) -> Array:
    """Yaw rate at the times x, at that of its phase: p = (T_d, decay, a, b, c)."""
    T, decay, a, b, c = p
    phase = 2 * np.pi * clock / T
    rate: Array = np.exp(-decay * x) * (a * np.sin(phase) + b * np.cos(phase)) + c
    return rate


def _jacobian(p: Array, x: Array, clock: Array) -> Array:
    """Derivative of `_model` by its five parameters, shape (n, 5)."""
    T, decay, a, b, _ = p
    phase = 2 * np.pi * clock / T
    envelope = np.exp(-decay * x)
    sine, cosine = envelope * np.sin(phase), envelope * np.cos(phase)
    by_T = (a * cosine - b * sine) * -phase / T
    return np.column_stack(
        [by_T, -x * (a * sine + b * cosine), sine, cosine, np.ones_like(x)]
    )
