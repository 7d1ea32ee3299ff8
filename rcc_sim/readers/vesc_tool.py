"""The CSV that VESC Tool writes ("RT data")."""

from __future__ import annotations

from rcc_sim.readers import plain_csv
from rcc_sim.readers.column_map import ColumnMap, load_map
from rcc_sim.readers.csv_table import text_table
from rcc_sim.readers.log import Log
from rcc_sim.source import Source

NAME = "vesc_tool"
SUMMARY = "VESC Tool's realtime CSV"


def sniff(source: Source) -> bool:
    """Whether the header is VESC Tool's."""
    if not source.head.lstrip(b"\xef\xbb\xbf").startswith(b"ms_today"):
        return False
    table = text_table(source)
    return table is not None and set(load_map(NAME).header) <= set(table.names)


def read(source: Source, columns: ColumnMap | None = None) -> Log:
    """Read it by the shipped map, or by the one given.

    Raises
    ------
    InputError
        As `plain_csv.read` does.
    """
    from dataclasses import replace

    log = plain_csv.read(source, columns or load_map(NAME))
    return replace(log, reader=NAME)
