"""Tables of measured or wanted values: found by walking on, or by bisection."""

from rcc_sim.jit import jit


@jit
def seek(x, xs, at):
    """Last place in xs, from `at` on, whose entry is not above x."""
    i = int(at)
    while i + 2 < len(xs) and xs[i + 1] <= x:
        i += 1
    return i


@jit
def between(x, xs, ys, i):
    """Linear interpolation in the cell i of a table; its ends hold beyond it."""
    if len(xs) < 2 or x <= xs[0]:
        return ys[0]
    if x >= xs[-1]:
        return ys[-1]
    share = (x - xs[i]) / (xs[i + 1] - xs[i])  # one division for all columns at x
    return ys[i] + (ys[i + 1] - ys[i]) * share


LINE, SINCE, BEFORE = 0, 1, 2
"""How a command runs from row to row: on a straight line; from a row on, as one that
is logged as it is sent; or before a row, as one that is logged while it acts."""


@jit
def command_at(x, xs, ys, at, how, near):
    """Command at x, and the cell of the table that it is read in, sought from `at` on.

    It is the last that came, the next, or in between. One that leaps does so where a
    row is less than `near` ahead: their clocks differ in the last digit alone.
    """
    if how == LINE:
        i = seek(x, xs, at)
        return between(x, xs, ys, i), i
    i = seek(x + near, xs, at)
    if x + near >= xs[-1]:
        return ys[-1], i
    if how == BEFORE and x + near >= xs[i]:
        return ys[i + 1], i
    return ys[i], i


@jit
def slope_of(x, xs, ys, i):
    """Slope of a table at x, searched from cell i on; 0 beyond its ends."""
    if len(xs) < 2 or x < xs[0] or x >= xs[-1]:
        return 0.0
    k = seek(x, xs, i)
    return (ys[k + 1] - ys[k]) / (xs[k + 1] - xs[k])


@jit
def cell_of(x, grid):
    """Index of the cell of an increasing grid that holds x; the ends are clamped."""
    lo = 0
    hi = len(grid) - 1
    while hi - lo > 1:
        mid = (lo + hi) // 2
        if grid[mid] <= x:
            lo = mid
        else:
            hi = mid
    return lo


@jit
def bilinear(x, y, xs, ys, table):
    """Value at (x, y) of a table over two increasing grids, clamped at its edges."""
    i = cell_of(x, xs)
    j = cell_of(y, ys)
    a = (x - xs[i]) / (xs[i + 1] - xs[i])
    b = (y - ys[j]) / (ys[j + 1] - ys[j])
    a = min(max(a, 0.0), 1.0)
    b = min(max(b, 0.0), 1.0)
    low = table[i, j] * (1.0 - b) + table[i, j + 1] * b
    high = table[i + 1, j] * (1.0 - b) + table[i + 1, j + 1] * b
    return low * (1.0 - a) + high * a
