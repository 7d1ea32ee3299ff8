"""What can be named on the command line, a row each; a broken file is a row too."""

from __future__ import annotations

import tomllib
from typing import TYPE_CHECKING, Any

from rcc_sim.definitions import library
from rcc_sim.definitions.library import Entry
from rcc_sim.errors import InputError

if TYPE_CHECKING:
    from rcc_sim.definitions.cycle import Cycle
    from rcc_sim.physics.effect import Effect

CYCLE_TABLE = ("name", "title", "duration_s", "distance_m", "max_speed_mps", "problem")
"""Columns of the cycles that fit a terminal."""


def vehicle_rows() -> list[dict[str, str]]:
    """List every vehicle that has a name, from the heading of its file alone.

    Returns
    -------
    rows : list of dict
        Name, title, source, origin, path, and the problem of a file without a sound
        heading. Whether the figures are sound is for ``vehicles validate`` to say.
    """
    return [_vehicle_row(entry) for entry in library.names("vehicles", (".toml",))]


def cycle_rows() -> list[dict[str, str | float | None]]:
    """List every cycle that has a name, with its length and top speed.

    Returns
    -------
    rows : list of dict
        Name, title, duration, distance, top speed, the distance that is published
        (None where none is), source, licence, origin, path, and the problem of a file
        that is no cycle.
    """
    from rcc_sim.definitions.cycle import list_cycles

    return [_cycle_row(entry) for entry in list_cycles()]


def cycle_document(cycle: Cycle) -> dict[str, Any]:
    """Return a cycle, its length and its rows as columns."""
    return {
        "name": cycle.name,
        "source": cycle.source,
        "duration_s": cycle.duration,
        "distance_m": cycle.distance,
        "max_speed_mps": cycle.max_speed,
        "time_s": cycle.time_s.tolist(),
        "speed_mps": cycle.speed_mps.tolist(),
    }


def effect_rows() -> list[dict[str, Any]]:
    """List every effect of the model, whole, and those of installed plugins.

    A plugin that is not sound is listed with its problem in place of a title.
    """
    from rcc_sim.definitions.own_effects import plugin_names
    from rcc_sim.physics.effects import EFFECTS

    rows = [effect_row(name) for name in EFFECTS]
    for name in plugin_names():
        try:
            rows.append(effect_row(name))
        except InputError as error:
            unknown = {k: [] if isinstance(v, list) else "" for k, v in rows[0].items()}
            title = f"not sound: {error}"
            rows.append(unknown | {"id": name, "title": title, "source": "plugin"})
    return rows


def effect_of(name: str) -> tuple[Effect, str]:
    """Return an effect by its id, or from its Python file, and where it came from.

    Raises
    ------
    InputError
        If there is no such effect.
    """
    from rcc_sim.definitions.own_effects import own_effect, plugin_names
    from rcc_sim.physics.effect import meant
    from rcc_sim.physics.effects import EFFECTS

    if name in EFFECTS:
        return EFFECTS[name], "shipped"
    if name.endswith(".py"):
        return own_effect(name).effect, name
    if name in (installed := plugin_names()):
        return own_effect(f"plugin {name}").effect, f"plugin {name}"
    raise InputError(f"no such effect: {name!r}", meant(name, EFFECTS, installed))


def effect_row(name: str) -> dict[str, Any]:
    """Return all that is known of one effect.

    Raises
    ------
    InputError
        If there is no such effect.
    """
    from rcc_sim.units import unit_of

    effect, origin = effect_of(name)
    return {
        "id": effect.id,
        "title": effect.title,
        "equation": effect.equation,
        "parameters": [
            {
                "name": param.name,
                "unit": unit_of(param.name),
                "neutral": param.neutral,
                "low": param.bounds[0],
                "high": param.bounds[1],
                "typical_low": param.typical[0],
                "typical_high": param.typical[1],
                "optional": param.optional,
                "about": param.about,
            }
            for param in effect.params
        ],
        "files": list(effect.files),
        "channels": list(effect.channels),
        "seen_as": effect.seen_as,
        "ledger": effect.sink,
        "needs": [*effect.needs, *filter(None, [" or ".join(effect.needs_any)])],
        "excludes": list(effect.excludes),
        "source": effect.source,
        "origin": origin,
    }


