"""Where a table's header is, and what it names: titles above it, units below it."""

from __future__ import annotations

import csv
from collections.abc import Sequence
from typing import NamedTuple

from rcc_sim.readers.words import is_number

LOOKED_AT = 40
"""Lines among which a header is looked for."""

SHORT = 10
"""Letters of a unit at most."""


class Header(NamedTuple):
    """The header of a table.

    Attributes
    ----------
    names : list of str
        Each with its unit in brackets where a line of units is below it.
    above, lines : int
        Lines of a title above it, and lines that it takes itself.
    """

    names: list[str]
    above: int
    lines: int


def header_of(lines: Sequence[str], separator: str, *, first: bool = False) -> Header:
    """Return the header of a table whose lines, the first not blank, are given.

    It is the first line unless one below it names more, as under a spreadsheet's
    title: at least two columns, each once, and most of what follows are numbers.
    Under it may stand a line of units. None is looked for below numbers.

    Parameters
    ----------
    lines : sequence of str
        Of the file's start.
    separator : str
        Between fields.
    first : bool
        Whether it is known to be the first.
    """
    rows = [fields_of(line, separator) for line in lines[: LOOKED_AT + 2]]
    for k, names in enumerate(rows[: 1 if first else LOOKED_AT]):
        if k == 0 and any(map(_is_figure, names)):
            break
        below = [row for row in rows[k + 1 :] if any(map(str.strip, row))][:2]
        named = [name.strip() for name in names if name.strip()]
        if len(named) < 2 or len({*named}) < len(named) or any(map(_is_figure, named)):
            continue
        if below and _is_of_numbers(below[0], names):
            return Header(names, k, 1)
        if len(below) == 2 and _are_units(below[0], names):
            if _is_of_numbers(below[1], names):
                return Header(_with_units(names, below[0]), k, 2)
    return Header(rows[0], 0, 1)


def fields_of(line: str, separator: str) -> list[str]:
    """Return the fields of a line."""
    return [
        field.strip() for field in next(csv.reader([line], delimiter=separator), [])
    ]


def _is_figure(word: str) -> bool:
    """Tell whether a word is a number, with either mark of the decimals."""
    return bool(word) and (is_number(word, ".") or is_number(word, ","))


def _is_of_numbers(fields: Sequence[str], names: Sequence[str]) -> bool:
    """Tell whether most of what stands below some names are numbers."""
    under = [f for f, name in zip(fields, names, strict=False) if name and f]
    return 2 * sum(map(_is_figure, under)) > len(under)


def _are_units(fields: Sequence[str], names: Sequence[str]) -> bool:
    if len(fields) != len(names) or not all(names):
        return False
    words = [f for f, name in zip(fields, names, strict=True) if name and f]
    return 2 * len(words) > len(names) and all(
        len(word) <= SHORT and not any(c.isdigit() for c in word.rstrip("²³23"))
        for word in words
    )


def _with_units(names: Sequence[str], units: Sequence[str]) -> list[str]:
    pairs = zip(names, units, strict=True)
    return [f"{name} [{unit}]" if unit.strip("-") else name for name, unit in pairs]
