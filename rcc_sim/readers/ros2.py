"""ROS 2 bags: a folder with metadata.yaml, an MCAP file, an sqlite3 file."""

from __future__ import annotations

from rcc_sim.errors import InputError
from rcc_sim.readers.bag import read_bag
from rcc_sim.readers.column_map import ColumnMap
from rcc_sim.readers.log import Log
from rcc_sim.source import Source

NAME = "ros2"
SUMMARY = "ROS 2 bag: folder, .mcap or .db3; needs rccsim[ros]"

MARKS = {b"\x89MCAP0\r\n": ".mcap", b"SQLite format 3\0": ".db3"}


def sniff(source: Source) -> bool:
    """Whether it begins as MCAP or sqlite3 does, or is a folder with metadata.yaml."""
    if source.path is not None and source.path.is_dir():
        return (source.path / "metadata.yaml").is_file()
    return _suffix(source) is not None


def read(source: Source, columns: ColumnMap | None = None) -> Log:
    """Read it by the map, or by the shipped map of its topics.

    Raises
    ------
    InputError
        As in `read_bag`.
    """
    if source.path is not None and source.path.is_dir():
        return read_bag(source.path, source.name, NAME, columns)
    suffix = _suffix(source)
    if suffix is None:
        raise InputError(f"{source.name}: neither MCAP nor sqlite3 nor a bag's folder")
    with source.unpacked_path(suffix) as path:
        return read_bag(path, source.name, NAME, columns)


def _suffix(source: Source) -> str | None:
    return next((s for mark, s in MARKS.items() if source.head.startswith(mark)), None)
