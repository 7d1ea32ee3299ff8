"""Tables for a person: whole numbers, whatever the width of the terminal."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

FEW = 60
"""Rows that are shown in full."""

FIRST = 20
"""Rows that are shown of more than that."""

NARROW = 12
"""Least width that text is folded to."""


def print_table(
    rows: Sequence[Mapping[str, Any]], title: str, readable: Any, printable: Any
) -> None:
    """Print rows to the terminal; a single one downwards, many only in part.

    Columns without any entry are left out. A number is never cut: text is folded
    first, and where that does not do, each row is printed downwards.
    """
    from rich.console import Console
    from rich.text import Text

    console = Console()
    if title:
        console.print(Text(printable(title), style="bold"))
    if not rows:
        console.print(Text("nothing to show"))
        return
    part = rows if len(rows) <= FEW else rows[:FIRST]
    keys = [key for key in rows[0] if any(row[key] not in (None, "") for row in part)]
    cells = [[readable(row[key]) for key in keys] for row in part]
    heads = [printable(key) for key in keys]
    numeric = [_is_numeric(part, key) for key in keys]
    if len(rows) == 1 or not _fits(heads, cells, numeric, console.width):
        _downwards(console, heads, cells)
    else:
        _across(console, heads, cells, numeric)
    if len(part) < len(rows):
        console.print(
            Text(f"... {len(rows) - len(part)} more rows; a pipe or --output has all")
        )


def _is_numeric(rows: Sequence[Mapping[str, Any]], key: str) -> bool:
    values = [row[key] for row in rows if row.get(key) is not None]
    return bool(values) and all(
        isinstance(v, int | float) and not isinstance(v, bool) for v in values
    )


def _fits(
    heads: list[str], cells: list[list[str]], numeric: list[bool], width: int
) -> bool:
    need = 1
    for k, head in enumerate(heads):
        longest = max(len(row[k]) for row in cells)
        words = max(len(word) for word in head.replace("_", "_ ").split())
        need += 3 + max(words, longest if numeric[k] else min(longest, NARROW))
    return need <= width


def _across(
    console: Any, heads: list[str], cells: list[list[str]], numeric: list[bool]
) -> None:
    from rich.table import Table
    from rich.text import Text

    table = Table()
    for k, head in enumerate(heads):
        longest = max(len(row[k]) for row in cells)
        table.add_column(
            Text(head),
            justify="right" if numeric[k] else "left",
            overflow="fold",
            min_width=longest if numeric[k] else min(longest, NARROW),
        )
    for row in cells:
        table.add_row(*(Text(cell) for cell in row))
    console.print(table)


def _downwards(console: Any, heads: list[str], cells: list[list[str]]) -> None:
    from rich.text import Text

    wide = max(len(head) for head in heads)
    for number, row in enumerate(cells):
        if number:
            console.print()
        for head, cell in zip(heads, row, strict=True):
            line = Text(f"{head:{wide}}  ")
            line.append(cell)
            console.print(line)
