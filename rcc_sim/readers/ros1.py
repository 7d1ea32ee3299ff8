"""ROS 1 bags."""

from __future__ import annotations

from rcc_sim.readers.bag import read_bag
from rcc_sim.readers.column_map import ColumnMap
from rcc_sim.readers.log import Log
from rcc_sim.source import Source

NAME = "ros1"
SUMMARY = "ROS 1 bag (.bag, also .gz); needs rccsim[ros]"


def sniff(source: Source) -> bool:
    """Whether it begins as a ROS 1 bag does."""
    return source.head.startswith(b"#ROSBAG V")


def read(source: Source, columns: ColumnMap | None = None) -> Log:
    """Read it by the map, or by the shipped map of its topics.

    Raises
    ------
    InputError
        As in `read_bag`.
    """
    with source.unpacked_path(".bag") as path:
        return read_bag(path, source.name, NAME, columns)
