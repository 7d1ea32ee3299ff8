"""Cycles by name, by file, and by the user's words for cutting and joining them."""

from __future__ import annotations

import re
from collections.abc import Sequence
from functools import reduce
from pathlib import Path
from typing import TextIO

import numpy as np
from numpy.typing import NDArray

from rcc_sim.channel import sensor_noise
from rcc_sim.definitions import library
from rcc_sim.definitions.cycle.rows import SUFFIXES, Rows, read_rows
from rcc_sim.definitions.cycle.series import Cycle, first_fault, join
from rcc_sim.definitions.library import Entry, Place
from rcc_sim.errors import InputError

V_BELIEVABLE = 120.0
"""Top speed above which a file is taken to be in km/h and refused. [m/s]"""

AT_REST = 5.0
"""Times its noise by which a measured speed may be below nil: a car stands there."""

SYNTAX = "write NAME, NAME[20:125] (s), NAME*3, NAME+NAME, a path, or - for stdin"


def parse_cycle(
    spec: str, stdin: TextIO | None = None, places: Sequence[Place] | None = None
) -> Cycle:
    """Cycle from a user's words.

    ``udds``, ``udds[20:125]`` (seconds from its start), ``udds[20:]``, ``udds*3``,
    ``udds[0:505]+hwfet``, a path, or ``-``. Cuts and repeats apply to the term before
    them, from left to right.

    Parameters
    ----------
    spec : str
        The words. What is as a whole the path of a file is that file.
    stdin : TextIO, optional
        The stream that ``-`` stands for.
    places : sequence of Place, optional
        Folders to search for names; those of `library.folders` unless given.

    Returns
    -------
    cycle : Cycle

    Raises
    ------
    InputError
        If the words make no sense, a name is unknown, or a file is not sound.
    """
    if library.is_path(spec, SUFFIXES) and Path(spec).expanduser().is_file():
        return _read_named(spec, places)
    terms = [_split_term(spec, term) for term in _split_sum(spec)]
    if sum(base == "-" for base, _ in terms) > 1:
        raise InputError(f"{spec}: - should stand there once: stdin is read once")
    parts = []
    for base, operations in terms:
        cycle = _read_stdin(stdin) if base == "-" else _read_named(base, places)
        parts.append(reduce(_apply, operations, cycle))
    return join(*parts) if len(parts) > 1 else parts[0]


def read_cycle(source: str | Path | TextIO, name: str = "", origin: str = "") -> Cycle:
    """Cycle from a CSV file or text stream.

    The header must hold ``time_s`` and ``speed_mps``; ``speed_ref_mps`` is read where
    ``speed_mps`` is absent. Other columns are ignored. Where noise takes a measured
    speed below 0 the car stands, and it is 0.

    Parameters
    ----------
    source : str, Path or TextIO
        UTF-8 text, compressed if the path ends in ``.gz``.
    name : str
        What to call it; the file's name without suffix unless given.
    origin : str
        Where the figures come from; the file's name unless given.

    Returns
    -------
    Cycle

    Raises
    ------
    InputError
        Naming the file and line: if it cannot be read as such a table, or the cycle
        breaks a rule of `Cycle`, or its top speed exceeds `V_BELIEVABLE`.
    """
    where = str(source) if isinstance(source, (str, Path)) else name or "stdin"
    rows = read_rows(source, where)
    time, speed = np.asarray(rows.time), np.asarray(rows.speed)
    source, below = origin or Path(where).name, speed < 0
    if below.any() and -speed.min() <= AT_REST * sensor_noise(speed):
        speed = np.maximum(speed, 0.0)
        source += f"; {below.sum()} rows of noise below 0 m/s taken as 0"
    _check_rows(where, rows, speed)
    plain = Path(where).name.removesuffix(".gz").removesuffix(".csv")
    return Cycle(name or plain, time, speed, source, rows.others)


def list_cycles(places: Sequence[Place] | None = None) -> list[Entry]:
    """Every cycle that has a name, and where it comes from (see `library.names`)."""
    return library.names("cycles", SUFFIXES, places)


def _check_rows(where: str, rows: Rows, speed: NDArray[np.float64]) -> None:
    if len(rows.time) < 2:
        raise InputError(f"{where}: should have at least 2 rows: {len(rows.time)}")
    fault = first_fault(np.asarray(rows.time), speed)
    if fault:
        raise InputError(
            f"{where}: line {rows.line[fault.row]}: {fault.message}", fault.hint
        )
    top = int(speed.argmax())
    if speed[top] > V_BELIEVABLE:
        raise InputError(
            f"{where}: line {rows.line[top]}: {rows.speed_column} should be at most "
            f"{V_BELIEVABLE:g} m/s: {speed[top]:g}",
            "it looks like km/h; divide by 3.6",
        )


def _read_named(name: str, places: Sequence[Place] | None) -> Cycle:
    path, origin = library.find("cycles", name, SUFFIXES, places)
    if origin == "path":
        return read_cycle(path)
    about = library.notes("cycles", path, name)
    return read_cycle(path, name, str(about.get("source", f"{origin}: {path.name}")))


def _read_stdin(stdin: TextIO | None) -> Cycle:
    if stdin is None:
        raise InputError("-: stdin should be given: there is none here")
    return read_cycle(stdin, "stdin", "stdin")


def _split_sum(spec: str) -> list[str]:
    """Terms of a sum; a plus inside brackets belongs to a number."""
    return [term.strip() for term in re.split(r"\+(?![^\[\]]*\])", spec)]


def _split_term(spec: str, term: str) -> tuple[str, list[str]]:
    """A name or path, and the cuts and repeats after it."""
    match = re.fullmatch(r"(.*?)((?:\s*\[[^\[\]]*\]|\s*\*\s*\d+)*)", term)
    base, tail = match.groups() if match else ("", "")
    misread = set("[]*") & set(base) and not library.is_path(base, SUFFIXES)
    if not base.strip() or misread:
        raise InputError(f"{spec}: cannot be read as a cycle: {term!r}", SYNTAX)
    return base.strip(), re.findall(r"\[[^\[\]]*\]|\*\s*\d+", tail)


def _apply(cycle: Cycle, operation: str) -> Cycle:
    """The cycle after one ``[start:stop]`` or ``*n``."""
    try:
        if operation.startswith("*"):
            return cycle.repeat(int(operation[1:]))
        start, stop = operation[1:-1].split(":")
        return cycle.slice(_seconds(start), _seconds(stop))
    except ValueError:
        words = (
            f"{cycle.name}{operation[:40]}: should be [start:stop] in seconds, or *n"
        )
        raise InputError(words, SYNTAX) from None


def _seconds(words: str) -> float | None:
    return float(words) if words.strip() else None
