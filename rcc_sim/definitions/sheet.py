"""A vehicle laid out for reading, and the blank sheet of a new one."""

from __future__ import annotations

from typing import Any

from pydantic import ValidationError

from rcc_sim.definitions.figure import Figure
from rcc_sim.definitions.tables import ADVICE, Heading
from rcc_sim.definitions.vehicle import ALWAYS, TABLES, Vehicle, load_vehicle
from rcc_sim.errors import InputError
from rcc_sim.units import unit_of

COLUMNS = ("key", "value", "unit", "sd", "low", "high", "guess", "source")
"""What is known of one figure of a vehicle."""


def figure_rows(vehicle: Vehicle) -> list[dict[str, Any]]:
    """Return every key that a vehicle states, those of its base included.

    Returns
    -------
    rows : list of dict
        Dotted key, value, unit, sd, range, whether it is a guess, source; what a key
        does not state is None. Words and switches have a key and a value.
    """
    return [
        _figure_row(key, value)
        for key, value in _stated(vehicle).items()
        if value is not None and value != ""
    ]


def document(vehicle: Vehicle) -> dict[str, Any]:
    """Return a vehicle whole: heading, where it was found, figures, effects."""
    return {
        **vehicle.vehicle.model_dump(),
        "path": vehicle.where,
        "origin": vehicle.origin,
        "effects": list(vehicle.effects),
        "guesses": vehicle.guesses(),
        "figures": figure_rows(vehicle),
    }


def new_sheet(name: str, like: str | None) -> str:
    """Return the file of a new vehicle: one that extends another, or a blank one.

    Raises
    ------
    InputError
        If the name is none, or the vehicle that it extends is not sound.
    """
    return sheet_like(name, load_vehicle(like)) if like else blank_sheet(name)


def _stated(vehicle: Vehicle) -> dict[str, Any]:
    stated: dict[str, Any] = {}
    for table in TABLES:
        for key, value in getattr(vehicle, table) or ():
            stated[f"{table}.{key}"] = value
    for column, sensor in vehicle.sensors.items():
        for key, value in sensor:
            stated[f"sensors.{column}.{key}"] = value
    for effect, params in vehicle.effects.items():
        for name, figure in params.items():
            stated[f"effects.{effect}.{name}"] = figure
    return stated


def _figure_row(key: str, value: Any) -> dict[str, Any]:
    row = dict.fromkeys(COLUMNS) | {"key": key, "value": value}
    if not isinstance(value, Figure):
        return row
    table, name, *inner = key.split(".")
    in_columns_unit = table == "sensors" and inner[0] not in ("latency_s", "scale_sd")
    return row | {
        "value": value.value,
        "unit": unit_of(name if in_columns_unit else key),
        "sd": value.sd or None,
        "low": value.low,
        "high": value.high,
        "guess": value.is_guess,
        "source": value.source,
    }


def blank_sheet(name: str) -> str:
    """Return a vehicle file with every key that there is, each waiting to be filled.

    What must be filled before anything runs is marked; ``vehicles validate`` lists
    what is still missing. No figure is put in the place of one that is not known.
    """
    lines = [
        *_heading(name),
        'title = ""',
        'source = ""  # where the figures come from',
    ]
    for table, model in TABLES.items():
        if table == "vehicle":
            continue
        lines += ["", f"[{table}]" if table in ALWAYS else f"# [{table}]"]
        for key, field in model.model_fields.items():
            needed = field.is_required() and table in ALWAYS
            lines.append(f"# {key} ={_note(table, key, needed)}")
    return "\n".join([*lines, *EFFECTS_NOTE]) + "\n"


def sheet_like(name: str, base: Vehicle) -> str:
    """Return a vehicle file that extends another and states nothing of its own yet."""
    lines = [*_heading(name), 'title = ""', f'extends = "{base.name}"']
    lines += ['source = ""  # where the figures that differ come from', ""]
    lines += [f"# What stands here replaces what {base.name} states, which is:"]
    table = ""
    for row in figure_rows(base):
        head, _, key = row["key"].rpartition(".")
        if head == "vehicle":
            continue
        if head != table:
            lines += ["", f"# [{head}]"]
            table = head
        lines.append(f"# {key} = {_shown(row)}")
    without = "# without = []  # effects of the base that this vehicle does not have"
    return "\n".join([*lines, "", "# [effects]", without, *EFFECTS_NOTE]) + "\n"


EFFECTS_NOTE = (
    "",
    "# One table for each effect that the vehicle is known to have, as in",
    "# [effects.rolling_resistance]",
    '# coefficient = { value = 0.02, sd = 0.005, source = "measured: coast-down" }',
    "# `rccsim effects` lists them all.",
)


def _heading(name: str) -> list[str]:
    try:
        Heading(name=name)
    except ValidationError:
        hint = ADVICE["vehicle.name"]
        raise InputError(f"{name!r}: cannot be a vehicle's name", hint) from None
    return [
        f"# {name}. A figure is a number, a range [low, high], or a table such as",
        '# { value = 3.78, sd = 0.01, source = "measured: kitchen scale" }; a source',
        '# that begins with "guess" shows as one in every report. Units are in keys.',
        "[vehicle]",
        f'name = "{name}"',
    ]


def _note(table: str, key: str, needed: bool) -> str:
    parts = ("needed" if needed else "", _unit(key), ADVICE.get(f"{table}.{key}", ""))
    return f"  # {'; '.join(part for part in parts if part)}".rstrip(" #")


def _shown(row: dict[str, Any]) -> str:
    if row["guess"] is None:
        return repr(row["value"]).replace("'", '"')
    parts = (_unit(row["key"]), "a guess" if row["guess"] else "")
    note = ", ".join(part for part in parts if part)
    return f"{row['value']:.6g}" + (f"  # {note}" if note else "")


def _unit(key: str) -> str:
    unit = unit_of(key)
    return "" if unit == "1" else unit
