"""The errors a user can cause, and the checks that raise them."""

from __future__ import annotations

import errno
import math
from collections.abc import Iterable, Sequence
from pathlib import Path

BEGUN = 3
"""Letters with which a name begins that is meant by another."""

LONGEST = 20.0
"""Longest length that a bench test of a vehicle has. [m]"""


class RccError(Exception):
    """Base of every error that rccsim raises on purpose.

    Parameters
    ----------
    message : str
        Where, what must hold, what was found: ``FILE: KEY: rule: value``.
    hint : str
        How to put it right; empty where there is nothing useful to say.
    """

    exit_code = 2

    def __init__(self, message: str, hint: str = "") -> None:
        super().__init__(message)
        self.hint = hint


def not_written(
    path: Path, error: OSError, full: str = "nothing was written"
) -> InputError:
    """Return the error of a file that the system did not let be written.

    ``full`` is what to say where there is no room for it.
    """
    hint = {
        errno.ENOENT: f"there is no folder {path.parent}",
        errno.ENOSPC: f"the disk is full; {full}",
    }.get(error.errno or 0, "")
    reason = error.strerror or error
    return InputError(f"{path}: cannot be written: {reason}", hint)


def did_you_mean(name: str, known: Iterable[str], table: str = "") -> str:
    """Return a hint for a name that is not known: the nearest, else all there are.

    The nearest is written as the user would write it, with what stands before it.
    """
    names = list(known)
    near = nearest(name, names)
    return f"did you mean `{table}{near}`?" if near else f"there are {', '.join(names)}"


def nearest(name: str, names: Sequence[str]) -> str:
    """Return the one name that goes on as this does, else the most alike, or none.

    First of those that begin alike: who shortens a name keeps that of it.
    """
    from difflib import get_close_matches

    longer = [known for known in names if known.startswith(f"{name}_")]
    if len(longer) == 1:
        return longer[0]
    begun = [known for known in names if known[:BEGUN] == name[:BEGUN]]
    alike = (get_close_matches(name, some, n=1, cutoff=0.6) for some in (begun, names))
    return next(("".join(one) for one in alike if one), "")


def nearest_first(name: str, names: Sequence[str], rest: str) -> str:
    """Return a hint that begins with the nearest of some names, if there is one."""
    near = nearest(name, names)
    return f"did you mean {near}? {rest}" if near else rest


class InputError(RccError):
    """Something that the user gave is wrong: a file, a key, a row, an option."""


class CheckFailed(RccError):
    """A check that was asked for failed (exit code 1)."""

    exit_code = 1


class LedgerError(CheckFailed):
    """An energy ledger does not close: the run cannot be trusted."""


def require_metres(**lengths: object) -> None:
    """Raise if a length of a bench test is not believable: millimetres, likely.

    Raises
    ------
    InputError
        Naming the first above 20 m.
    """
    for name, value in lengths.items():
        for number in value if hasattr(value, "__iter__") else (value,):
            if number > LONGEST:
                raise InputError(
                    f"{name}: should be below {LONGEST:g} m: {number:g}",
                    f"metres are meant; {number:g} mm would be {number / 1000:g}",
                )


def require_positive(**values: object) -> None:
    """Raise unless every value, scalar or sequence, is finite and positive.

    Raises
    ------
    InputError
        Naming the first argument that is not, and the number found.
    """
    for name, value in values.items():
        for number in value if hasattr(value, "__iter__") else (value,):
            if not (math.isfinite(number) and number > 0):
                raise InputError(f"{name}: should be finite and positive: {number:g}")
