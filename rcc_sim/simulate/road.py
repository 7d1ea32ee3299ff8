"""The slope of a road whose elevation was surveyed along a drive, noise and all."""

from __future__ import annotations

from collections.abc import Sequence
from hashlib import blake2b
from threading import Lock
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from rcc_sim.channel import resolution, spells
from rcc_sim.physics.effects.road_grade import STEEPEST, rise_over_run
from rcc_sim.simulate.smooth import pieces

if TYPE_CHECKING:
    from scipy.sparse import csr_array

Array = NDArray[np.float64]

CELLS, READINGS = 1000, 8
"""Most cells that a road is cut into, and readings that each holds at least."""

VISIT, SOONEST = 10.0, 1e-3
"""Time for which readings count as one as a car comes into a cell, and as it leaves;
and that after which the next are at least. [s]"""

BENDS = np.logspace(-6, -1.5, 10)
"""Strengths of a road that are tried: changes of its slope from cell to cell. [1]"""

FORGETS = 100.0
"""Time in which an altimeter forgets by how much it was off. [s]"""

WANDERS = (1e-9, 1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 1e-1)
"""Strengths of an altimeter's wander that are tried; the first is none. [m²/s]"""

FINER = (0.5, 0.25)
"""Decades by which the likeliest strength is found finer."""

ROUNDS, FREEDOM, SETTLED = 10, 4.0, 0.1
"""Rounds at most in which what is far off is weighed anew, degrees of freedom of that,
and change of a weight below which no more."""

KNOWN = 1e6
"""Times as sure as a reading is that the wander begins at nil."""

STANDS = 0.8
"""Share of the readings that repeat the one before beyond which heights are rounded."""

TURNS = 0.3
"""Share of their steps that go back from the one before beyond which they flicker."""

STEP_SHARE = 0.1
"""Share of a step to which a height is known where it passes from one to the next."""


KEPT = 4
"""Roads that are kept: a log is asked for its own several times, by threads at once."""

_kept: dict[bytes, tuple[Array, Array]] = {}
_one_at_a_time = Lock()


def surveyed_slope(
    distance: Array, elevation: Array, time: Array | None = None
) -> tuple[Array, Array]:
    r"""Slope [1] over distance [m] from elevations [m] that hold noise and wander.

    .. math:: h_i = z(s_i) + w(t_i) + e_i

    The height z is a twice integrated random walk along the road; the altimeter's
    wander w is an Ornstein-Uhlenbeck process in time, on the way as at rest, that
    forgets in ``FORGETS``: ∫ (w'² + (w / T)²) dt / D is small. Their strengths are the
    likeliest for these elevations: a flat road with a noisy survey comes out flat, and
    of what a barometer makes up no slope is made. (What it takes to climb would fall
    short of slopes that hold noise, as by a lighter car.)

    Parameters
    ----------
    distance, elevation : ndarray, shape (n,)
        At each row; NaN where not known. [m]
    time : ndarray or None
        Of each row; without it nothing wanders. [s]

    Returns
    -------
    distance, slope : ndarray, shape (k,)
        Middle of each cell [m], rise over run [1].
    """
    told = [distance, elevation] if time is None else [distance, elevation, time]
    key = blake2b(np.stack(told).data).digest()
    with _one_at_a_time:
        if key not in _kept:
            while len(_kept) >= KEPT:
                del _kept[next(iter(_kept))]
            _kept[key] = _surveyed(distance, elevation, time)
        at, slope = _kept[key]
    return at.copy(), slope.copy()


