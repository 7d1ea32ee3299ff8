"""Tall matrices most of which is nil: a few runs of rows, and some rows whole."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Places = NDArray[np.intp]


@dataclass(frozen=True)
class Strips:
    """A matrix (n, k): some rows whole, of the rest what its columns hold in runs.

    No run holds anything but 0 in a row that is there as a whole, and two runs of one
    column have no row in common.

    Parameters
    ----------
    shape : (int, int)
        Rows and columns.
    rows, whole : ndarray, shapes (q,) and (q, k)
        Rows that are there as a whole, and what they hold.
    column, first : ndarray of int, shape (m,)
        Of each run, the column and the first row.
    runs : sequence of ndarray
        What the column holds from there on.
    """

    shape: tuple[int, int]
    rows: Places
    whole: Array
    column: Places
    first: Places
    runs: Sequence[Array]

    @classmethod
    def of(cls, dense: Array) -> Strips:
        """Return a matrix (n, k) as rows alone."""
        none = np.zeros(0, np.intp)
        return cls(dense.shape, np.arange(len(dense)), dense, none, none, [])

    @classmethod
    def stacked(cls, parts: Sequence[Strips]) -> Strips:
        """Return matrices of as many columns, one below the other."""
        height = [p.shape[0] for p in parts]
        pairs = list(zip(parts, np.cumsum([0, *height[:-1]]), strict=True))
        return cls(
            (sum(height), parts[0].shape[1]),
            np.concatenate([p.rows + begin for p, begin in pairs]),
            np.concatenate([p.whole for p in parts]),
            np.concatenate([p.column for p in parts]),
            np.concatenate([p.first + begin for p, begin in pairs]),
            [run for p in parts for run in p.runs],
        )

    def times(self, weight: Array) -> Strips:
        """Return it with each row times its weight (n,)."""
        whole = weight[self.rows, None] * self.whole
        pairs = zip(self._spans, self.runs, strict=True)
        runs = [weight[span] * run for span, run in pairs]
        return Strips(self.shape, self.rows, whole, self.column, self.first, runs)

    def onto(self, other: Array) -> Array:
        """Return the products of its columns with those of another, A^T B."""
        out: Array = self.whole.T @ other[self.rows]
        for j, span, run in zip(self.column, self._spans, self.runs, strict=True):
            out[j] += run @ other[span]
        return out

    def gram(self) -> Array:
        """Return the products of its columns with one another, A^T A.

        Only runs that have rows in common are multiplied.
        """
        ends = self.first + np.array([len(run) for run in self.runs], np.intp)
        low = np.maximum.outer(self.first, self.first)
        high = np.minimum.outer(ends, ends)
        p, q = np.nonzero(np.triu(low < high))
        pairs = np.stack([p, q, low[p, q], high[p, q]], axis=1).tolist()
        begin, column, runs = self.first.tolist(), self.column.tolist(), self.runs
        out: Array = self.whole.T @ self.whole
        for i, j, a, b in pairs:
            one = runs[i][a - begin[i] : b - begin[i]]
            product = one @ runs[j][a - begin[j] : b - begin[j]]
            out[column[i], column[j]] += product
            if i != j:
                out[column[j], column[i]] += product
        return out

    def toarray(self) -> Array:
        """Return all of it."""
        out = np.zeros(self.shape)
        out[self.rows] = self.whole
        for j, span, run in zip(self.column, self._spans, self.runs, strict=True):
            out[span, j] += run
        return out

    @property
    def _spans(self) -> list[slice]:
        pairs = zip(self.first.tolist(), self.runs, strict=True)
        return [slice(first, first + len(run)) for first, run in pairs]
