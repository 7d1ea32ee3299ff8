"""What a vehicle file may state: each table and effect checked, key by key."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from pydantic import BaseModel, ValidationError

from rcc_sim.definitions.figure import Figure
from rcc_sim.definitions.own_effects import OwnEffect
from rcc_sim.definitions.tables import Body, Tyres, advice, in_other_unit
from rcc_sim.errors import InputError, did_you_mean
from rcc_sim.physics.effect import Effect
from rcc_sim.physics.effects import EFFECTS

BULK = (5.0, 5000.0)  # kg/m³; mass over wheelbase cubed of anything on four wheels


def checked(model: type[BaseModel], raw: Any, where: str, table: str) -> Any:
    """Return a table of the file, or raise with the first thing wrong in it."""
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


def checked_effects(
    raw: dict[str, Any], where: str, own: Mapping[str, OwnEffect]
) -> dict[str, dict[str, Figure | str]]:
    """Return the effects of a file, or raise with the first thing wrong in them."""
    known = {**EFFECTS, **{name: one.effect for name, one in own.items()}}
    found: dict[str, dict[str, Figure | str]] = {}
    for name, params in raw.items():
        known_effect(name, where, known)
        if not isinstance(params, dict):
            raise InputError(f"{where}: effects.{name}: should be a table")
        found[name] = _checked_params(known[name], params, where)
    for name in found:
        for other in known[name].excludes:
            if other not in found:
                continue
            if name == "motor_efficiency" and "map" not in found[name]:
                continue  # a bare scale may stand beside single loss terms
            raise InputError(
                f"{where}: effects.{name}: stands in place of {other}, "
                "and the file states both",
                f"take one of them out; {name} already holds {other}",
            )
    return found


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
            raise unknown_key(where, at, (*known, *effect.files))
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
                    in_other_unit(key, number, low, high) or known[key].about,
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


def check_sizes(body: Body, tyres: Tyres, where: str) -> None:
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


def known_effect(name: str, where: str, known: Mapping[str, Effect]) -> None:
    """Raise if there is no effect of that name."""
    if name not in known:
        hint = did_you_mean(name, (*known, "files"))
        raise InputError(f"{where}: effects.{name}: no such key", hint)


def unknown_key(where: str, key: str, known: tuple[str, ...]) -> InputError:
    """Return the error of a key that no table has; the nearest name is the hint."""
    table, dot, name = key.rpartition(".")
    hint = did_you_mean(name, known, table + dot)
    if not table and name in EFFECTS:
        hint = f"an effect is a table of its own: [effects.{name}]"
    return InputError(f"{where}: {key}: no such key", hint)


def _short(value: Any) -> str:
    text = repr(value)
    return text if len(text) <= 60 else text[:57] + "..."