def _surveyed(
    distance: Array, elevation: Array, time: Array | None
) -> tuple[Array, Array]:
    when = np.zeros(len(distance)) if time is None else time
    ok = np.isfinite(distance) & np.isfinite(elevation)
    s, h, t = distance[ok], elevation[ok], when[ok]
    sure, step_noise, each = np.ones(len(s)), 0.0, READINGS
    if is_rounded(s, h):
        s, h, t, sure, step_noise = passed(s, h, t)
        each = 1
    length = float(s[-1] - s[0]) if len(s) else 0.0
    if len(s) < 10 or length <= 0:
        return np.zeros(1), np.zeros(1)
    edges, cell = cells(s, each)
    visit = visits(cell, t)
    noise2 = step_noise or within(visit, s, h, int(visit[-1]) + 1)
    count = np.bincount(visit, sure)
    place, height, then = (np.bincount(visit, sure * x) / count for x in (s, h, t))
    off2 = noise2 / count + (0.0 if step_noise else undithered(h, noise2))
    road = Road(edges, place, height, then, 1 / off2)
    found = road.likeliest(WANDERS if time is not None else WANDERS[:1])
    middle = 0.5 * (edges[1:] + edges[:-1])
    step = edges[1] - edges[0]
    dh = np.clip(np.diff(found), -STEEPEST * step, STEEPEST * step)
    return 0.5 * (middle[1:] + middle[:-1]), rise_over_run(dh, step)


class Road:
    """Heights of a road's cells, and how an altimeter wandered between its visits.

    Parameters
    ----------
    edges : ndarray, shape (k + 1,)
        Of the cells, evenly apart. [m]
    place, height, time : ndarray, shape (m,)
        Where [m] and when [s] each visit of a cell was, and what was read [m].
    weight : ndarray, shape (m,)
        One over the variance of that. [1/m²]
    """

    def __init__(
        self, edges: Array, place: Array, height: Array, time: Array, weight: Array
    ) -> None:
        k, m = len(edges) - 1, len(place)
        self.step = float(edges[1] - edges[0])
        # a car that waits in a cell was not in its middle: heights run straight between
        where = (place - edges[0]) / self.step - 0.5
        left = np.clip(np.floor(where), 0, k - 2).astype(int)
        share = where - left
        # unknowns as they come along the road, so that equations hold few bands
        order = np.argsort(np.concatenate([np.arange(k), left + 1.5]), kind="stable")
        at = np.empty(k + m, dtype=int)
        at[order] = np.arange(k + m)
        z, w = at[:k], at[k:]
        self.cells, self.wander = z, w
        sure, one = np.sqrt(weight), np.ones(k - 2)
        later = 1 / np.sqrt(np.maximum(np.diff(time), SOONEST))
        self.read = sure * height
        apart = np.maximum(np.gradient(time), SOONEST)
        self.reads, self.bends, self.moves, self.stays = (
            rows_of(terms, k + m)
            for terms in (
                [(z[left], sure * (1 - share)), (z[left + 1], sure * share), (w, sure)],
                [(z[:-2], one), (z[1:-1], -2 * one), (z[2:], one)],
                [(w[:-1], -later), (w[1:], later)],
                [(w, np.sqrt(apart) / FORGETS)],
            )
        )
        # of height and wander one alone begins at nil
        self.first = rows_of([(w[:1], np.sqrt(KNOWN * weight[:1]))], k + m)
        self.weigh(np.ones(m), np.ones(m - 1), np.ones(m))

    def weigh(self, *weights: Array) -> None:
        """Let each reading, and each move and stay of the wander, count by a weight."""
        from scipy.sparse import diags_array

        self.weights = weights
        rows = zip(weights, (self.reads, self.moves, self.stays), strict=True)
        heard, moved, stayed = (diags_array(np.sqrt(w)) @ A for w, A in rows)
        self.weighed = heard, self.bends, moved, stayed
        self.right = np.sqrt(weights[0]) * self.read
        self.asked = heard.T @ self.right
        self.normal = banded([*self.weighed, self.first])

    def likeliest(self, wanders: Sequence[float]) -> Array:
        """Return the heights [m] by the likeliest strengths, of these of the wander.

        What is far off counts less, as by a t-distribution: an altimeter leaps by tens
        of metres, stays there, and comes back.
        """
        for _ in range(ROUNDS):
            wander, x = self.searched(wanders)
            off, move = self.read - self.reads @ x, self.moves @ x
            usual = np.sqrt(0.5 * wander * FORGETS)
            far = off, move / np.sqrt(wander), x[self.wander] / usual
            weights = [tailed(z) for z in far]
            pairs = zip(weights, self.weights, strict=True)
            if all(np.all(np.abs(now - was) < SETTLED) for now, was in pairs):
                break
            self.weigh(*weights)
        return np.asarray(x[self.cells])

    def searched(self, wanders: Sequence[float]) -> tuple[float, Array]:
        """Return the likeliest strength of the wander, and all unknowns by it."""
        tried = {(q, d): self.solved(q, d) for d in wanders for q in BENDS}
        q, d = max(tried, key=lambda one: tried[one][0])
        for part in FINER:  # of the way to the next in the grid
            near = [d] if d == wanders[0] else [d / 10**part, d, d * 10**part]
            tried |= {
                (x, y): self.solved(x, y)
                for x in (q / 10 ** (part / 2), q, q * 10 ** (part / 2))
                for y in near
                if (x, y) not in tried
            }
            q, d = max(tried, key=lambda one: tried[one][0])
        return d, tried[q, d][1]

    def solved(self, strength: float, wander: float) -> tuple[float, Array]:
        """Log-likelihood of two strengths, and the unknowns by them.

        Second differences of heights have the variance (strength * step)² [m²], those
        of the wander after a time dt wander * dt.
        """
        from scipy.linalg import cho_solve_banded, cholesky_banded

        q2 = (strength * self.step) ** 2
        reads, bends, moves, stays, first = self.normal
        try:
            C = cholesky_banded(reads + bends / q2 + (moves + stays) / wander + first)
        except np.linalg.LinAlgError:  # stiffer than numbers have digits
            return -np.inf, np.zeros(len(self.asked))
        x = cho_solve_banded((C, False), self.asked)
        heard, bend, move, stay = (A @ x for A in self.weighed)
        off = self.right - heard
        left = off @ off + bend @ bend / q2 + (move @ move + stay @ stay) / wander
        free = len(bend) * np.log(q2) + len(move) * np.log(wander)
        value = -0.5 * (left + free) - np.log(C[-1]).sum()
        return float(value), x


