"""A vehicle as a user writes it: a TOML file, checked key by key."""

from __future__ import annotations

import copy
import os
from dataclasses import dataclass, field
from functools import cached_property
from math import hypot, sqrt
from pathlib import Path
from typing import Any

from rcc_sim.definitions import library
from rcc_sim.definitions.checks import (
    check_sizes,
    checked,
    checked_effects,
    known_effect,
    unknown_key,
)
from rcc_sim.definitions.figure import Figure
from rcc_sim.definitions.own_effects import OwnEffect, own_effects
from rcc_sim.definitions.sensors import checked_sensors, delays_of, without_latencies
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
)
from rcc_sim.definitions.vehicle_file import resolved
from rcc_sim.errors import InputError
from rcc_sim.physics.effect import Effect
from rcc_sim.physics.effects import EFFECTS, sensor_delay
from rcc_sim.units import J_PER_WH

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
DELAYS = sensor_delay.EFFECT.id
EFFICIENCY = "effects.motor_efficiency.scale"


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
    def mode(self) -> str:
        """What its controller obeys: speed, torque or throttle; torque without one."""
        return self.controller.mode if self.controller else "torque"

    @property
    def own_acting(self) -> tuple[OwnEffect, ...]:
        """Effects of the user's own that are switched on, by their names."""
        return tuple(self.own[n] for n in sorted(self.effects) if n in self.own)

    @property
    def wheelbase(self) -> float:
        """Distance between the axles. [m]"""
        return self.body.cg_to_front_axle_m.value + self.body.cg_to_rear_axle_m.value

    @property
    def lever(self) -> float:
        """Way of the vehicle as its motor turns by a radian, r_w/N_d. [m]"""
        return self.tyres.radius_m.value / self.drivetrain.gear_ratio.value

    @property
    def rad_per_m(self) -> float:
        """Angle that its motor turns by per way of the vehicle, N_d/r_w. [rad/m]"""
        return self.drivetrain.gear_ratio.value / self.tyres.radius_m.value

    @property
    def battery_energy(self) -> float | None:
        """Energy of a full battery, the product of what it is made of. [J]

        None where one of them is not stated.
        """
        known = self.figures()
        if not all(key in known for key in self.battery_energy_of):
            return None
        capacity, volts = (known[key].value for key in self.battery_energy_of)
        return capacity * volts * J_PER_WH

    @property
    def battery_energy_of(self) -> tuple[str, str]:
        """Figures of which that is made: capacity, and nominal voltage if stated.

        Else the open-circuit voltage.
        """
        nominal = self.battery.nominal_voltage_v is not None
        volts = "nominal_voltage_v" if nominal else "open_circuit_voltage_v"
        return "battery.capacity_ah", f"battery.{volts}"

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

    def states(self, key: str) -> bool:
        """Tell whether the file states a figure of a dotted key, or the poles."""
        return key in self._figures or (
            key == "motor.poles" and self.motor.poles is not None
        )

    def noise_sd(self, column: str) -> float | None:
        """Return a sensor's noise, its resolution in it, where the file states it."""
        sensor = self.sensors.get(column)
        if sensor is None or sensor.noise_sd is None:
            return None
        step = sensor.resolution.value if sensor.resolution else 0.0
        return hypot(sensor.noise_sd.value, step / sqrt(12))

    def bias_sd(self, column: str) -> float | None:
        """Return the offset that the file allows a sensor, where it states one."""
        sensor = self.sensors.get(column)
        return sensor.bias_sd.value if sensor and sensor.bias_sd else None

    @property
    def named_files(self) -> list[Path]:
        """Files that its effects name: a map of efficiency, a road."""
        return [
            library.named_by(self.path, value)
            for params in self.effects.values()
            for value in params.values()
            if isinstance(value, str)
        ]

    @cached_property
    def known(self) -> dict[str, Effect]:
        """Effect id -> effect: those shipped, and the vehicle's own."""
        return {**EFFECTS, **{name: own.effect for name, own in self.own.items()}}

    def effect_bounds(self, key: str) -> tuple[float, float]:
        """Return the least and the most that a figure of an effect may be.

        Where no map is stated that it multiplies, an efficiency is no more than one.
        """
        _, effect, name = key.split(".")
        low, high = self.known[effect].param(name).bounds
        alone = key == EFFICIENCY and "map" not in self.effects.get(effect, {})
        return low, 1.0 if alone else high

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
            known_effect(name, self.where, self.known)
            raw["effects"].pop(name, None)
            if name == DELAYS:
                raw["sensors"] = without_latencies(raw.get("sensors", {}))
            if name not in self.effects:
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
            raise unknown_key(where, name, known)
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
        else checked(model, raw.get(name, {}), where, name)
        for name, model in TABLES.items()
        if name in raw or name in ("motor", "battery")
    }
    parts.setdefault("controller", None)
    sensors = checked_sensors(raw.get("sensors", {}), where)
    check_sizes(parts["body"], parts["tyres"], where)
    own, stated = own_effects(raw.get("effects", {}), where, path)
    effects = checked_effects(stated, where, own)
    if delays := delays_of(sensors, where):
        effects[DELAYS] = {**delays, **effects.get(DELAYS, {})}
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
                raise unknown_key(where, f"{name}.{key}", tuple(model.model_fields))


def _likely_key(key: str) -> str:
    keys = [f"{t}.{k}" for t, model in TABLES.items() for k in model.model_fields]
    by_last = [k for k in keys if k.endswith("." + key)]
    return by_last[0] if by_last else "body.mass_kg"
