"""What a run to drive next is expected to tell, in words."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from math import ceil, exp
from typing import Any

from rcc_sim.diagnose.causes.cause import TIED
from rcc_sim.report.text import figures, listed, percent

CERTAIN = 1000.0
"""Nats beyond which it is the model's error that decides, and no number more is said.
"""

LEAST = 0.05
"""Nats below which two causes do not part at all."""


def promise(run: Mapping[str, Any], name: Callable[[str], str] = str) -> str:
    """Return what a run parts, and what not, or how far it narrows an interval.

    Parameters
    ----------
    run : mapping
        One of ``next_experiment`` of a diagnosis' JSON.
    name : callable
        What to call an effect of some id.
    """
    told = run["expected_nats"]
    about = ", ".join(map(name, run["separates"]))
    each = [p["nats"] for p in told["pairs"]]
    if not each:
        left = percent(exp(-told["least"]))
        return f"narrows the interval of {about} to {left} of its width"
    alike = [(p["a"], p["b"]) for p in told["pairs"] if p["nats"] < TIED]
    together = [listed([*map(name, group)]) for group in groups(alike)]
    parted = [nats for nats in each if nats >= TIED]
    if not parted:
        most = max(each)
        times = f": {ceil(TIED / most)} such runs would do" if most >= LEAST else ""
        return f"parts {about} by {_expected(most)} nats{times}"
    least, most = _expected(min(parted)), _expected(max(parted))
    nats = f"{least} nats" if least == most else f"{least} to {most} nats"
    parts = f"parts {about} by {nats}"
    if together:
        return f"{parts}, but leaves {'; '.join(together)} together"
    return parts + (", any two" if len(each) > 1 else "")


def _expected(nats: float) -> str:
    """Return nats by which two causes would part: by noise alone, so not beyond all."""
    if nats < LEAST:
        return "0"
    if nats < 1:
        return figures(nats, 1)
    return f"{nats:.0f}" if nats < CERTAIN else f"over {CERTAIN:.0f}"


def groups(pairs: Sequence[tuple[str, str]]) -> list[list[str]]:
    """Return what pairs hold together: a group of those that all do, else the pairs.

    >>> groups([("a", "b"), ("b", "c"), ("a", "c"), ("d", "e"), ("e", "f")])
    [['a', 'b', 'c'], ['d', 'e'], ['e', 'f']]
    """
    alike = {frozenset(pair) for pair in pairs}
    names = list(dict.fromkeys(name for pair in pairs for name in pair))
    found: list[list[str]] = []
    for first in names:
        group = [first]
        for other in names:
            if all({one, other} in alike for one in group):
                group.append(other)
        if len(group) > 1 and not any(set(group) <= set(known) for known in found):
            found.append(sorted(group, key=names.index))
    return found
