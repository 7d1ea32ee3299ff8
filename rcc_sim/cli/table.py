"""Tables for a person: whole numbers, whatever the width of the terminal."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import IO, Any, NoReturn

FEW = 60
"""Rows that are shown in full."""

FIRST = 20
"""Rows that are shown of more than that."""

NARROW = 12
"""Least width that text is folded to."""

NOTHING = "–"
"""How a cell without a value reads; downwards it is left out."""

GAP = 2
"""Blanks between columns."""


def print_table(
    rows: Sequence[Mapping[str, Any]],
    title: str,
    readable: Any,
    printable: Any,
    file: IO[str] | None = None,
) -> None:
    """Print rows to the terminal, or a file; one downwards, many only in part.

    Columns without any entry are left out. A number is never cut: text is folded
    first, and where that does not do, each row is printed downwards.
    """
    from rich.console import Console
    from rich.text import Text

    console = Console(file=file)
    console.on_broken_pipe = _broken_pipe  # type: ignore[method-assign]
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


def _broken_pipe() -> NoReturn:
    """Let a pipe that was closed early end the program as any other output does."""
    raise BrokenPipeError


def _is_numeric(rows: Sequence[Mapping[str, Any]], key: str) -> bool:
    values = [row[key] for row in rows if row.get(key) is not None]
    return bool(values) and all(
        isinstance(v, int | float) and not isinstance(v, bool) for v in values
    )


def _fits(
    heads: list[str], cells: list[list[str]], numeric: list[bool], width: int
) -> bool:
    columns = zip(heads, zip(*cells, strict=True), numeric, strict=True)
    return sum(GAP + _least(*column) for column in columns) - GAP <= width


def _least(head: str, cells: Sequence[str], numeric: bool) -> int:
    """Return the least width of a column: no number and no word is cut."""
    longest = max(len(cell) for cell in cells)
    if not numeric:
        words = (len(word) for cell in cells for word in cell.split())
        longest = max(min(longest, NARROW), max(words, default=0))
    return max(longest, *(len(part) for part in _parts(head)))


def _parts(head: str) -> list[str]:
    """Return where a long heading may be broken: after an underscore, or at a space.

    >>> _parts("ratio_or_scale"), _parts("time_s")
    (['ratio_', 'or_', 'scale'], ['time_s'])
    """
    if len(head) <= NARROW:
        return [head]
    return head.replace("_", "_ ").split() or [""]


def _broken(head: str, width: int) -> list[str]:
    """Return a heading in lines that fit a width."""
    lines = [""]
    for part in _parts(head):
        if lines[-1] and len(lines[-1]) + len(part) > width:
            lines.append("")
        lines[-1] += part
    return lines


def _across(
    console: Any, heads: list[str], cells: list[list[str]], numeric: list[bool]
) -> None:
    import textwrap

    from rich.text import Text

    columns = list(zip(*cells, strict=True))
    widths = [_least(*c) for c in zip(heads, columns, numeric, strict=True)]
    for k in (k for k, is_number in enumerate(numeric) if not is_number):
        spare = console.width - sum(widths) - GAP * (len(widths) - 1)
        longest = max(len(cell) for cell in (heads[k], *columns[k]))
        widths[k] += max(min(spare, longest - widths[k]), 0)

    def show(row: list[list[str]], style: str = "") -> None:
        tall = max(len(lines) for lines in row)
        for i in range(tall):
            parts = [
                f"{lines[i] if i < len(lines) else '':{'>' if is_number else '<'}{w}}"
                for lines, w, is_number in zip(row, widths, numeric, strict=True)
            ]
            console.print(Text((" " * GAP).join(parts).rstrip(), style=style))

    broken = [_broken(head, w) for head, w in zip(heads, widths, strict=True)]
    tall = max(len(lines) for lines in broken)
    show([[""] * (tall - len(lines)) + lines for lines in broken], "bold")
    console.print(Text("─" * (sum(widths) + GAP * (len(widths) - 1))))
    for row in cells:
        wrapped = (
            [line for part in cell.split("\n") for line in textwrap.wrap(part, w)]
            for cell, w in zip(row, widths, strict=True)
        )
        show([lines or [""] for lines in wrapped])


def _downwards(console: Any, heads: list[str], cells: list[list[str]]) -> None:
    wide = max(len(head) for head in heads) + 2
    for number, row in enumerate(cells):
        if number:
            console.print()
        known = [cell for cell in row if cell != NOTHING]
        for head, cell in zip(heads, row, strict=True):
            if cell == NOTHING and known:
                continue
            for line in _entry(head, cell, wide, console.width):
                console.print(line, markup=False, highlight=False)


def _entry(head: str, cell: str, wide: int, width: int) -> list[str]:
    """Return a heading and its text beside it; below it, if a word is too long."""
    import textwrap

    room = width - wide
    if max((len(word) for word in cell.split()), default=0) > room:
        return [head, *textwrap.wrap(f"  {cell}", width, subsequent_indent="  ")]
    lines = textwrap.wrap(cell, max(room, 1), break_on_hyphens=False) or [""]
    return [f"{head:{wide}}{lines[0]}", *(" " * wide + line for line in lines[1:])]
