"""Bags of ROS 1 and ROS 2: topics to columns. One clock a topic."""

from __future__ import annotations

import re
from array import array
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from operator import attrgetter
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rcc_sim.errors import InputError
from rcc_sim.readers.build import (
    Column,
    Report,
    assembled,
    find,
    finished,
    mapped_columns,
)
from rcc_sim.readers.column_map import ColumnMap, matching, shipped_maps
from rcc_sim.readers.extras import broken_file, library
from rcc_sim.readers.log import Array, Flaw, Log
from rcc_sim.readers.reach import reach
from rcc_sim.readers.ros_messages import typestores
from rcc_sim.units import G

SANE_LAG = 60.0
"""Most that a message's own stamp may be from its receipt to be believed. [s]"""

IMU = re.compile(r"^(.*:(?:.*\.)?)(linear_acceleration|angular_velocity)\.([xyz])$")


@dataclass
class Topic:
    """Messages of one topic, as they are read.

    Parameters
    ----------
    fields : tuple of str
        What to take of each message.
    received, stamped : array of int
        When it was recorded, and its own stamp, 0 where it has none. [ns]
    values : array of float
        The fields' values, message after message.
    """

    fields: tuple[str, ...]
    received: array[int] = field(default_factory=lambda: array("q"))
    stamped: array[int] = field(default_factory=lambda: array("q"))
    values: array[float] = field(default_factory=lambda: array("d"))


def read_bag(path: Path, where: str, reader: str, columns: ColumnMap | None) -> Log:
    """Read a bag by the map, or by the shipped map that its topics match best.

    Raises
    ------
    InputError
        If the library is missing, the bag is broken or not indexed, or it has none of
        the topics that the map names.
    """
    highlevel = library("rosbags.highlevel.anyreader", "ros", where)
    from rosbags.highlevel.anyreader import AnyReaderError
    from rosbags.rosbag1 import ReaderError as Error1
    from rosbags.rosbag2 import ReaderError as Error2
    from rosbags.serde import SerdeError
    from rosbags.typesys.base import TypesysError

    sqlite = library("apsw", "ros", where)
    kinds = (AnyReaderError, Error1, Error2, SerdeError, TypesysError, sqlite.Error)
    far = reach(path)
    hint = "if its recording was cut off: `rosbag reindex` or `ros2 bag reindex`"
    hint = f"{far}: `rosbag reindex` or `ros2 bag reindex` keeps it" if far else hint
    report = Report()
    with broken_file(where, "bag", *kinds, hint=hint):
        bag = highlevel.AnyReader([path], default_typestore=typestores()[0])
        with bag:
            by = columns or _map_of(bag.topics)
            topics = _wanted(bag, by, report, where)
            _collect(bag, topics, report, kinds)
    report.notes.insert(0, f"column map {by.name}")
    report.notes += by.notes
    return _log(where, reader, topics, by, report)


def _map_of(topics: Iterable[str]) -> ColumnMap:
    maps = {m.name: m for m in shipped_maps() if m.format == "bag"}
    return matching(list(maps.values()), list(topics)) or maps["f1tenth"]


def _wanted(bag: Any, by: ColumnMap, report: Report, where: str) -> dict[str, Topic]:
    """Topics to read, and the fields of each; the others are dropped."""
    fields: dict[str, dict[str, None]] = {}
    for name in by.wanted():
        pattern, _, path = name.partition(":")
        topic = find(list(bag.topics), pattern)
        if topic:
            fields.setdefault(topic, {})[path] = None
    # z tells in which unit an IMU counts
    for topic, paths in fields.items():
        for path in list(paths):
            if path.endswith("linear_acceleration.x"):
                fields[topic] |= dict.fromkeys([path[:-1] + "y", path[:-1] + "z"])
    kept = {topic: Topic(tuple(paths)) for topic, paths in fields.items()}
    for topic, info in bag.topics.items():
        if topic not in kept:
            report.dropped.append(f"{topic} ({info.msgtype}, {info.msgcount})")
    if not kept:
        raise InputError(
            f"{where}: no topic that the map {by.name} names",
            f"it has {', '.join(bag.topics) or 'none'}; name yours with --map",
        )
    return kept


def _collect(
    bag: Any,
    topics: dict[str, Topic],
    report: Report,
    kinds: tuple[type[Exception], ...],
) -> None:
    """Read the messages; a topic whose messages cannot be read is dropped, and said."""
    getters: dict[str, Callable[[Any], tuple[float, ...]]] = {}
    failed: dict[str, str] = {}
    unreadable: tuple[type[Exception], ...] = (*kinds, KeyError, AssertionError)
    chosen = [c for c in bag.connections if c.topic in topics]
    for connection, stamp, raw in bag.messages(connections=chosen):
        name = connection.topic
        if name in failed:
            continue
        topic = topics[name]
        try:
            message = _message(bag, raw, connection.msgtype)
        except unreadable as error:
            failed[name] = f"{connection.msgtype}: {str(error)[:80]}"
            continue
        if name not in getters:
            topic.fields = tuple(f for f in topic.fields if _has(message, f))
            if not topic.fields:
                failed[name] = f"{connection.msgtype}: has none of the map's fields"
                continue
            getters[name] = _getter(topic.fields)
        topic.received.append(stamp)
        topic.stamped.append(_own_stamp(message))
        topic.values.extend(getters[name](message))
    for name, why in failed.items():
        topics.pop(name)
        what = f"messages of a type that cannot be read: {why}"
        report.flaws.append(Flaw("unreadable", name, what, "left out", severe=True))
        report.dropped.append(name)


