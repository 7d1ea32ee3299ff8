"""A vehicle's file as tables: read, and laid over the vehicle that it extends."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import tomli

from rcc_sim.definitions import library
from rcc_sim.errors import InputError, did_you_mean
from rcc_sim.physics.effects import EFFECTS

LARGEST_FILE = 1_000_000  # bytes; a vehicle is a page or two of text

MENDS = (
    (re.compile(r"=\s*([+-]?\d+),(\d+)"), r"a decimal point: \1.\2"),
    (re.compile(r"=\s*([+-]?)(\.\d+)"), r"a digit before the point: \g<1>0\2"),
    (
        re.compile(r"=\s*([+-]?\d[\d.eE+-]*)\s*[^\W\d]"),
        "a number alone, in the unit that its key names",
    ),
    (re.compile(r"=\s*([^\W\d]\w*)\s*$"), r'text in quotes: "\1"'),
    (re.compile(r'=[^"#]*"[^"]*$'), "a quote at the end of the text"),
    (re.compile(r"^\s*\[[^\]]*$"), "a bracket at the end of the table's name"),
    (re.compile(r"^\s*([\w-]+)\s*:\s*(.*)$"), r"an equals sign: \1 = \2"),
)
"""What a line that is not TOML looks like, and its likely mend."""


def resolved(path: Path, seen: tuple[Path, ...] = ()) -> dict[str, Any]:
    """Return the tables of a file laid over those of the vehicle it extends.

    Parameters
    ----------
    path : Path
        The file.
    seen : tuple of Path, optional
        Files that led here, each extending the next.

    Raises
    ------
    InputError
        If a file cannot be read, is not TOML, or extends itself.
    """
    raw = _read_toml(path)
    effects = raw.get("effects", {})
    if isinstance(effects, dict) and isinstance(effects.get("files"), list):
        effects["files"] = [str(path.resolve().parent / f) for f in effects["files"]]
    heading = raw.get("vehicle")
    base = heading.get("extends") if isinstance(heading, dict) else None
    if not base:
        return raw
    if path.resolve() in seen:
        chain = " -> ".join(p.stem for p in (*seen, path.resolve()))
        raise InputError(f"{path}: vehicle.extends: goes round in a circle: {chain}")
    if not isinstance(base, str):
        raise InputError(f"{path}: vehicle.extends: should be the name of a vehicle")
    beside = path.parent / f"{base}.toml"
    if beside.is_file() and beside.resolve() != path.resolve():
        parent = beside
    else:
        try:
            parent, _ = library.find("vehicles", base, (".toml",))
        except InputError as error:
            raise InputError(f"{path}: vehicle.extends: {error}", error.hint) from None
    merged = _anchored(resolved(parent, (*seen, path.resolve())), parent)
    taken = effects.pop("without", []) if isinstance(effects, dict) else []
    if not isinstance(taken, list):
        what = f"{path}: effects.without: should be a list of effects"
        raise InputError(what, f"[{taken!r}]".replace("'", '"'))
    for name in taken:
        theirs = merged.get("effects", {})
        if theirs.pop(name, None) is None:
            what = f"{path}: effects.without: {base} does not have {name}"
            raise InputError(what, did_you_mean(str(name), theirs))
    inherited = merged.get("effects", {}).get("files", [])
    whole = _overlaid(merged, raw)
    if isinstance(effects, dict) and inherited:
        whole["effects"]["files"] = [*inherited, *effects.get("files", [])]
    return whole


def _anchored(tables: dict[str, Any], path: Path) -> dict[str, Any]:
    """Return the tables of a file with the files that its effects name by full path."""
    effects = tables.get("effects", {})
    for name, params in effects.items() if isinstance(effects, dict) else ():
        for key in EFFECTS[name].files if name in EFFECTS else ():
            if isinstance(params, dict) and isinstance(params.get(key), str):
                params[key] = str(library.named_by(path.resolve(), params[key]))
    return tables


def _overlaid(base: dict[str, Any], top: dict[str, Any]) -> dict[str, Any]:
    """Lay one set of tables over another; a figure is replaced as a whole."""
    merged = dict(base)
    for key, value in top.items():
        below = merged.get(key)
        is_figure = isinstance(value, dict) and ("value" in value or "low" in value)
        if isinstance(value, dict) and isinstance(below, dict) and not is_figure:
            merged[key] = _overlaid(below, value)
        else:
            merged[key] = value
    return merged


def _read_toml(path: Path) -> dict[str, Any]:
    try:
        size = path.stat().st_size
        if size > LARGEST_FILE:
            raise InputError(
                f"{path}: too large for a vehicle file: {size / 1e6:.1f} MB",
                "a vehicle is a few kilobytes of TOML; is this a log?",
            )
        data = path.read_bytes()
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror}") from None
    if not data.strip():
        raise InputError(f"{path}: the file is empty", "`rccsim vehicles new` helps")
    try:
        text = data.decode("utf-8-sig")
        return tomli.loads(text)
    except UnicodeDecodeError:
        raise InputError(f"{path}: not text in UTF-8", "is this a TOML file?") from None
    except tomli.TOMLDecodeError as error:
        line = text.split("\n")[error.lineno - 1]
        raise InputError(f"{path}: not TOML: {error}", _mend_of(line)) from None
    except RecursionError:
        raise InputError(f"{path}: not TOML: nested too deeply") from None


def _mend_of(line: str) -> str:
    """Return the likely mend of a line that is not TOML; empty if none is known.

    >>> _mend_of("mass_kg = 3,78")
    'a decimal point: 3.78'
    """
    for pattern, mend in MENDS:
        if found := pattern.search(line):
            return found.expand(mend)
    return ""
