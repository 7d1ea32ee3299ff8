"""What the energy of rows that no fit saw says of causes."""

from __future__ import annotations

from math import inf

SHRUNK, NO_ENERGY = 1 / 3, 1.5
"""Share to which the energy gap, and what is beyond noise, have to shrink on rows that
no fit saw; size below which the first need not. [1], [%]"""

TELLS_NOTHING = 1.9
"""Width of an interval of what is gone, from -1 to 1 at most, that tells nothing."""


def grew(before: float, after: float) -> bool:
    """Tell whether an energy gap [%] is larger than before, beyond what is none."""
    return abs(after) > abs(before) + NO_ENERGY


def stays_off(
    before: float | None, after: float | None, noise: float = inf, *, doubtless: bool
) -> bool:
    """Tell whether an energy gap [%] does not shrink to a third, or grows.

    One that is not ``doubtless`` need not, where no more than ``noise`` [%] is left.
    """
    if before is None or after is None:
        return False
    asked = doubtless or abs(after) > noise
    stays = asked and abs(after) > max(SHRUNK * abs(before), NO_ENERGY)
    return stays or grew(before, after)


def proves_nothing(explained: float, before: float | None, after: float | None) -> bool:
    """Tell whether causes do nothing for rows that no fit saw: they are withdrawn.

    Neither what is beyond noise row by row (``explained``, a share) shrinks by a third
    there, nor an energy gap [%] that is beyond doubt, from ``before`` to ``after``.
    """
    if before is None or after is None or explained >= SHRUNK:
        return False
    return abs(after) > (1 - SHRUNK) * abs(before)


def worsens(before: float | None, after: float | None, noise: float) -> bool:
    """Tell whether causes open an energy gap on rows that no fit saw: they are refuted.

    It was smaller, and is beyond what ``noise`` may do: what tolerances may, the fit
    has taken out. Of 71 drives of the blind plant, around four vehicles, with causes
    that act, two were left with more than that, and no gap grew. [%]
    """
    if before is None or after is None:
        return False
    return grew(before, after) and abs(after) > noise