def flat_effect(row: dict[str, Any]) -> dict[str, str]:
    """Return an effect with one text a cell: ``coefficient (1)`` is a parameter."""
    units = (f"{p['name']} ({p['unit']})" for p in row["parameters"])
    parameters = ", ".join([*units, *(f"{name} (file)" for name in row["files"])])
    return {
        key: ", ".join(value) if isinstance(value, list) else str(value)
        for key, value in (row | {"parameters": parameters}).items()
    }


def effect_sheet(row: dict[str, Any]) -> list[dict[str, str]]:
    """Return an effect as pairs of a key and a text, one row for each parameter."""
    flat = flat_effect(row)
    rows = [{"key": key, "value": flat[key]} for key in ("id", "title", "equation")]
    rows += [{"key": p["name"], "value": _described(p)} for p in row["parameters"]]
    rows += [{"key": name, "value": "name of a file"} for name in row["files"]]
    rest = ("channels", "seen_as", "ledger", "needs", "excludes", "source", "origin")
    return rows + [{"key": key, "value": flat[key]} for key in rest if flat[key]]


def _described(p: dict[str, Any]) -> str:
    unit = "" if p["unit"] == "1" else f" {p['unit']}"
    text = f"{p['about']}; neutral {p['neutral']:g}{unit}"
    text += f", from {p['low']:g} to {p['high']:g}{unit}"
    if p["typical_low"] != p["typical_high"]:
        text += f", usually {p['typical_low']:g} to {p['typical_high']:g}{unit}"
    return text + (", may be left out" if p["optional"] else "")


def _vehicle_row(entry: Entry) -> dict[str, str]:
    heading, problem = _heading(entry)
    return {
        "name": entry.name,
        "title": str(heading.get("title", "")),
        "source": str(heading.get("source", "")),
        "extends": str(heading.get("extends", "")),
        "origin": "; hides that of the ".join([entry.origin, *entry.shadows]),
        "path": str(entry.path),
        "problem": problem,
    }


def _heading(entry: Entry) -> tuple[dict[str, Any], str]:
    try:
        tables = tomllib.loads(entry.path.read_bytes().decode("utf-8-sig"))
    except OSError as error:
        return {}, f"cannot be read: {error.strerror}"
    except UnicodeDecodeError:
        return {}, "not text in UTF-8"
    except (tomllib.TOMLDecodeError, RecursionError) as error:
        return {}, f"not TOML: {error}"
    heading = tables.get("vehicle")
    if not isinstance(heading, dict):
        return {}, "[vehicle]: missing"
    if heading.get("name") != entry.name:
        named = heading.get("name")
        return heading, f"vehicle.name: should be the file's name: {named!r}"
    return heading, ""


def _cycle_row(entry: Entry) -> dict[str, str | float | None]:
    from rcc_sim.definitions.cycle import read_cycle

    row: dict[str, str | float | None] = {"name": entry.name, "title": ""}
    row |= {"duration_s": None, "distance_m": None, "max_speed_mps": None}
    row |= {"published_distance_m": None, "source": "", "licence": ""}
    row |= {"origin": entry.origin, "path": str(entry.path), "problem": ""}
    try:
        about = library.notes("cycles", entry.path, entry.name)
        row["published_distance_m"] = about.get("distance_m")
        row |= {key: str(about.get(key, "")) for key in ("title", "source", "licence")}
        cycle = read_cycle(entry.path, entry.name)
        row["duration_s"] = cycle.duration
        row["distance_m"] = cycle.distance
        row["max_speed_mps"] = cycle.max_speed
    except InputError as error:
        row["problem"] = str(error)
    return row