def tailed(off: Array) -> Array:
    """Return the weight of what is so many sds off, by a t-distribution."""
    return np.asarray((FREEDOM + 1) / (FREEDOM + off**2))


def rows_of(terms: Sequence[tuple[Array, Array]], many: int) -> csr_array:
    """Return a matrix of so ``many`` columns: in each row some, and what they hold."""
    from scipy.sparse import csr_array

    rows = np.tile(np.arange(len(terms[0][0])), len(terms))
    columns, values = (np.concatenate(x) for x in zip(*terms, strict=True))
    return csr_array((values, (rows, columns)), shape=(len(terms[0][0]), many))


def banded(matrices: Sequence[csr_array]) -> list[Array]:
    """Return A'A of some matrices in upper bands, of as many as the widest needs."""
    products = [(A.T @ A).tocoo() for A in matrices]
    width = max(int((p.col - p.row).max()) for p in products)
    found = []
    for p in products:
        bands, up = np.zeros((width + 1, p.shape[0])), p.col >= p.row
        bands[width + p.row[up] - p.col[up], p.col[up]] = p.data[up]
        found.append(bands)
    return found


def undithered(height: Array, noise2: float) -> float:
    r"""Variance [m²] that a mean of rounded heights keeps, however many they are.

    .. math:: \frac{q^2}{2 \pi^2} e^{-4 \pi^2 \sigma^2 / q^2}

    of the first harmonic of what rounding to steps q errs by, beside a noise σ; about
    such means readings scatter by the rest (``noise2``) of σ² + q²/12. [1]_ With the
    variance k² that is kept, σ² = noise2 - q²/12 + k²: it is q²/4π² W(2 e^-4π²c), with
    c = noise2/q² - 1/12 and Lambert's W, that of no noise at most.

    References
    ----------
    .. [1] B. Widrow, I. Kollár, Quantization Noise, Cambridge, 2008, ch. 4, 19.
    """
    from scipy.special import lambertw

    q = resolution(height)
    if q == 0.0:
        return 0.0
    B = 4 * np.pi**2
    kept = lambertw(2 * np.exp(-B * (noise2 / q**2 - 1 / 12))).real / B
    return float(q**2 * min(kept, 2 / B))


