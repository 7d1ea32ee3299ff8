"""A vehicle as a user writes it: a TOML file, checked key by key."""

from __future__ import annotations

import copy
import os
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

from pydantic import BaseModel, ValidationError

from rcc_sim.definitions import library
from rcc_sim.definitions.figure import Figure
from rcc_sim.definitions.own_effects import OwnEffect, own_effects
from rcc_sim.definitions.tables import (
    ADVICE,
    Battery,
    Body,
    Controller,
    Drivetrain,
    Heading,
    Motor,
    Sensor,
    Table,
    Tyres,
    advice,
)
from rcc_sim.definitions.vehicle_file import resolved
from rcc_sim.errors import InputError, did_you_mean
from rcc_sim.physics.effect import Effect
from rcc_sim.physics.effects import EFFECTS

TABLES: dict[str, type[Table]] = {
    "vehicle": Heading,
    "body": Body,
    "tyres": Tyres,
    "drivetrain": Drivetrain,
    "motor": Motor,
    "battery": Battery,
    "controller": Controller,
}
ALWAYS = ("vehicle", "body", "tyres", "drivetrain")
BULK = (5.0, 5000.0)  # kg/m³; mass over wheelbase cubed of anything on four wheels


@dataclass(frozen=True)
class Vehicle:
    """A checked vehicle definition.

    Parameters
    ----------
    vehicle, body, tyres, drivetrain, motor, battery, controller : Table
        The tables of the file; the last three are empty where not stated.
    sensors : dict
        Column -> sensor.
    effects : dict
        Effect id -> parameter -> figure (or file name, for a map).
    raw : dict
        The tables as read, after ``extends``; what :meth:`changed` starts from.
    own : dict
        Effect id -> effect that is not shipped, of those that it has.
    path : Path or None
        The file; relative file names inside it count from its folder.
    origin : str
        Where it was found: working folder, plugin, shipped.
    """

    vehicle: Heading
    body: Body
    tyres: Tyres
    drivetrain: Drivetrain
    motor: Motor
    battery: Battery
    controller: Controller | None
    sensors: dict[str, Sensor]
    effects: dict[str, dict[str, Figure | str]]
    raw: dict[str, Any] = field(repr=False, compare=False)
    own: dict[str, OwnEffect] = field(default_factory=dict, repr=False)
    path: Path | None = field(default=None, compare=False)
    origin: str = field(default="", compare=False)

    @property
    def name(self) -> str:
        """Name that commands call it by."""
        return self.vehicle.name

    @property
    def wheelbase(self) -> float:
        """Distance between the axles. [m]"""
        return self.body.cg_to_front_axle_m.value + self.body.cg_to_rear_axle_m.value

    def figures(self) -> dict[str, Figure]:
        """Dotted key -> figure, of everything that the file states."""
        return dict(self._figures)

    @cached_property
    def _figures(self) -> dict[str, Figure]:
        found: dict[str, Figure] = {}
        for table in TABLES:
            part = getattr(self, table)
            if part is not None:
                found |= {f"{table}.{k}": v for k, v in part.figures().items()}
        for effect, params in self.effects.items():
            for key, value in params.items():
                if isinstance(value, Figure):
                    found[f"effects.{effect}.{key}"] = value
        return found

    def figure(self, key: str, why: str = "") -> Figure:
        """Return the figure of a dotted key, such as ``motor.flux_linkage_wb``.

        Raises
        ------
        InputError
            If the file does not state it; ``why`` says what needs it.
        """
        found = self._figures.get(key)
        if found is None:
            reason = f" ({why})" if why else ""
            raise InputError(
                f"{self.where}: {key}: missing{reason}", ADVICE.get(key, "")
            )
        return found

    @cached_property
    def known(self) -> dict[str, Effect]:
        """Effect id -> effect: those shipped, and the vehicle's own."""
        return {**EFFECTS, **{name: own.effect for name, own in self.own.items()}}

    @property
    def where(self) -> str:
        """The file, or the name where it did not come from a file."""
        return str(self.path) if self.path else self.name

    def guesses(self) -> list[str]:
        """Keys whose figure is a guess by its own source."""
        return [key for key, figure in self.figures().items() if figure.is_guess]

    def changed(
        self,
        *,
        settings: dict[str, Any] | None = None,
        effects: dict[str, dict[str, Any]] | None = None,
        without: tuple[str, ...] = (),
        files: tuple[str, ...] = (),
    ) -> Vehicle:
        """Return a copy with other figures, effects added, effects taken out.

        Parameters
        ----------
        settings : dict
            Dotted key -> value, as the file would state it.
        effects : dict
            Effect id -> parameter -> value; a parameter not named is kept.
        without : tuple of str
            Effects to take out.
        files : tuple of str
            Python files with effects of the user's own, to be known besides.
        """
        raw = dict(self.raw)
        if effects or without or files:
            raw["effects"] = copy.deepcopy(raw.get("effects", {}))
        for key, value in (settings or {}).items():
            node = raw
            *tables, last = key.split(".")
            for table in tables:
                inner = node.get(table, {})
                if not isinstance(inner, dict):
                    raise InputError(f"{key}: no such key in a vehicle file")
                node[table] = dict(inner)
                node = node[table]
            if not tables:
                raise InputError(
                    f"{key}: no such key in a vehicle file",
                    f"write the table too, as in {_likely_key(key)}",
                )
            node[last] = value
        if files:
            stated = raw.setdefault("effects", {})
            stated["files"] = [*stated.get("files", []), *map(os.path.abspath, files)]
        for name in without:
            _known_effect(name, self.where, self.known)
            if raw.get("effects", {}).pop(name, None) is None:
                raise InputError(
                    f"{self.where}: effects.{name}: the vehicle does not have it",
                    f"it has {', '.join(self.effects) or 'none'}",
                )
        for name, params in (effects or {}).items():
            raw.setdefault("effects", {}).setdefault(name, {}).update(params)
        return build(raw, path=self.path, origin=self.origin, like=self)


