"""Readers: those shipped, and those of installed plugins (`rccsim.readers`)."""

from __future__ import annotations

from importlib import import_module
from typing import Protocol

from rcc_sim.errors import InputError
from rcc_sim.readers.column_map import ColumnMap
from rcc_sim.readers.csv_table import text_table
from rcc_sim.readers.log import Log
from rcc_sim.source import Source

SHIPPED = ("own", "vesc_tool", "parquet", "ros1", "ros2", "mf4", "plain_csv")
"""Files of this folder, in the order that they are asked."""


class Reader(Protocol):
    """What a reader has: a module with these, or any object.

    A plugin's entry point names one in the group ``rccsim.readers``.
    """

    NAME: str
    SUMMARY: str

    def sniff(self, source: Source) -> bool:
        """Whether it knows this file, by its first block or its name."""
        ...

    def read(self, source: Source, columns: ColumnMap | None = None) -> Log:
        """Read it, by the map where one is given."""
        ...


def readers() -> list[Reader]:
    """Every reader: those of plugins first, as they may know better."""
    from importlib.metadata import entry_points

    points = sorted(entry_points(group="rccsim.readers"), key=lambda p: p.name)
    found: list[Reader] = []
    for point in points:
        try:
            found.append(point.load())
        except (ImportError, AttributeError) as error:
            raise InputError(
                f"plugin {point.name}: its reader cannot be loaded: {error}",
                "reinstall the plugin's package, or uninstall it",
            ) from None
    return found + _shipped()


def named(name: str) -> Reader:
    """Return the reader of a name.

    Raises
    ------
    InputError
        If there is none; lists them.
    """
    found = {reader.NAME: reader for reader in reversed(readers())}
    if name not in found:
        raise InputError(
            f"no such reader: {name!r}", f"there are {', '.join(sorted(found))}"
        )
    return found[name]


def sniffed(source: Source, columns: ColumnMap | None = None) -> Reader:
    """Return the first reader that knows a file.

    With a column map, a text file is read by it even if the header is ours.

    Raises
    ------
    InputError
        If none does.
    """
    for reader in readers():
        if columns is not None and reader.NAME == "rccsim":
            continue
        if reader.sniff(source):
            return reader
    if columns is not None and text_table(source) is not None:
        return named("csv")
    names = ", ".join(reader.NAME for reader in readers())
    what = "a folder" if source.path and source.path.is_dir() else "a file"
    raise InputError(
        f"{source.name}: {what} that no reader knows: not a log",
        f"there are readers for {names}; --reader forces one",
    )


def _shipped() -> list[Reader]:
    return [import_module(f"rcc_sim.readers.{file}") for file in SHIPPED]
