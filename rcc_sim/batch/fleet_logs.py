"""Which logs a fleet has: folders, patterns, files, and lists of logs."""

from __future__ import annotations

import csv
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TextIO

from rcc_sim.batch.store import is_rows
from rcc_sim.errors import InputError

SUFFIXES = (
    *(".csv", ".csv.gz", ".parquet"),
    *(".mcap", ".bag", ".mf4", ".mdf", ".db3"),
)
"""Files of a folder that are taken for logs."""

MARKS = "*?["
"""What makes a name a pattern."""

BAG = "metadata.yaml"
"""What a folder that is one ROS 2 bag holds."""

LOG, VEHICLE = "log", "vehicle"
"""Columns of a list that mean something to a fleet; others are labels."""


@dataclass(frozen=True)
class Entry:
    """A log of a fleet.

    Parameters
    ----------
    log : str
        Path.
    vehicle : str
        Name or file of its model; empty where the fleet's own holds.
    labels : mapping
        What a list says of it beside: a number or a word each.
    """

    log: str
    vehicle: str = ""
    labels: Mapping[str, str | float] = field(default_factory=dict)


def is_many(name: str) -> bool:
    """Tell whether a name stands for several logs: a folder, or a pattern."""
    path = Path(name)
    if path.is_dir():
        return not (path / BAG).is_file()
    return any(mark in name for mark in MARKS) and not path.exists()


def logs_of(names: Iterable[str]) -> tuple[str, ...]:
    """Return the logs that paths, folders and patterns name, sorted, each once.

    What a batch wrote into a folder is none of its logs.

    Raises
    ------
    InputError
        If a folder or a pattern holds none.
    """
    found: dict[str, None] = {}
    for name in names:
        path = Path(name).expanduser()
        if path.is_dir() and not (path / BAG).is_file():
            here = [p for p in _in_folder(path) if not is_rows(p)]
        elif is_many(name):
            root = Path(path.anchor) if path.is_absolute() else Path()
            every = root.glob(str(path.relative_to(path.anchor)))
            here = [p for p in every if not is_rows(p)]
        else:
            here = [path]
        if not here:
            what = "the folder holds" if path.is_dir() else "the pattern matches"
            raise InputError(f"{name}: {what} no logs", f"{', '.join(SUFFIXES)} are")
        found |= dict.fromkeys(sorted(str(p) for p in here))
    return tuple(found)


def _in_folder(folder: Path) -> list[Path]:
    bags = {p.parent for p in folder.rglob(BAG)}
    files = [
        p
        for p in folder.rglob("*")
        if p.name.lower().endswith(SUFFIXES)
        and p.is_file()
        and not p.name.startswith(".")
        and bags.isdisjoint(p.parents)
    ]
    return [*bags, *files]


def entries_of(names: Sequence[str], lists: TextIO | None = None) -> tuple[Entry, ...]:
    """Return the logs that are named, and those of a list, each once.

    Raises
    ------
    InputError
        If there is none, or the list is not one.
    """
    found = {log: Entry(log) for log in logs_of(names)}
    if lists is not None:
        found |= {entry.log: entry for entry in read_list(lists)}
    if not found:
        raise InputError("no logs", "name a folder, a pattern, files, or a --list")
    return tuple(found.values())


def read_list(file: TextIO) -> list[Entry]:
    """Return the logs of a list: a path a line, or CSV with a column ``log``.

    A column ``vehicle`` names the model of each; further columns are labels that its
    row keeps, such as ``car``, ``date``, ``ambient_temperature_degc``.

    Raises
    ------
    InputError
        Naming the line, if it has no log or other cells than the header.
    """
    where = getattr(file, "name", "list")
    try:
        lines = [line for line in file.read().splitlines() if line.strip()]
    except UnicodeDecodeError:
        raise InputError(f"{where}: not text in UTF-8") from None
    if not lines:
        raise InputError(f"{where}: the list is empty", "a path a line")
    header = [name.strip() for name in next(csv.reader([lines[0]]))]
    if LOG not in header:
        return [Entry(line.strip()) for line in lines]
    if len(set(header)) < len(header) or "" in header:
        raise InputError(f"{where}: line 1: should name each column once: {lines[0]}")
    return _labelled(where, header, list(csv.reader(lines[1:])))


def _labelled(where: str, header: list[str], rows: list[list[str]]) -> list[Entry]:
    for k, row in enumerate(rows):
        if len(row) != len(header) or not row[header.index(LOG)].strip():
            raise InputError(
                f"{where}: line {k + 2}: should have a log and {len(header)} cells: "
                f"{','.join(row)}"
            )
    if not rows:
        raise InputError(f"{where}: the list is empty", "a log a line after the header")
    cells = {name: [row[k].strip() for row in rows] for k, name in enumerate(header)}
    labels = {
        name: _typed(words)
        for name, words in cells.items()
        if name not in (LOG, VEHICLE)
    }
    return [
        Entry(
            cells[LOG][k],
            cells[VEHICLE][k] if VEHICLE in cells else "",
            {name: values[k] for name, values in labels.items() if values[k] != ""},
        )
        for k in range(len(rows))
    ]


def _typed(words: list[str]) -> Sequence[str | float]:
    """Return a column as numbers where every cell that is there is one."""
    numbers: list[str | float] = []
    for word in words:
        try:
            number = float(word) if word else math.nan
        except ValueError:
            return words
        if word and not math.isfinite(number):
            return words
        numbers.append(number if word else "")
    return numbers