def load_vehicle(name: str | Path) -> Vehicle:
    """Return the vehicle of a file or of a name in the registry.

    Looks for a path, then in the working folder's ``vehicles/``, the user's own
    folder, installed plugins, and the shipped vehicles.

    Raises
    ------
    InputError
        If there is none, or the file is not sound.
    """
    path, origin = library.find("vehicles", str(name), (".toml",))
    return build(resolved(path), path=path, origin=origin)


def build(
    raw: dict[str, Any],
    *,
    path: Path | None,
    origin: str = "",
    like: Vehicle | None = None,
) -> Vehicle:
    """Check the tables of a vehicle and return it.

    Tables that are the very ones of a vehicle that it is ``like`` are sound already.

    Raises
    ------
    InputError
        Naming file, key, rule and value of the first thing that is wrong.
    """
    where = str(path) if path else str(raw.get("vehicle", {}).get("name", "vehicle"))
    known = (*TABLES, "sensors", "effects")
    for name, table in raw.items():
        if name not in known:
            raise _unknown(where, name, known)
        if not isinstance(table, dict):
            raise InputError(f"{where}: {name}: should be a table, [{name}]")
    sound = {n for n in TABLES if like and n in raw and raw[n] is like.raw.get(n)}
    _refuse_unknown_keys({n: raw[n] for n in raw if n not in sound}, where)
    for name in ALWAYS:
        if name not in raw:
            raise InputError(
                f"{where}: [{name}]: missing",
                f"a vehicle always has {', '.join(f'[{t}]' for t in ALWAYS)}",
            )
    parts: dict[str, Any] = {
        name: getattr(like, name)
        if name in sound
        else _checked(model, raw.get(name, {}), where, name)
        for name, model in TABLES.items()
        if name in raw or name in ("motor", "battery")
    }
    parts.setdefault("controller", None)
    sensors = {
        column: _checked(Sensor, table, where, f"sensors.{column}")
        for column, table in raw.get("sensors", {}).items()
    }
    _check_sizes(parts["body"], parts["tyres"], where)
    own, stated = own_effects(raw.get("effects", {}), where, path)
    effects = _checked_effects(stated, where, own)
    return Vehicle(
        **parts,
        sensors=sensors,
        effects=effects,
        raw=raw,
        own=own,
        path=path,
        origin=origin,
    )


def _refuse_unknown_keys(raw: dict[str, Any], where: str) -> None:
    for name, model in TABLES.items():
        for key in raw.get(name, {}):
            if key not in model.model_fields:
                raise _unknown(where, f"{name}.{key}", tuple(model.model_fields))


def _checked(model: type[BaseModel], raw: Any, where: str, table: str) -> Any:
    if not isinstance(raw, dict):
        raise InputError(f"{where}: {table}: should be a table, [{table}]")
    try:
        return model.model_validate(raw)
    except ValidationError as error:
        first, *rest = faults_of(error, where, table)
        more = f" (and {len(rest)} more)" if rest else ""
        raise InputError(f"{first}{more}", first.hint) from None


