"""Text that may come from anyone's file, made safe for a terminal and for HTML."""

from __future__ import annotations

import html
from collections.abc import Sequence
from itertools import pairwise

VOID = frozenset({"br", "hr", "input", "meta"})
"""HTML elements that hold nothing."""


def printable(text: str) -> str:
    """Return the text without control characters (no escape sequence passes)."""
    return "".join(c if c.isprintable() or c in "\n\t" else "\ufffd" for c in text)


def short(path: str, most: int = 24) -> str:
    """Return a path that fits a heading: its end, where it is long.

    >>> short("/a/long/way/to/some/folder/of/many/drives/c0001/log.csv.gz")
    '…/c0001/log.csv.gz'
    """
    if len(path) <= most or path.count("/") < 2:
        return path
    return "…/" + "/".join(path.split("/")[-2:])


LEAST = 0.01
"""Percent below which a share is only said to be small."""


class Markup(str):
    """Text that is HTML already; all other text is escaped where it is put in."""

    __slots__ = ()


def escaped(content: object) -> Markup:
    """Return what shows as exactly this text in HTML."""
    if isinstance(content, Markup):
        return content
    return Markup(html.escape(printable(str(content)), quote=True))


def tag(name: str, /, *content: object, **attributes: object) -> Markup:
    """Return an HTML element; content and attributes that are not Markup are escaped.

    An attribute's ``_`` stands for ``-`` and one at its end for nothing (``class_``);
    None and False leave it out.
    """
    written = ""
    for key, value in attributes.items():
        if value is None or value is False:
            continue
        plain = key.rstrip("_").replace("_", "-")
        written += f" {plain}" if value is True else f' {plain}="{escaped(value)}"'
    inner = joined(*content)
    return Markup(
        f"<{name}{written}>" if name in VOID else f"<{name}{written}>{inner}</{name}>"
    )


def joined(*content: object) -> Markup:
    """Return contents one after the other."""
    return Markup("".join(escaped(part) for part in content))


def figures(value: object, digits: int = 3) -> str:
    """Return a number as a person reads it; a dash where there is none."""
    if value is None:
        return "–"
    if isinstance(value, bool) or not isinstance(value, int | float):
        return str(value)
    if value != value:
        return "–"
    short = f"{value:.{digits}g}"
    text = f"{value:.0f}" if "e+" in short and abs(value) < 1e7 else short
    return text.replace("-", "−")


def listed(names: Sequence[str], word: str = "and") -> str:
    """Return names as a sentence has them.

    >>> listed(["mass", "drag", "wind"])
    'mass, drag and wind'
    """
    first, last = names[:-1], names[-1]
    return f"{', '.join(first)} {word} {last}" if first else last


def signed(value: float, digits: int = 3) -> str:
    """Return a number as a person reads it, with a plus where it is more than nil."""
    return ("+" if value > 0 else "") + figures(value, digits)


def probable(chance: object) -> str:
    """Return a probability as percent; the largest that is stated as a bound."""
    from rcc_sim.diagnose.judge.chances import SUREST

    if isinstance(chance, int | float) and chance >= SUREST:
        return "> 99 %"
    return percent(chance)


def percent(share: object, digits: int = 2) -> str:
    """Return a share as percent; small ones with a decimal, never more than known."""
    if not isinstance(share, int | float) or share != share:
        return "–"
    value = 100 * float(share)
    if 0 < abs(value) < LEAST:
        return f"< {LEAST:g} %"
    if 99.95 <= value < 100:
        return "> 99.9 %"
    if 99 <= abs(value) < 100:
        text = f"{value:.1f}"
    else:
        text = f"{value:.0f}" if abs(value) >= 10 else f"{value:.{digits}g}"
    return f"{text} %".replace("-", "−")


def rounded(x: float, places: int) -> str:
    """Return a figure with its sign, but no minus before nil.

    >>> rounded(-1.25, 1), rounded(-1e-9, 1)
    ('−1.2', '+0.0')
    """
    return f"{round(x, places) + 0.0:+.{places}f}".replace("-", "−")


BARS = "▁▂▃▄▅▆▇█"
"""Heights of a sparkline, least first."""


def sparkline(values: Sequence[float], width: int) -> str:
    """Return values as one line of bars, each the largest of its stretch.

    The least value is the lowest bar and the largest the highest; a stretch without a
    value is a space.

    >>> sparkline([0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0], 8)
    '▁▂▃▄▅▆▇█'
    """
    good = [v for v in values if v == v]
    if not good or width < 1:
        return ""
    low, size = min(good), (max(good) - min(good)) or 1.0
    count = min(width, len(values))
    edges = [k * len(values) // count for k in range(count + 1)]
    told = ""
    for a, b in pairwise(edges):
        part = [v for v in values[a:b] if v == v]
        told += BARS[int((max(part) - low) / size * 7.999)] if part else " "
    return told
