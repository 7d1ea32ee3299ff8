"""ASAM MDF 4 (.mf4) and 3 (.mdf): one clock a channel group."""

from __future__ import annotations

import gc
import sys
import traceback
from typing import IO, Any

import numpy as np

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
from rcc_sim.readers.extras import BROKEN, broken_file, library
from rcc_sim.readers.log import Array, Log, Mapped
from rcc_sim.readers.own import UNITLESS
from rcc_sim.source import Source
from rcc_sim.units import unit_of

NAME = "mf4"
SUMMARY = "ASAM MDF (.mf4); needs rccsim[mf4]"

MARKS = (b"MDF     ", b"UnFinMF ")


def sniff(source: Source) -> bool:
    """Whether it begins as MDF does, finished or not."""
    return source.head.startswith(MARKS)


def read(source: Source, columns: ColumnMap | None = None) -> Log:
    """Read the channels that are ours by name, or those that the map names.

    Raises
    ------
    InputError
        If the library is missing, the file is broken, or no channel is known.
    """
    asammdf = library("asammdf", "mf4", source.name)
    errors = library("asammdf.blocks.utils", "mf4", source.name)
    report = Report()
    with (
        broken_file(source.name, "MDF file", errors.MdfException),
        source.unpacked_path(".mf4") as path,
        path.open("rb") as raw,
        _opened(asammdf, raw, errors.MdfException) as file,
    ):
        names = list(file.channels_db)
        clocks = set(file.masters_db.values())
        masters = {
            name
            for name, places in file.channels_db.items()
            if any(file.masters_db.get(g) == k for g, k in places)
        }
        channels = [n for n in names if n not in masters or len(clocks) == 0]
        by = columns or matching(shipped_maps(), channels)
        if by is None:
            kept = [n for n in channels if _is_ours(n)]
        else:
            kept = list(
                dict.fromkeys(n for w in by.wanted() if (n := find(channels, w)))
            )
        if not kept:
            raise InputError(
                f"{source.name}: no channel that is known",
                f"name yours with --map; it has {', '.join(channels[:40]) or 'none'}",
            )
        report.dropped += [n for n in channels if n not in kept]
        read, seconds = _channels(source.name, file, kept, report)
    if by is None:
        report.mapped += [Mapped(n, n) for n in read]
        found = [(n, c.clock, c.values) for n, c in read.items()]
    else:
        report.notes += [f"column map {by.name}", *by.notes]
        found = mapped_columns(read, channels, by, report)
    found = [(n, k, v) for n, k, v in found if n != "time_s"]
    return finished(
        source.name, assembled(found, seconds) if found else {}, NAME, report
    )


def _channels(
    where: str, file: Any, names: list[str], report: Report
) -> tuple[dict[str, Column], list[Array | None]]:
    """Channels by name, each with the number of its clock; and the clocks. [s]"""
    groups: dict[int, int] = {}
    clocks: list[Array | None] = []
    found: dict[str, Column] = {}
    for name in names:
        places = file.channels_db[name]
        if len(places) > 1:
            report.guessed.append(
                f"{name}: in {len(places)} groups: that of the first is taken"
            )
        group, index = places[0]
        signal = file.get(group=group, index=index)
        if signal.samples.dtype.kind not in "fiub" or signal.samples.ndim != 1:
            raise InputError(f"{where}: {name}: should be numbers")
        if group not in groups:
            groups[group] = len(clocks)
            clocks.append(np.array(signal.timestamps, dtype=float))
        found[name] = Column(np.array(signal.samples, dtype=float), groups[group])
    return found, clocks


def _opened(asammdf: Any, raw: IO[bytes], broken: type[Exception]) -> Any:
    """An open file; a half-made one is buried here, as it would cry on stderr later."""
    try:
        return asammdf.MDF(raw)
    except (*BROKEN, broken) as error:
        hook = sys.unraisablehook
        sys.unraisablehook = lambda _: None
        try:
            traceback.clear_frames(error.__traceback__)
            gc.collect()
        finally:
            sys.unraisablehook = hook
        raise


def _is_ours(name: str) -> bool:
    return unit_of(name) != "1" or name in UNITLESS
