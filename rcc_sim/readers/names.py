"""Names of columns that a map gives: whether anything reads them."""

from __future__ import annotations

from collections.abc import Mapping
from difflib import get_close_matches
from typing import Any

from rcc_sim.errors import InputError, did_you_mean

ALSO_READ = (
    *("current_d_a", "current_q_a", "voltage_d_v", "voltage_q_v"),
    *("x_m", "y_m", "yaw_rad", "direction", "on_stand"),
)
"""Columns that are read and that no header is known by."""

NEARLY = 0.8
"""How alike a name is, at least, to one that is read if it is a misspelt one."""


def unread(columns: Mapping[str, Any]) -> list[str]:
    """Return what to know of names that nothing reads and that are nearly read."""
    from rcc_sim.readers.suggest import MEANINGS

    names = [*(m.column for m in MEANINGS), *ALSO_READ]
    near = {n: get_close_matches(n, names, n=1, cutoff=NEARLY) for n in columns}
    return [
        f"columns.{name}: nothing reads it; did you mean {close[0]}?"
        for name, close in near.items()
        if close and name not in names
    ]


def refuse_unfinished(column: str, key: str) -> None:
    """Raise if a name is one that is read, but for its unit: nothing would read it."""
    from rcc_sim.readers.suggest import MEANINGS

    names = [m.column for m in MEANINGS]
    meant = [name for name in names if name.startswith(f"{column}_")]
    if meant and column not in names:
        what = f"{key}: should end in its unit, or nothing reads it"
        raise InputError(what, did_you_mean(column, meant))