def faults_of(error: ValidationError, where: str, table: str) -> list[InputError]:
    """Return what pydantic found wrong with a table, one error a key."""
    faults = []
    for found in error.errors():
        key = ".".join([table, *(str(p) for p in found["loc"] if isinstance(p, str))])
        message = found["msg"].removeprefix("Value error, ")
        if found["type"] == "missing":
            message = "missing"
        elif ": " not in message:
            message = f"{message[0].lower()}{message[1:]}: {_short(found['input'])}"
        hint = advice(key, found["input"])
        faults.append(InputError(f"{where}: {key}: {message}", hint))
    return faults


def _checked_effects(
    raw: dict[str, Any], where: str, own: Mapping[str, OwnEffect]
) -> dict[str, dict[str, Figure | str]]:
    known = {**EFFECTS, **{name: found.effect for name, found in own.items()}}
    checked: dict[str, dict[str, Figure | str]] = {}
    for name, params in raw.items():
        _known_effect(name, where, known)
        if not isinstance(params, dict):
            raise InputError(f"{where}: effects.{name}: should be a table")
        checked[name] = _checked_params(known[name], params, where)
    for name in checked:
        for other in known[name].excludes:
            if other not in checked:
                continue
            if name == "motor_efficiency" and "map" not in checked[name]:
                continue  # a bare scale may stand beside single loss terms
            raise InputError(
                f"{where}: effects.{name}: stands in place of {other}, "
                "and the file states both",
                f"take one of them out; {name} already holds {other}",
            )
    return checked


def _checked_params(
    effect: Effect, raw: dict[str, Any], where: str
) -> dict[str, Figure | str]:
    name = effect.id
    known = {param.name: param for param in effect.params}
    params: dict[str, Figure | str] = {}
    for key, value in raw.items():
        at = f"effects.{name}.{key}"
        if key in effect.files:
            if not isinstance(value, str):
                raise InputError(f"{where}: {at}: should be the name of a file")
            params[key] = value
            continue
        if key not in known:
            raise _unknown(where, at, (*known, *effect.files))
        try:
            figure = Figure.parse(value)
        except ValueError as error:
            raise InputError(f"{where}: {at}: {error}") from None
        low, high = known[key].bounds
        for number in (figure.value, figure.low, figure.high):
            if number is not None and not low <= number <= high:
                raise InputError(
                    f"{where}: {at}: should lie between {low:g} and {high:g}: "
                    f"{number:g}",
                    known[key].about,
                )
        params[key] = figure
    for param in effect.params:
        if param.name not in params and not param.optional:
            raise InputError(
                f"{where}: effects.{name}.{param.name}: missing", param.about
            )
    if not params:
        names = ", ".join((*known, *effect.files))
        raise InputError(f"{where}: effects.{name}: states nothing", f"give {names}")
    return params


def _check_sizes(body: Body, tyres: Tyres, where: str) -> None:
    """Refuse figures that are each believable and together are not."""
    l = body.cg_to_front_axle_m.value + body.cg_to_rear_axle_m.value
    m, I_z = body.mass_kg.value, body.yaw_inertia_kgm2.value
    if not BULK[0] <= m / l**3 <= BULK[1]:
        raise InputError(
            f"{where}: body.mass_kg: {m:g} kg does not go with a wheelbase of {l:g} m",
            "one of them is in another unit; kg and m are meant",
        )
    if not 0.01 <= I_z / (m * l * l) <= 1.0:
        raise InputError(
            f"{where}: body.yaw_inertia_kgm2: {I_z:g} does not go with {m:g} kg "
            f"and a wheelbase of {l:g} m",
            f"about {0.13 * m * l * l:.3g} kg m² would be usual",
        )
    if tyres.radius_m.value > l / 2:
        raise InputError(
            f"{where}: tyres.radius_m: {tyres.radius_m.value:g} m does not go with "
            f"a wheelbase of {l:g} m"
        )


def _known_effect(name: str, where: str, known: Mapping[str, Effect]) -> None:
    if name not in known:
        raise _unknown(where, f"effects.{name}", (*known, "files"))


def _unknown(where: str, key: str, known: tuple[str, ...]) -> InputError:
    hint = did_you_mean(key.rpartition(".")[2], known)
    return InputError(f"{where}: {key}: no such key", hint)


def _likely_key(key: str) -> str:
    keys = [f"{t}.{k}" for t, model in TABLES.items() for k in model.model_fields]
    by_last = [k for k in keys if k.endswith("." + key)]
    return by_last[0] if by_last else "body.mass_kg"


def _short(value: Any) -> str:
    text = repr(value)
    return text if len(text) <= 60 else text[:57] + "..."
