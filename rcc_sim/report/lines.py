"""Lines of a chart: thinned without hiding a spike, packed, and as SVG paths."""

from __future__ import annotations

import base64
import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rcc_sim.channel import interval_of
from rcc_sim.simulate.smooth import HOLE

Array = NDArray[np.float64]

WHOLE = 1_800_000
"""Points that a page holds of lines on the log's own rows."""

THINNED = 500_000
"""Points that a page holds where there are more: each then brings its own time."""

LEVELS = 65534
"""Steps in which a line's own range is told; one more code says "no value"."""

WIDTH, HEIGHT, COLUMNS = 2000, 400, 600
"""Of a chart's own coordinates, and the columns that a path is drawn in."""

ROUND = (1, 2, 2.5, 5, 10)
"""Steps between marks, times a power of ten."""

FLAT = 1e-6
"""Share of its size by which a line must vary to be more than rounding."""

MARGIN = 0.05
"""Share of the range left free above and below."""


@dataclass(frozen=True)
class Line:
    """One line: a name, the class that colours it, and its points."""

    name: str
    kind: str
    x: Array
    y: Array


def extremes(x: Array, y: Array, most: int) -> tuple[Array, Array]:
    """Return at most about ``most`` points; each stretch keeps its least and greatest.

    Rows without a value are kept as gaps where a whole stretch has none.
    """
    if len(x) <= most:
        return x, y
    size = -(-len(x) // max(most // 2, 2))
    padded = np.full(-(-len(x) // size) * size, np.nan)
    padded[: len(y)] = y
    blocks = padded.reshape(-1, size)
    starts = np.arange(0, len(x), size)
    low = starts + np.where(np.isnan(blocks), np.inf, blocks).argmin(1)
    high = starts + np.where(np.isnan(blocks), -np.inf, blocks).argmax(1)
    rows = np.unique(np.concatenate([[0], low, high, [len(x) - 1]]))
    return x[rows], y[rows]


def shown(x: Array, y: Array, most: int) -> tuple[Array, Array]:
    """Return a log's line as it is drawn: thinned, and cut where rows were lost.

    A hole is a step of the clock longer than HOLE usual ones; the rows at its edges are
    kept, and a point without a value stands between them.
    """
    after = np.flatnonzero(np.diff(x) > HOLE * interval_of(x)) + 1
    if not 0 < len(after) <= most // 8:
        return extremes(x, y, most)
    parts = []
    for a, b in zip([0, *after], [*after, len(x)], strict=True):
        share = max(most * int(b - a) // len(x), 4)
        u, v = extremes(x[a:b], y[a:b], share)
        parts.append((np.append(u, u[-1]), np.append(v, np.nan)))
    columns, values = (np.concatenate(part) for part in zip(*parts, strict=True))
    return columns[:-1], values[:-1]


def bounds(lines: list[Line]) -> tuple[float, float]:
    """Return the range of lines with some room, never empty."""
    values = [line.y[np.isfinite(line.y)] for line in lines]
    some = np.concatenate(values) if values else np.empty(0)
    if not len(some):
        return 0.0, 1.0
    low, high = float(some.min()), float(some.max())
    if high - low <= FLAT * max(abs(low), abs(high)):
        room = abs(high) * 0.1 or 1.0
        return low - room, high + room
    return low - (high - low) * MARGIN, high + (high - low) * MARGIN


def path(line: Line, span: tuple[float, float], reach: tuple[float, float]) -> str:
    """Return a line as an SVG path; each of COLUMNS keeps its least and greatest."""
    if not len(line.x):
        return ""
    x, y = shown(line.x, line.y, 2 * COLUMNS)
    scale = WIDTH / ((span[1] - span[0]) or 1.0)
    return _through((x - span[0]) * scale, _down(y, reach))


def _down(y: Array, reach: tuple[float, float]) -> Array:
    return (reach[1] - y) * (HEIGHT / (reach[1] - reach[0]))


def _through(x: Array, y: Array) -> str:
    words: list[str] = []
    pen, last = "M", (0, 0)
    for a, b in zip(np.rint(x).tolist(), y.tolist(), strict=True):
        if math.isnan(b):
            pen = "M"
            continue
        point = (int(a), round(b))
        if point != last or pen == "M":
            words.append(f"{pen}{point[0]} {point[1]}")
        pen, last = "L", point
    return "".join(words)


def ticks(low: float, high: float, most: int = 5) -> list[tuple[float, str]]:
    """Return round values inside a range, at most about ``most``, with their text.

    >>> [text for _, text in ticks(0.0, 10.0)]
    ['0', '2', '4', '6', '8', '10']
    """
    raw = (high - low) / most
    power = 10.0 ** math.floor(math.log10(raw))
    times = next(s for s in ROUND if s * power >= raw * 0.999)
    step = times * power
    digits = max(0, -math.floor(math.log10(step) + 1e-9) + (times == 2.5))
    first = math.ceil(low / step - 1e-9)
    count = math.floor(high / step + 1e-9) - first + 1
    return [
        (v, f"{v:.{digits}f}".replace("-", "−"))
        for v in ((first + k) * step + 0.0 for k in range(count))
    ]


class Packer:
    """Lines as the page's script reads them: 16 bits a value, time told once.

    Parameters
    ----------
    lines : int
        How many there will be, for the page's size.
    rows : int
        Points of all of them together.
    """

    def __init__(self, lines: int, rows: int) -> None:
        self.most = rows if rows <= WHOLE else max(THINNED // max(lines, 1), 1000)
        self.axes: list[dict[str, Any]] = []
        self._seen: dict[bytes, int] = {}

    def pack(self, line: Line) -> dict[str, Any]:
        """Return a line as plain data."""
        x, y = shown(line.x, line.y, self.most)
        good = y[np.isfinite(y)]
        low = float(good.min()) if len(good) else 0.0
        step = (float(good.max()) - low) / LEVELS if len(good) else 0.0
        code = np.full(len(y), LEVELS + 1, dtype="<u2")
        there = np.isfinite(y)
        code[there] = np.rint((y[there] - low) / (step or 1.0)).astype("<u2")
        return {
            "name": line.name,
            "kind": line.kind,
            "axis": self._axis(x),
            "low": low,
            "step": step,
            "y": _text(code),
        }

    def _axis(self, x: Array) -> int:
        key = x.tobytes()
        if key not in self._seen:
            start = float(x[0]) if len(x) else 0.0
            step = (float(x[-1]) - start) / 0xFFFFFFFF if len(x) else 0.0
            code = np.rint((x - start) / (step or 1.0)).astype("<u4")
            self._seen[key] = len(self.axes)
            self.axes.append({"start": start, "step": step, "x": _text(code)})
        return self._seen[key]


def _text(values: NDArray[Any]) -> str:
    return base64.b64encode(values.tobytes()).decode("ascii")
