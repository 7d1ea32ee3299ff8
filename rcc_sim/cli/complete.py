"""Names for the shell to complete: pass one as ``autocompletion=`` of an argument."""

from __future__ import annotations

from itertools import pairwise

import typer

from rcc_sim.errors import InputError

LOGS = ("log", "logs", "trace", "traces")
"""Arguments of a command that are logs."""

LONGEST = 1 << 16
"""Bytes of a log in which its header must end. [1]"""


def vehicle_names(incomplete: str) -> list[tuple[str, str]]:
    """Return vehicles whose name begins so, with their titles."""
    from rcc_sim.definitions.catalogue import vehicle_rows

    try:
        rows = vehicle_rows()
    except InputError:  # a folder that cannot be listed; the command itself says so
        return []
    return [(r["name"], r["title"]) for r in rows if r["name"].startswith(incomplete)]


def cycle_names(incomplete: str) -> list[tuple[str, str]]:
    """Return cycles whose name begins so, with their titles."""
    from rcc_sim.definitions import library

    try:
        found = library.names("cycles", (".csv", ".csv.gz"))
        about = [library.notes("cycles", entry.path, entry.name) for entry in found]
    except InputError:
        return []
    return [
        (entry.name, str(notes.get("title", "")))
        for entry, notes in zip(found, about, strict=True)
        if entry.name.startswith(incomplete)
    ]


def effect_names(incomplete: str) -> list[tuple[str, str]]:
    """Return effects whose id begins so, with their titles."""
    from rcc_sim.physics.effects import EFFECTS

    return [(n, e.title) for n, e in EFFECTS.items() if n.startswith(incomplete)]


def figure_keys(ctx: typer.Context, incomplete: str) -> list[str]:
    """Return figures of the vehicle on the command line whose key begins so."""
    from rcc_sim.definitions.vehicle import load_vehicle

    try:
        keys = load_vehicle(_vehicle(ctx)).figures()
    except InputError:
        return []
    return [key for key in keys if key.startswith(incomplete)]


def own_effects(ctx: typer.Context, incomplete: str) -> list[tuple[str, str]]:
    """Return effects of the vehicle on the command line whose id begins so."""
    from rcc_sim.definitions.vehicle import load_vehicle

    try:
        stated = load_vehicle(_vehicle(ctx)).effects
    except InputError:
        return effect_names(incomplete)
    return [pair for pair in effect_names(incomplete) if pair[0] in stated]


def _vehicle(ctx: typer.Context) -> str:
    by_option = [b for a, b in pairwise(ctx.args) if a == "--vehicle"]
    return next(iter([*by_option, *_words(ctx, "vehicle")]), "")


def map_names(incomplete: str) -> list[str]:
    """Return shipped column maps whose name begins so."""
    from rcc_sim.readers.column_map import shipped_maps

    return [m.name for m in shipped_maps() if m.name.startswith(incomplete)]


def column_names(ctx: typer.Context, incomplete: str) -> list[str]:
    """Return columns of the logs on the command line that begin so.

    The header alone is read. Where it is not in rccsim's names, those are told that a
    column map gives it; what has no header (a bag) is not opened.
    """
    files = [word for name in LOGS for word in _words(ctx, name)]
    by = next(iter(_words(ctx, "map_", "--map")), None)
    found = dict.fromkeys(c for f in files for c in _columns(f, by))
    return [
        c
        for c in found
        if c.startswith(incomplete) and c != "time_s" and c.isprintable()
    ]


def _words(ctx: typer.Context, name: str, option: str = "") -> list[str]:
    """Return what was given for a parameter.

    While an option still lacks its value, the words before it are not parsed: then
    all of them may be an argument, and an option's value comes after it.
    """
    given = ctx.params.get(name)
    if given:
        return [given] if isinstance(given, str) else list(given)
    if name not in ctx.params:
        return []
    words = ctx.args
    if option:
        return [b for a, b in pairwise(words) if a == option]
    return [w for w in words if not w.startswith("-")]


def _columns(name: str, by: str | None) -> list[str]:
    try:
        header = _header(name)
    except (OSError, EOFError, ValueError):  # not there yet, or broken
        return []
    if not header or ("time_s" in header and by is None):
        return header
    from rcc_sim.readers.column_map import load_map, matching, shipped_maps

    try:
        chosen = load_map(by) if by else matching(shipped_maps(), header)
    except InputError:
        return []
    return list(chosen.columns) if chosen else header


def _header(name: str) -> list[str]:
    """Return the names in the first line of a CSV file, or of a Parquet file."""
    import csv
    import gzip
    from pathlib import Path

    path = Path(name).expanduser()
    if path.suffix == ".parquet" and path.is_file():
        from pyarrow.parquet import read_schema

        return [str(n) for n in read_schema(path).names]
    if not path.is_file() or not path.name.endswith((".csv", ".csv.gz", ".txt")):
        return []
    with (gzip.open if path.suffix == ".gz" else open)(path, "rb") as file:
        line = file.readline(LONGEST).decode("utf-8-sig", "replace").strip()
    separator = max(",;\t", key=line.count)
    return [n.strip() for n in next(csv.reader([line], delimiter=separator), [])]
