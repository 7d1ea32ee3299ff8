"""The arithmetic of a score: shares, calibration, overlaps, agreement of profiles."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import nan, sqrt
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

Z_95 = 1.959963984540054  # 1; of a 95 % interval
BINS = 10
Span = Sequence[float]


@dataclass(frozen=True)
class Share:
    """How many of how many, with Wilson's 95 % interval."""

    hits: int
    of: int

    @property
    def value(self) -> float:
        """The share itself; not a number of none."""
        return self.hits / self.of if self.of else nan

    @property
    def interval(self) -> tuple[float, float]:
        r"""Wilson's score interval.

        .. math:: \frac{p + z^2/2n \pm z \sqrt{p(1-p)/n + z^2/4n^2}}{1 + z^2/n}

        E. B. Wilson, J. Am. Stat. Assoc. 22 (1927) 209.
        """
        if not self.of:
            return 0.0, 1.0
        n, p, z2 = self.of, self.value, Z_95**2
        middle = (p + z2 / (2 * n)) / (1 + z2 / n)
        half = Z_95 * sqrt(p * (1 - p) / n + z2 / (4 * n * n)) / (1 + z2 / n)
        return max(middle - half, 0.0), min(middle + half, 1.0)

    def document(self) -> dict[str, Any]:
        """As JSON holds it."""
        low, high = self.interval
        return {"hits": self.hits, "of": self.of, "value": self.value,
                "low": low, "high": high}  # fmt: skip


def share(tests: Sequence[bool]) -> Share:
    """Return how many of the tests are true."""
    return Share(sum(map(bool, tests)), len(tests))


def calibration(stated: ArrayLike, right: ArrayLike) -> dict[str, Any]:
    r"""Stated probabilities against how often they were right.

    Brier's score is the mean of (p - right)²; the expected calibration error is
    Σ n_b/n |mean p - share right| over ten equal bins.
    """
    p, ok = np.asarray(stated, float), np.asarray(right, float)
    if not len(p):
        return {"n": 0, "brier": nan, "ece": nan, "bins": []}
    place = np.minimum((p * BINS).astype(int), BINS - 1)
    bins = []
    for b in range(BINS):
        inside = place == b
        if inside.any():
            n, mean, hit = int(inside.sum()), p[inside].mean(), ok[inside].mean()
            bins.append({"from": b / BINS, "to": (b + 1) / BINS, "n": n,
                         "stated": float(mean), "right": float(hit)})  # fmt: skip
    error = sum(b["n"] * abs(b["stated"] - b["right"]) for b in bins) / len(p)
    return {"n": len(p), "brier": float(np.mean((p - ok) ** 2)), "ece": error,
            "stated": float(p.mean()), "right": float(ok.mean()),
            "bins": bins}  # fmt: skip


def joined(spans: Sequence[Span]) -> list[tuple[float, float]]:
    """Return spans sorted, and those that touch or overlap as one."""
    found: list[tuple[float, float]] = []
    for start, end in sorted((min(s), max(s)) for s in spans):
        if found and start <= found[-1][1]:
            found[-1] = (found[-1][0], max(end, found[-1][1]))
        else:
            found.append((start, end))
    return found


def length(spans: Sequence[Span]) -> float:
    """Return the time that the spans cover together. [s]"""
    return float(sum(end - start for start, end in joined(spans)))


def common(a: Sequence[Span], b: Sequence[Span]) -> float:
    """Return the time that lies in both. [s]"""
    return float(sum(
        max(min(e, y) - max(s, x), 0.0) for s, e in joined(a) for x, y in joined(b)
    ))  # fmt: skip


def overlap(
    flagged: Sequence[Span], true: Sequence[Span], seconds: float
) -> dict[str, float]:
    """Compare where a gap was said to sit with where it truly sat.

    ``iou`` is the common time over the time of either; ``precision`` the share of the
    flagged time that was right, ``recall`` the share of the true time flagged;
    ``chance`` the share of the drive in which it acted, the precision of a guess.
    """
    both, said, was = common(flagged, true), length(flagged), length(true)
    either = said + was - both
    return {
        "iou": both / either if either else nan,
        "precision": both / said if said else nan,
        "recall": both / was if was else nan,
        "chance": was / seconds if seconds else nan,
    }


def agreement(estimated: ArrayLike, true: ArrayLike) -> dict[str, float]:
    """Compare a profile with the true one at the same places.

    Correlation, bias (estimated minus true), root mean square of the difference, and
    the slope of the least-squares line of estimated on true.
    """
    e, t = np.asarray(estimated, float), np.asarray(true, float)
    both = np.isfinite(e) & np.isfinite(t)
    e, t = e[both], t[both]
    if len(e) < 3 or t.std() == 0 or e.std() == 0:
        return {"correlation": nan, "slope": nan, "bias": _mean(e - t), "rms": nan}
    cov = float(np.mean((e - e.mean()) * (t - t.mean())))
    return {
        "correlation": cov / float(e.std() * t.std()),
        "slope": cov / float(t.var()),
        "bias": _mean(e - t),
        "rms": float(np.sqrt(np.mean((e - t) ** 2))),
    }


def _mean(x: NDArray[np.float64]) -> float:
    return float(x.mean()) if len(x) else nan


def spread(values: Sequence[float]) -> dict[str, float]:
    """Return median, 90th percentile and number of some values."""
    if not values:
        return {"median": nan, "p90": nan, "n": 0}
    middle, high = np.percentile(values, [50, 90])
    return {"median": float(middle), "p90": float(high), "n": len(values)}
