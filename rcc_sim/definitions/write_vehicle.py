"""A vehicle file written anew: other figures and effects, its comments kept."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Protocol

from rcc_sim.definitions import library
from rcc_sim.definitions.vehicle import Vehicle, load_vehicle
from rcc_sim.errors import InputError
from rcc_sim.files import atomic

DIGITS = 8
"""Significant digits of a figure that is written."""


class Stated(Protocol):
    """What is written of a figure; `definitions.figure.Figure` is one."""

    @property
    def value(self) -> float:
        """The number to use."""
        ...

    @property
    def sd(self) -> float:
        """One standard deviation; 0 where an interval tells more, or nothing does."""
        ...

    @property
    def low(self) -> float | None:
        """Lower end of its interval."""
        ...

    @property
    def high(self) -> float | None:
        """Upper end of its interval."""
        ...

    @property
    def source(self) -> str:
        """Where it comes from; ``derived: <log>`` where empty."""
        ...


def write_vehicle(
    vehicle: Vehicle,
    path: str | Path,
    figures: Mapping[str, Stated],
    effects: Mapping[str, Mapping[str, Stated | float | str]],
    log_name: str,
    held_back: Sequence[str] = (),
) -> None:
    """Write the file of a vehicle with other figures and further effects.

    What the file says besides, its comments and the vehicle that it extends stay as
    they are; a vehicle that was changed since it was read (``--set``, ``--with``) is
    written as changed. File names that count from the file's folder are rewritten to
    count from the new one.

    Parameters
    ----------
    vehicle : Vehicle
        As loaded; perhaps changed.
    path : str or Path
        File to write, whole or not at all.
    figures : dict
        Dotted key -> figure.
    effects : dict
        Effect id -> parameter -> figure, number, or name of a file, from the new one's
        folder.
    log_name : str
        What the figures are derived from.
    held_back : sequence of str
        Columns that these logs have, and that were hidden: a log that has them would
        count them twice.

    Raises
    ------
    InputError
        If the result would be no sound vehicle, or cannot be written.
    """
    import tomlkit

    target = Path(path)
    document = _document(vehicle)
    _settle(document, vehicle, target)
    for key, figure in figures.items():
        *tables, last = key.split(".")
        _put(_table(document, tables), last, _table_of(figure, log_name))
    for name, params in effects.items():
        table = _table(document, ["effects", name])
        for key, value in params.items():
            if isinstance(value, str):
                _put(table, key, value)
            elif isinstance(value, int | float):
                _put(table, key, float(value))
            else:
                _put(table, key, _table_of(value, log_name))
    if held_back:
        table = _table(document, ["vehicle"])
        every = dict.fromkeys([*table.get("mended_without", []), *held_back])
        _put(table, "mended_without", list(every))
    _write(target, tomlkit.dumps(document))


def _document(vehicle: Vehicle) -> Any:
    """Return the vehicle's file with its comments, else its tables."""
    import tomlkit

    if vehicle.path is None or not vehicle.path.is_file():
        return tomlkit.parse(tomlkit.dumps(vehicle.raw))
    document = tomlkit.parse(vehicle.path.read_bytes().decode("utf-8-sig"))
    stated = load_vehicle(vehicle.path).raw
    for key, value in _differences(stated, vehicle.raw):
        *tables, last = key
        _put(_table(document, list(tables)), last, value)
    gone = set(stated.get("effects", {})) - set(vehicle.raw.get("effects", {}))
    for name in sorted(gone - {"files"}):
        _take_out(document, name)
    return document


def _differences(
    before: Mapping[str, Any], after: Mapping[str, Any], at: tuple[str, ...] = ()
) -> list[tuple[tuple[str, ...], Any]]:
    """Return the keys that were set since the file was read, with their values."""
    found: list[tuple[tuple[str, ...], Any]] = []
    for key, value in after.items():
        old = before.get(key)
        figure = isinstance(value, Mapping) and ("value" in value or "low" in value)
        if isinstance(value, Mapping) and not figure:
            below = old if isinstance(old, Mapping) else {}
            found += _differences(below, value, (*at, key))
        elif old != value:
            found.append(((*at, key), value))
    return found