def visits(cell: NDArray[np.int_], time: Array) -> NDArray[np.int_]:
    """Return which visit each row is of: a cell's first, its last and what is between.

    However long a car waits, three of them tell what wandered meanwhile.
    """
    first, end = spells(cell)
    stay = np.repeat(np.arange(len(first)), end - first)
    near = time - time[first][stay] < VISIT
    last = ~near & (time[end - 1][stay] - time < VISIT)
    part = 3 * stay + np.where(near, 0, np.where(last, 2, 1))
    return np.asarray(np.cumsum(np.diff(part, prepend=part[:1]) != 0))


def cells(s: Array, each: int) -> tuple[Array, NDArray[np.int_]]:
    """Return the edges of a road's cells, of so many places each, and each's cell."""
    k = int(min(CELLS, max(len(s) // each, 4)))
    edges = np.linspace(s[0], s[-1], k + 1)
    return edges, np.clip(np.searchsorted(edges, s, side="right") - 1, 0, k - 1)


def is_rounded(s: Array, h: Array) -> bool:
    """Tell whether heights are rounded: they stand, and then go on the way they went.

    Where noise makes them flicker between two steps, or they wander by more than a
    step, their mean says more.
    """
    moves, rises = np.diff(s) > 0, np.diff(h)
    steps = rises[rises != 0]
    if not moves.any() or len(steps) < 2:
        return False
    stands = float(np.mean(rises[moves] == 0))
    turns = float(np.mean(np.sign(steps[1:]) != np.sign(steps[:-1])))
    if stands < STANDS or turns > TURNS:
        return False
    edges, cell = cells(s, READINGS)
    wander = within(cell, s, h, len(edges) - 1)
    return wander < float(np.abs(steps).min()) ** 2 / 12


def passed(s: Array, h: Array, t: Array) -> tuple[Array, Array, Array, Array, float]:
    """Return where, at what height and when rounded ones pass from step to step.

    There they are half-way. Between two such places a reading says no more than that
    none was passed: all along it is within half a step of the road. Also returns how
    sure each is, against the first kind, and the variance of that. [m²]
    """
    at = np.flatnonzero(np.diff(h) != 0)
    step = float(np.min(np.abs(np.diff(h)[at])))
    ends, then = (
        np.concatenate([x[:1], 0.5 * (x[at] + x[at + 1]), x[-1:]]) for x in (s, t)
    )
    stands = np.concatenate([h[at], h[-1:]])
    among, each = pieces(np.diff(ends))
    place, time = (
        np.concatenate([x[1:-1], x[among] + each * np.diff(x)[among]])
        for x in (ends, then)
    )
    height = np.concatenate([0.5 * (h[at] + h[at + 1]), stands[among]])
    sure = np.concatenate([np.ones(len(at)), np.full(len(each), 12 * STEP_SHARE**2)])
    order = np.argsort(place, kind="stable")
    noise2 = (STEP_SHARE * step) ** 2
    return place[order], height[order], time[order], sure[order], noise2


def within(cell: NDArray[np.int_], s: Array, h: Array, k: int) -> float:
    """Variance of heights [m²] about a straight slope in each of k cells."""
    count = np.maximum(np.bincount(cell, minlength=k), 1)
    s, h = (x - (np.bincount(cell, x, k) / count)[cell] for x in (s, h))
    along, across, rise = (
        np.bincount(cell, x, minlength=k) for x in (s * s, h * s, h * h)
    )
    sloped = along > 0
    left = rise.sum() - (across[sloped] ** 2 / along[sloped]).sum()
    free = len(h) - len(np.unique(cell)) - int(sloped.sum())
    return max(float(left) / max(free, 1), 1e-12)
