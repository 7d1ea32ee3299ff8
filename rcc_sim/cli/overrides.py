"""Options that change a vehicle for one run: --set, --with, --without."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any

import typer

from rcc_sim.cli.complete import effect_names, figure_keys, own_effects
from rcc_sim.errors import InputError, did_you_mean

if TYPE_CHECKING:
    from collections.abc import Mapping

    from rcc_sim.definitions.vehicle import Vehicle
    from rcc_sim.physics.effect import Effect

Set = Annotated[
    list[str] | None,
    typer.Option(
        "--set",
        metavar="KEY=VALUE",
        help="A figure, as body.mass_kg=4.1.",
        autocompletion=figure_keys,
    ),
]
With = Annotated[
    list[str] | None,
    typer.Option(
        "--with",
        metavar="ID:PARAM=VALUE",
        help="Add an effect, as rolling_resistance:coefficient=0.02.",
        autocompletion=effect_names,
    ),
]
Without = Annotated[
    list[str] | None,
    typer.Option(
        "--without",
        metavar="ID",
        help="Take an effect out.",
        autocompletion=own_effects,
    ),
]

Own = Annotated[
    list[str] | None,
    typer.Option(
        "--effect",
        metavar="FILE",
        help="A Python file with an effect of your own; --with switches it on.",
    ),
]


def vehicle_of(name: str) -> Vehicle:
    """Load a vehicle, and tell which of its figures no car of any size has."""
    from rcc_sim.definitions.vehicle import load_vehicle

    return _looked_at(load_vehicle(name))


def _looked_at(vehicle: Vehicle) -> Vehicle:
    from rcc_sim.cli.output import say
    from rcc_sim.similitude.unlikely import unlikely

    for what, hint in unlikely(vehicle):
        say(f"note: {vehicle.name}: {what} ({hint})")
    return vehicle


def changed_vehicle(
    name: str,
    settings: list[str] | None,
    added: list[str] | None,
    removed: list[str] | None,
    files: list[str] | None = None,
) -> Vehicle:
    """Load a vehicle and apply --effect, --set, --with and --without to it."""
    from rcc_sim.definitions.vehicle import load_vehicle

    vehicle = load_vehicle(name)
    if not (settings or added or removed or files):
        return _looked_at(vehicle)
    if files:
        vehicle = vehicle.changed(files=tuple(files))
    effects: dict[str, dict[str, Any]] = {}
    given: dict[str, str] = {}
    for text in added or []:
        effect, params = _effect(text, vehicle)
        effects.setdefault(effect, {}).update(params)
        given |= {f"effects.{effect}.{param}": f"--with {text}" for param in params}
    figures = {}
    for text in settings or []:
        key, value = _setting("--set", text)
        figures[key] = value
        given[key] = f"--set {text}"
    try:
        changed = vehicle.changed(
            settings=figures, effects=effects, without=tuple(removed or ())
        )
    except InputError as error:
        raise _blamed(error, vehicle, given) from None
    for own in changed.own.values():
        if own.effect.id not in changed.effects and files:
            param = own.effect.params[0].name
            raise InputError(
                f"{own.where}: {own.effect.id} is not switched on",
                f"--with {own.effect.id}:{param}=VALUE does",
            )
    return _looked_at(changed)


def _blamed(error: InputError, vehicle: Vehicle, given: dict[str, str]) -> InputError:
    """Return an error that names the option where the file was not at fault."""
    what = str(error).removeprefix(f"{vehicle.where}: ")
    for key, option in given.items():
        if what.startswith(f"{key}: "):
            return InputError(f"{option}: {what.removeprefix(f'{key}: ')}", error.hint)
    return error


def _setting(option: str, text: str) -> tuple[str, Any]:
    import tomli

    key, equals, value = text.partition("=")
    if not equals or not key.strip() or not value.strip():
        raise InputError(f"{option} {text}: should be KEY=VALUE")
    try:
        return key.strip(), tomli.loads(f"x = {value}")["x"]
    except tomli.TOMLDecodeError:
        return key.strip(), value.strip()


def _as_typed(text: str, known: Mapping[str, Effect]) -> str:
    """Return what ID=VALUE or ID.PARAM=VALUE is likely meant for; empty if nothing."""
    name, equals, value = text.partition("=")
    effect, _, param = name.strip().partition(".")
    if not equals or effect not in known:
        return ""
    names = [p.name for p in known[effect].params]
    return f"{effect}:{param if param in names else names[0]}={value.strip()}"


def _effect(text: str, vehicle: Vehicle) -> tuple[str, dict[str, Any]]:
    from rcc_sim.definitions.own_effects import installed_effects
    from rcc_sim.physics.effect import meant

    effect, colon, rest = text.partition(":")
    known = vehicle.known
    if effect not in known:
        known |= installed_effects()
    if not colon and (likely := _as_typed(text, known)):
        hint = f"did you mean `{likely}`?"
        raise InputError(f"--with {text}: should be ID:PARAM=VALUE", hint)
    if effect not in known:
        what = f"--with {text}: no such effect: {effect}"
        raise InputError(what, meant(effect, known))
    names = [*(p.name for p in known[effect].params), *known[effect].files]
    if not colon or "=" not in rest:
        raise InputError(
            f"--with {text}: should be ID:PARAM=VALUE",
            f"{effect} takes {', '.join(names)}",
        )
    parts = rest.split(",")
    if any(part.strip().isdecimal() for part in parts[1:]):
        raise InputError(
            f"--with {text}: should be ID:PARAM=VALUE",
            f"with a decimal point: {effect}:{rest.replace(',', '.')}",
        )
    params = dict(_setting("--with", part) for part in parts)
    for param in params:
        if param not in names:
            raise InputError(
                f"--with {text}: {effect} has no {param}", did_you_mean(param, names)
            )
    return effect, params
