"""Kernel code of the noise: residuals whitened, and scale and memory learnt from them.

A residual's variance is a non-negative sum of shares of what it may grow with; what the
means of blocks of past rows foresee of it is its memory. Both are the likeliest for a
t-distribution, by turns. Rows that a sensor's slow drift alone binds together are
followed by a Kalman filter, whose innovations know nothing of each other. [1]_

References
----------
.. [1] B. D. O. Anderson and J. B. Moore, *Optimal Filtering* (Prentice-Hall, 1979),
   ch. 5.
"""

import math

import numpy as np

from rcc_sim.jit import over_arrays

FREEDOM = 8.0
"""Degrees of freedom of the t-distribution that whitened residuals follow."""

TURNS, STEPS = 3, 12
"""Turns of scale and memory; steps of the shares in each."""

SIZED, NEAR = 100, 1e-4
"""Steps of a size at most, and the change from which on it takes no more."""


@over_arrays
def whiten(e, unit, valid, edges, weight, rest, gain, fade, w):
    """Write to w[j] the valid of e[j, i] / unit[i], less what those before foresee.

    Means of blocks foresee it, which are differences of running totals, a weight for
    each edge of a block; an invalid row counts as 0. A row at rest is foreseen by those
    at rest alone, whose level is followed as a drift is, and foresees no other.
    """
    n = e.shape[1]
    z = np.empty(n)
    total = np.zeros(n + 1)
    for j in range(e.shape[0]):
        for i in range(n):
            z[i] = e[j, i] / unit[i] if valid[i] else 0.0
        for i in range(n):
            total[i + 1] = total[i] + (0.0 if rest[i] else z[i])
        for b in range(len(edges)):
            share, later = weight[b], z[edges[b] :]
            for i in range(len(later)):
                later[i] -= share * total[i]
        k, level = 0, 0.0
        for i in range(n):
            if not valid[i]:
                continue
            w[j, k] = z[i]
            if rest[i]:
                new = e[j, i] - level
                w[j, k] = new / unit[i]
                level = fade[i] * (level + gain[i] * new)
            k += 1


@over_arrays
def whiten_cut(
    e,
    share,
    rows,
    starts,
    begin,
    end,
    place,
    unit,
    valid,
    edges,
    weight,
    rest,
    gain,
    fade,
    w,
):
    """Write to w, from place[j] on, what a window of e (n,) is whitened.

    Window j holds a share of each of its rows, those from starts[j] on; worked out are
    the valid ones from begin[j] to end[j].
    """
    for j in range(len(begin)):
        a, b = begin[j], end[j]
        part, left = np.zeros((1, b - a)), np.empty((1, place[j + 1] - place[j]))
        for i in range(starts[j], starts[j + 1]):
            part[0, rows[i] - a] = e[rows[i]] * share[i]
        span = unit[a:b], valid[a:b], edges, weight, rest[a:b], gain[a:b], fade[a:b]
        whiten(part, *span, left)
        w[place[j] : place[j + 1]] = left[0]


@over_arrays
def follow_drift(each, rows, time, variance, sd, gain, fade):
    """Write how a drift is followed that dies away in so many rows.

    ``each`` (n,) are the variances of the rows beside it. Written are, for each of the
    rows that count, the standard deviation of its innovation, the share of that which
    the drift takes on, and what is left of the drift at the next.
    """
    unsure = variance
    for k in range(len(rows)):
        square = unsure + each[rows[k]]
        sd[k], gain[k], fade[k] = math.sqrt(square), unsure / square, 0.0
        if k + 1 < len(rows):
            fade[k] = math.exp((rows[k] - rows[k + 1]) / time)
        unsure = variance + fade[k] ** 2 * (unsure * (1.0 - gain[k]) - variance)


@over_arrays
def leave_drift(e, rows, sd, gain, fade, w):
    """Write to w[j, k] the innovation of e[j, rows[k]], in its standard deviations.

    A row that is not finite counts as 0.
    """
    for j in range(e.shape[0]):
        drift = 0.0
        for k in range(len(rows)):
            z = e[j, rows[k]]
            new = (z if math.isfinite(z) else 0.0) - drift
            w[j, k] = new / sd[k]
            drift = fade[k] * (drift + gain[k] * new)


@over_arrays
def learn(e, rows, X, edges, solved, share, memory, scale):
    """Learn the noise of a residual e (n,) from some of its rows.

    X (k, n) is what its variance may grow with. Written are the shares of X (k,), the
    weights of the means of the blocks between ``edges`` (m,), solved for so many times
    a turn (0: they stay as they are), and the scale (n,); returned is the size of what
    is left.
    """
    n, v, m = len(e), len(rows), len(memory)
    z, squares, means = np.empty(v), np.empty(v), np.zeros((m, v))
    total = np.zeros(n + 1)
    known = np.empty((X.shape[0], v))
    for j in range(X.shape[0]):
        for i in range(v):
            known[j, i] = X[j, rows[i]]
    size = 1.0
    look_back(e, rows, scale, edges, total, z, means)
    square_left(z, means, memory, squares)
    for _ in range(TURNS):
        for i in range(v):
            squares[i] *= scale[rows[i]] ** 2
        fit_scale(squares, known, share)
        add_up(share, X, scale)
        for i in range(n):
            scale[i] = math.sqrt(scale[i])
        look_back(e, rows, scale, edges, total, z, means)
        size = fit_memory(z, means, solved, memory, squares)
    return size


