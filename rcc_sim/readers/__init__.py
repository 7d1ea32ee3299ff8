"""Logs as people have them, read into rccsim's own columns."""

from __future__ import annotations

from pathlib import Path
from typing import IO

from rcc_sim.readers.car import with_vehicle
from rcc_sim.readers.column_map import load_map, shipped_maps
from rcc_sim.readers.commands import write_commands
from rcc_sim.readers.log import Flaw, Log, Mapped, on_one_clock
from rcc_sim.readers.plugins import Reader, named, readers, sniffed
from rcc_sim.source import open_source

__all__ = [
    "Flaw",
    "Log",
    "Mapped",
    "Reader",
    "load_map",
    "named",
    "on_one_clock",
    "read_log",
    "readers",
    "shipped_maps",
    "with_vehicle",
    "write_commands",
]


def read_log(
    source: str | Path,
    *,
    reader: str | None = None,
    columns: str | Path | None = None,
    stdin: IO[bytes] | None = None,
) -> Log:
    """Read a log of any format that a reader knows.

    All rows are kept as they are, also where time stands still, jumps or is blank.

    Parameters
    ----------
    source : str or Path
        File, folder (a ROS 2 bag), or ``-`` for stdin; gzip is unpacked.
    reader : str, optional
        Name of the reader; the file's own marks decide unless given.
    columns : str or Path, optional
        Column map: a TOML file, or the name of a shipped one.
    stdin : binary file, optional
        What ``-`` reads.

    Returns
    -------
    log : Log
        Trace, and what was mapped, dropped, guessed.

    Raises
    ------
    InputError
        If it is no log, is broken, or lacks time, channels or rows: naming file, row
        and column.
    """
    place = open_source(source, stdin)
    by = None if columns is None else load_map(columns)
    chosen = named(reader) if reader else sniffed(place, by)
    return chosen.read(place, by)