def _message(bag: Any, raw: bytes, kind: str) -> Any:
    """A message; where the bag does not say the layout, by each that is known."""
    from rosbags.highlevel.anyreader import AnyReaderError as Unreadable

    try:
        return bag.deserialize(raw, kind)
    except (KeyError, Unreadable):
        if not bag.is2 or not kind.startswith("vesc_msgs/"):
            raise
        return typestores()[1].deserialize_cdr(raw, kind)


def _own_stamp(message: Any) -> int:
    header = getattr(message, "header", None)
    if header is None:
        return 0
    return int(header.stamp.sec) * 1_000_000_000 + int(header.stamp.nanosec)


def _has(message: Any, path: str) -> bool:
    try:
        _getter((path,))(message)
    except (AttributeError, IndexError, TypeError, ValueError):
        return False
    return True


def _getter(fields: tuple[str, ...]) -> Callable[[Any], tuple[float, ...]]:
    parts = [_one(path) for path in fields]
    return lambda message: tuple(float(part(message)) for part in parts)


def _one(path: str) -> Callable[[Any], float]:
    if path.endswith(".yaw"):
        turn = attrgetter(path.removesuffix(".yaw"))
        return lambda message: _yaw(turn(message))
    found = re.fullmatch(r"(.*)\[(\d+)\]", path)
    if found:
        whole, place = attrgetter(found[1]), int(found[2])
        return lambda message: whole(message)[place]
    return attrgetter(path)


def _yaw(q: Any) -> float:
    """Yaw of a quaternion. [rad]"""
    return float(
        np.arctan2(2 * (q.w * q.z + q.x * q.y), 1 - 2 * (q.y * q.y + q.z * q.z))
    )


def _log(
    where: str, reader: str, topics: dict[str, Topic], by: ColumnMap, report: Report
) -> Log:
    full = {name: topic for name, topic in topics.items() if topic.received}
    for name in topics.keys() - full.keys():
        report.notes.append(f"{name}: no message")
    if not full:
        raise InputError(f"{where}: no message on any topic of the map {by.name}")
    clocks: list[NDArray[np.int64]] = [
        _clock(name, topic, report) for name, topic in full.items()
    ]
    start = min(int(clock.min()) for clock in clocks)
    base = start - start % 1_000_000_000 if start > 10**14 else 0
    if base:
        report.notes.append(f"time_s 0 is stamp {base // 1_000_000_000} s")
    columns: dict[str, Column] = {}
    for k, (name, topic) in enumerate(full.items()):
        values = np.array(topic.values).reshape(len(topic.received), -1)
        for place, path in enumerate(topic.fields):
            columns[f"{name}:{path}"] = Column(values[:, place].copy(), clock=k)
    _mend_imu(columns, report)
    names = list(columns)
    found = mapped_columns(columns, names, by, report)
    seconds: list[Array | None] = [(clock - base) / 1e9 for clock in clocks]
    table = assembled(found, seconds) if found else {}
    if len({clock for _, clock, _ in found}) > 1:
        report.notes.append(
            "each topic keeps its own stamps: a row is blank where a topic has no value"
        )
    return finished(where, table, reader, report)


def _clock(name: str, topic: Topic, report: Report) -> NDArray[np.int64]:
    """Stamps of a topic: the messages' own where they are sound, else their receipt."""
    received = np.array(topic.received, dtype=np.int64)
    stamped = np.array(topic.stamped, dtype=np.int64)
    if not stamped.any():
        return received
    lag = (received - stamped) / 1e9
    if (stamped < 0).any() or np.abs(lag).max() > SANE_LAG:
        report.notes.append(f"{name}: its own stamps are not sound: receipt is taken")
        return received
    if np.median(lag) > 0.005:
        report.notes.append(f"{name}: recorded {np.median(lag):.3g} s after its stamps")
    return stamped


def _mend_imu(columns: dict[str, Column], report: Report) -> None:
    """Turn an IMU that counts in g and deg/s, as VESCs do, into SI; and say so."""
    heads = {m[1] for name in columns if (m := IMU.match(name))}
    for head in sorted(heads):
        keys = [f"{head}linear_acceleration.{axis}" for axis in "xyz"]
        if not all(key in columns for key in keys):
            continue
        x, y, z = (columns[key].values for key in keys)
        size = np.hypot(np.hypot(x, y), z)
        if not 0.5 < float(np.nanmedian(size)) < 2.0:
            continue
        report.guessed.append(
            f"{head.rstrip(':')}: acceleration is about 1 at rest: g and deg/s, not SI"
        )
        for name, column in list(columns.items()):
            found = IMU.match(name)
            if found and found[1] == head:
                scale = G if found[2] == "linear_acceleration" else np.pi / 180
                columns[name] = Column(column.values * scale, column.clock)