@over_arrays
def look_back(e, rows, scale, edges, total, z, means):
    """Write the scaled residual z at some rows, and its means over the blocks before.

    Rows that are not among them, and those before the start, count as 0.
    """
    n, k = len(e), 0
    for i in range(n):
        total[i + 1] = total[i]
        if k < len(rows) and rows[k] == i:
            z[k] = e[i] / scale[i]
            total[i + 1] += z[k]
            k += 1
    for b in range(len(means)):
        near, far = edges[b], edges[b + 1]
        for k in range(len(rows)):
            there = total[max(rows[k] - near, 0)] - total[max(rows[k] - far, 0)]
            means[b, k] = there / (far - near)


@over_arrays
def fit_scale(squares, X, share):
    """Write the shares of X (k, n) whose sum is the likeliest variance of squares.

    Multiplicative steps on the likelihood of a t-distribution.
    """
    k = len(share)
    size = robust_size(squares)
    for j in range(k):
        share[j] = max(share[j], 1e-6 / k) * size
    inverse, seen = np.empty(len(squares)), np.empty(len(squares))
    for _ in range(STEPS):
        add_up(share, X, inverse)
        for i in range(len(squares)):
            inverse[i] = 1.0 / inverse[i]
            z = squares[i] * inverse[i]
            seen[i] = (FREEDOM + 1.0) / (FREEDOM + z) * z * inverse[i]
        most = 0.0
        for j in range(k):
            share[j] *= dot(X[j], seen) / max(dot(X[j], inverse), 1e-300)
            most = max(most, share[j])
        for j in range(k):
            share[j] = max(share[j], 1e-12 * most)


@over_arrays
def fit_memory(z, means, solved, memory, squares):
    """Write the weights of the means (m, n) that foresee z; return the size left.

    Least squares with the weights of a t-distribution. Written are the squares of what
    is left, too.
    """
    m = len(memory)
    square_left(z, means, memory, squares)
    variance = robust_size(squares)
    N, b = np.empty((m, m)), np.empty(m)
    weight, part = np.empty(len(z)), np.empty(len(z))
    for _ in range(solved * (m > 0)):
        for i in range(len(z)):
            weight[i] = (FREEDOM + 1.0) / (FREEDOM + squares[i] / variance)
        for j in range(m):
            for i in range(len(z)):
                part[i] = weight[i] * means[j, i]
            b[j] = dot(part, z)
            for c in range(j + 1):
                N[j, c] = dot(part, means[c])
        trace = 0.0
        for j in range(m):
            trace += N[j, j]
        for j in range(m):
            N[j, j] += 1e-3 * trace / m + 1e-30
        solve(N, b)
        for j in range(m):
            memory[j] = b[j]
        square_left(z, means, memory, squares)
        variance = sized(squares, variance)
    return math.sqrt(variance)


@over_arrays
def square_left(z, means, memory, squares):
    """Write the squares of what a memory does not foresee."""
    for i in range(len(z)):
        squares[i] = z[i]
    for j in range(len(memory)):
        for i in range(len(z)):
            squares[i] -= memory[j] * means[j, i]
    for i in range(len(z)):
        squares[i] *= squares[i]


@over_arrays
def add_up(share, X, out):
    """Write the sum of the rows of X (k, n), each by its share."""
    for i in range(len(out)):
        out[i] = 0.0
    for j in range(len(share)):
        for i in range(len(out)):
            out[i] += share[j] * X[j, i]


@over_arrays
def dot(x, y):
    """Sum of products, in four sums side by side, none of which waits for another."""
    a = b = c = d = 0.0
    whole = len(x) - len(x) % 4
    for i in range(0, whole, 4):
        a += x[i] * y[i]
        b += x[i + 1] * y[i + 1]
        c += x[i + 2] * y[i + 2]
        d += x[i + 3] * y[i + 3]
    for i in range(whole, len(x)):
        a += x[i] * y[i]
    return (a + b) + (c + d)


@over_arrays
def robust_size(squares):
    """Return the square of the t-distribution's scale, from squared residuals.

    Their mean will do to begin with: the likelihood has one maximum, and a step leaves
    nine times the share of those that lie far out of what they add.
    """
    mean = 0.0
    for i in range(len(squares)):
        mean += squares[i]
    return sized(squares, mean / len(squares))


@over_arrays
def sized(squares, size):
    """Return the likeliest size of a t-distribution (squared), from another on."""
    inverse = np.empty(len(squares))
    for _ in range(SIZED):
        for i in range(len(squares)):
            inverse[i] = 1.0 / (FREEDOM * size + squares[i] + 1e-300)
        grown = (FREEDOM + 1.0) * dot(squares, inverse) / len(squares)
        size *= grown
        if abs(grown - 1.0) < NEAR:
            break
    return size + 1e-300


@over_arrays
def solve(N, b):
    """Write to b the solution of N x = b by Cholesky; of N the lower half is used."""
    m = len(b)
    for j in range(m):
        for c in range(j + 1):
            part = N[j, c]
            for k in range(c):
                part -= N[j, k] * N[c, k]
            N[j, c] = math.sqrt(part) if c == j else part / N[c, c]
        for k in range(j):
            b[j] -= N[j, k] * b[k]
        b[j] /= N[j, j]
    for j in range(m - 1, -1, -1):
        for k in range(j + 1, m):
            b[j] -= N[k, j] * b[k]
        b[j] /= N[j, j]