def _take_out(document: Any, name: str) -> None:
    """Take an effect out; one that the base has is named as taken out."""
    effects = _table(document, ["effects"])
    effects.pop(name, None)
    if document["vehicle"].get("extends"):
        effects["without"] = [*effects.get("without", []), name]


def _settle(document: Any, vehicle: Vehicle, target: Path) -> None:
    """Make every file that the vehicle names be found from its new folder."""
    if vehicle.path is None:
        return
    file = vehicle.path.resolve()
    home = file.parent
    base = document["vehicle"].get("extends")
    if base and not (target.resolve().parent / f"{base}.toml").is_file():
        beside = home / f"{base}.toml"
        if beside.is_file() and not _is_known(str(base), beside):
            raise InputError(
                f"{target}: vehicle.extends: {base} would not be found from there",
                f"write the file into {home}, or put {base} into your vehicles/",
            )
    effects = document.get("effects", {})
    if "files" in effects:
        effects["files"] = [_moved(str(f), home / f, target) for f in effects["files"]]
    for name, params in effects.items():
        known = vehicle.known.get(name)
        for key in known.files if known is not None else ():
            if key in params:
                stated = str(params[key])
                place = library.named_by(file, stated)
                _put(params, key, _moved(stated, place, target))


def _is_known(name: str, path: Path) -> bool:
    try:
        found, _ = library.find("vehicles", name, (".toml",))
    except InputError:
        return False
    return found.resolve() == path.resolve()


def _moved(name: str, place: Path, target: Path) -> str:
    """Return the name of a file at ``place`` as the target is to state it."""
    if name.startswith("plugin "):
        return name
    here = place.expanduser().resolve()
    folder = target.resolve().parent
    if not here.exists():
        return name
    if folder == here.parent or library.is_everywhere(here):
        return here.name
    try:
        return os.path.relpath(here, folder)
    except ValueError:  # another drive
        return str(here)


def _table_of(figure: Stated, log_name: str) -> dict[str, Any]:
    table: dict[str, Any] = {"value": _rounded(figure.value)}
    if figure.low is not None and figure.high is not None:
        table["low"] = min(_rounded(figure.low), table["value"])
        table["high"] = max(_rounded(figure.high), table["value"])
    if figure.sd > 0:
        table["sd"] = _rounded(figure.sd)
    table["source"] = figure.source or f"derived: {log_name}"
    return table


def _rounded(value: float) -> float:
    return float(f"{value:.{DIGITS}g}")


def _table(document: Any, names: list[str]) -> Any:
    import tomlkit

    node = document
    for name in names:
        if name not in node:
            fresh = tomlkit.table(is_super_table=name == "effects" or None)
            node[name] = fresh
        node = node[name]
    return node


def _put(table: Any, key: str, value: Any) -> None:
    """Set a key; a comment behind the old value stays."""
    import tomlkit

    if isinstance(value, Mapping):
        inline = tomlkit.inline_table()
        inline.update(value)
        item: Any = inline
    else:
        item = tomlkit.item(value)
    if key in table and hasattr(table[key], "trivia"):
        old = table[key].trivia
        item.trivia.comment_ws, item.trivia.comment = old.comment_ws, old.comment
    table[key] = item


def _write(target: Path, text: str) -> None:
    """Write the file, whole or not at all, if it is a sound vehicle."""
    with atomic(target) as file:
        file.write(text)
        file.flush()
        _check(Path(file.name), target)


def _check(temporary: Path, target: Path) -> None:
    """Refuse to write what would not load."""
    try:
        load_vehicle(temporary)
    except InputError as error:
        message = str(error).replace(str(temporary), str(target))
        raise InputError(f"{message} (nothing was written)", error.hint) from None
