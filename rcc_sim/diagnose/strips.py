"""Tall matrices whose columns are nil but for a few runs of rows."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Strips:
    """A matrix (n, k), by the runs of rows in which its columns are not nil.

    Two runs of one column have no row in common.

    Parameters
    ----------
    shape : (int, int)
        Rows and columns.
    column, first : ndarray of int, shape (m,)
        Of each run, the column and the first row.
    runs : sequence of ndarray
        What the column holds from there on.
    """

    shape: tuple[int, int]
    column: NDArray[np.intp]
    first: NDArray[np.intp]
    runs: Sequence[Array]

    @classmethod
    def of(cls, dense: Array) -> Strips:
        """Return those of a matrix (n, k), a run each column."""
        k = dense.shape[1]
        return cls(dense.shape, np.arange(k), np.zeros(k, np.intp), list(dense.T))

    @classmethod
    def stacked(cls, parts: Sequence[Strips]) -> Strips:
        """Return matrices of as many columns, one below the other."""
        rows = [p.shape[0] for p in parts]
        begins = np.cumsum([0, *rows[:-1]])
        pairs = zip(parts, begins, strict=True)
        return cls(
            (sum(rows), parts[0].shape[1]),
            np.concatenate([p.column for p in parts]),
            np.concatenate([p.first + begin for p, begin in pairs]),
            [run for p in parts for run in p.runs],
        )

    def times(self, weight: Array) -> Strips:
        """Return it with each row times its weight (n,)."""
        pairs = zip(self._rows, self.runs, strict=True)
        runs = [weight[rows] * run for rows, run in pairs]
        return Strips(self.shape, self.column, self.first, runs)

    def onto(self, other: Array) -> Array:
        """Return the products of its columns with those of another, A^T B."""
        out = np.zeros((self.shape[1], *other.shape[1:]))
        for j, rows, run in zip(self.column, self._rows, self.runs, strict=True):
            out[j] += run @ other[rows]
        return out

    def gram(self) -> Array:
        """Return the products of its columns with one another, A^T A.

        Only runs that have rows in common are multiplied.
        """
        ends = self.first + [len(run) for run in self.runs]
        low = np.maximum.outer(self.first, self.first)
        high = np.minimum.outer(ends, ends)
        p, q = np.nonzero(np.triu(low < high))
        pairs = np.stack([p, q, low[p, q], high[p, q]], axis=1).tolist()
        begin, column, runs = self.first.tolist(), self.column.tolist(), self.runs
        out = np.zeros((self.shape[1], self.shape[1]))
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
        for j, rows, run in zip(self.column, self._rows, self.runs, strict=True):
            out[rows, j] = run
        return out

    @property
    def _rows(self) -> list[slice]:
        pairs = zip(self.first, self.runs, strict=True)
        return [slice(first, first + len(run)) for first, run in pairs]
