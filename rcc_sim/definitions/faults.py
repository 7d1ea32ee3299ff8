"""All that is wrong with a vehicle file, where loading it names the first thing."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

from pydantic import BaseModel, ValidationError

from rcc_sim.definitions import library, vehicle
from rcc_sim.definitions.checks import checked_effects, faults_of, unknown_key
from rcc_sim.definitions.kernel import force_table, kernel_params
from rcc_sim.definitions.own_effects import own_effects
from rcc_sim.definitions.tables import Sensor
from rcc_sim.definitions.vehicle import ALWAYS, TABLES
from rcc_sim.definitions.vehicle_file import resolved
from rcc_sim.errors import InputError
from rcc_sim.physics.effects import EFFECTS


def vehicle_faults(name: str | Path) -> list[InputError]:
    """Return everything that is wrong with a vehicle, each as loading would say it.

    Parameters
    ----------
    name : str or Path
        A name or a path, as for `load_vehicle`.

    Returns
    -------
    faults : list of InputError
        Empty if the vehicle is sound.

    Raises
    ------
    InputError
        If there is no such vehicle.
    """
    path = library.find("vehicles", str(name), (".toml",)).path
    try:
        raw = resolved(path)
    except InputError as fault:
        return [fault]
    faults = [*_table_faults(raw, str(path)), *_effect_faults(raw, path)]
    return faults or _faults_together(raw, path)


def _table_faults(raw: dict[str, Any], where: str) -> Iterator[InputError]:
    for name in ALWAYS:
        if name not in raw:
            yield InputError(f"{where}: [{name}]: missing")
    for name, table in raw.items():
        if name not in TABLES and name not in ("sensors", "effects"):
            yield unknown_key(where, name, (*TABLES, "sensors", "effects"))
        elif not isinstance(table, dict):
            yield InputError(f"{where}: {name}: should be a table, [{name}]")
        elif name in TABLES:
            yield from _key_faults(TABLES[name], table, where, name)
        elif name == "sensors":
            for column, sensor in table.items():
                at = f"sensors.{column}"
                yield from _key_faults(Sensor, sensor, where, at)


def _key_faults(
    model: type[BaseModel], table: Any, where: str, name: str
) -> Iterator[InputError]:
    if not isinstance(table, dict):
        yield InputError(f"{where}: {name}: should be a table, [{name}]")
        return
    keys = tuple(model.model_fields)
    for key in table:
        if key not in keys:
            yield unknown_key(where, f"{name}.{key}", keys)
    try:
        model.model_validate({k: v for k, v in table.items() if k in keys})
    except ValidationError as error:
        yield from faults_of(error, where, name)


def _effect_faults(raw: dict[str, Any], path: Path) -> Iterator[InputError]:
    effects = raw.get("effects", {})
    if not isinstance(effects, dict):
        return
    try:
        own, stated = own_effects(effects, str(path), path)
    except InputError as fault:
        yield fault
        return
    for name, params in stated.items():
        faults = _raised(checked_effects, {name: params}, str(path), own)
        yield from faults
        for key in () if faults or name in own else EFFECTS[name].files:
            if key in params and not library.named_by(path, params[key]).is_file():
                at = f"{path}: effects.{name}.{key}"
                yield InputError(f"{at}: no such file: {params[key]}")


def _faults_together(raw: dict[str, Any], path: Path) -> list[InputError]:
    """Return what is wrong only together, and what a run would miss."""
    try:
        car = vehicle.build(raw, path=path)
    except InputError as fault:
        return [fault]
    return [
        *_raised(kernel_params, car, commanded=False),
        *_raised(force_table, car),
    ]


def _raised(check: Any, *args: Any, **options: Any) -> list[InputError]:
    try:
        check(*args, **options)
    except InputError as fault:
        return [fault]
    return []
