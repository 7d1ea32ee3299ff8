"""How far a recording that was cut off is whole."""

from __future__ import annotations

import struct
from pathlib import Path
from typing import IO

ROS1 = b"#ROSBAG V2.0\n"
MCAP = b"\x89MCAP0\r\n"
SQLITE = b"SQLite format 3\0"
CHUNK = 5, 6
"""Codes of a record that holds messages: of ROS 1, of MCAP."""


def reach(path: Path) -> str:
    """Say up to where a bag's file is whole, in words; empty where it is not known.

    Parameters
    ----------
    path : Path
        ROS 1 bag, MCAP file or sqlite3 file, unpacked.
    """
    if not path.is_file():
        return ""
    size = path.stat().st_size
    with path.open("rb") as file:
        head = file.read(32)
        if head.startswith(SQLITE):
            return _pages(head, size)
        if head.startswith(ROS1):
            file.seek(len(ROS1))
            return _records(file, size, ros1=True)
        if head.startswith(MCAP):
            file.seek(len(MCAP))
            return _records(file, size, ros1=False)
    return ""


def _records(file: IO[bytes], size: int, *, ros1: bool) -> str:
    """Step from record to record by their lengths, to the first that is not whole."""
    whole, chunks = file.tell(), 0
    while True:
        found = _ros1(file) if ros1 else _mcap(file)
        if found is None:
            break
        end, has_messages = found
        if end > size:
            break
        chunks += has_messages
        whole = end
        file.seek(end)
    if whole >= size - (0 if ros1 else len(MCAP)):  # MCAP ends in its mark again
        return ""
    share = 100 * whole / max(size, 1)
    return (
        f"whole up to byte {whole} of {size} ({share:.0f} %), {chunks} chunks of "
        "messages; what comes after is cut off"
    )


def _ros1(file: IO[bytes]) -> tuple[int, bool] | None:
    length = file.read(4)
    if len(length) < 4:
        return None
    header = file.read(struct.unpack("<I", length)[0])
    size = file.read(4)
    if len(size) < 4:
        return None
    return file.tell() + struct.unpack("<I", size)[0], b"op=%c" % CHUNK[0] in header


def _mcap(file: IO[bytes]) -> tuple[int, bool] | None:
    head = file.read(9)
    if len(head) < 9:
        return None
    kind, length = struct.unpack("<BQ", head)
    return file.tell() + length, kind == CHUNK[1]


def _pages(head: bytes, size: int) -> str:
    """Compare a database's length with the pages that its header counts."""
    page = struct.unpack(">H", head[16:18])[0]
    page = 65536 if page == 1 else page
    count = struct.unpack(">I", head[28:32])[0]
    if not page or size >= page * count:
        return ""
    return f"{size // page} of its {count} pages are there; the rest is cut off"
