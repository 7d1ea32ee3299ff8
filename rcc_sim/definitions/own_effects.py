"""A user's own effects: a Python file or an installed plugin, loaded and checked."""

from __future__ import annotations

import functools
import hashlib
import inspect
import math
import re
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field, replace
from pathlib import Path
from types import FunctionType, ModuleType
from typing import Any

from rcc_sim.errors import InputError, did_you_mean
from rcc_sim.jit import cache_folder, makes_arrays, used
from rcc_sim.physics.effect import ACTS, DRIVES, OF, Effect
from rcc_sim.physics.effects import EFFECTS
from rcc_sim.physics.params import PARAMS, SINKS

KINDS = {"force": "N", "torque": "N m", "power": "W", "sensed": "columns"}
"""Functions that an effect may have, one of them, and what they return."""

MOMENT = {
    "t": 1.0,
    "s": 10.0,
    "v": 2.0,
    "omega": 400.0,
    "a": 0.3,
    "slope": 0.01,
    "delta": 0.05,
}
"""What a function may ask for, with the values that it is tried with: time [s],
distance [m], speed [m/s], motor speed [rad/s], acceleration [m/s²], slope [1],
angle of the road wheels [rad]."""

GROUP = "rccsim.effects"
"""Entry points of plugins: the effect's id, and the module that holds it."""

KERNEL_MODULE = "rcc_sim.physics.extra"
"""Name that a file's code bears: the compiler's cache asks for one to be imported."""

FOREIGN = (
    *(ArithmeticError, AssertionError, AttributeError, ImportError, LookupError),
    *(NameError, OSError, RuntimeError, SyntaxError, TypeError, ValueError),
)
"""What a user's code may raise and is told of; anything else is our own mistake."""


@dataclass(frozen=True)
class OwnEffect:
    """An effect that is not shipped.

    Parameters
    ----------
    effect : Effect
        What it says of itself; its ledger line has its id where it names none.
    kind : str
        "force", "torque", "power" or "sensed".
    function : callable
        The function of that name.
    takes : tuple of str
        Names of its arguments, in order.
    where : str
        Its file, or "plugin NAME".
    digest : str
        Digest of its source, and of how it is loaded: it names the machine code.
    """

    effect: Effect
    kind: str
    function: Callable[..., Any] = field(compare=False)
    takes: tuple[str, ...]
    where: str
    digest: str

    def __reduce__(self) -> tuple[Any, tuple[str]]:
        """Load anew in another process."""
        return own_effect, (self.where,)


def own_effect(where: str) -> OwnEffect:
    """Return the effect of a Python file, or of ``plugin NAME``.

    Raises
    ------
    InputError
        If there is none, or it is not sound; says what should be put right.
    """
    if where.startswith("plugin "):
        return _of_plugin(where.removeprefix("plugin "))
    path = Path(where).expanduser()
    if path.suffix != ".py":
        raise InputError(f"{where}: an effect should be a Python file, *.py")
    try:
        source = path.read_bytes()
    except OSError as error:
        raise InputError(f"{where}: cannot be read: {error.strerror}") from None
    return _of_source(str(path), source)


def plugin_names() -> list[str]:
    """Return the ids of the effects of installed plugins; nothing is imported."""
    from importlib.metadata import entry_points

    return sorted({point.name for point in entry_points(group=GROUP)})


def installed_effects() -> dict[str, Effect]:
    """Return the effects of installed plugins by id.

    Raises
    ------
    InputError
        If one is not sound.
    """
    return {name: own_effect(f"plugin {name}").effect for name in plugin_names()}


def own_effects(
    raw: dict[str, Any], where: str, path: Path | None
) -> tuple[dict[str, OwnEffect], dict[str, Any]]:
    """Return the effects that are not shipped, and [effects] without their files.

    Raises
    ------
    InputError
        If a file of the list ``effects.files`` is missing or holds no sound effect.
    """
    files = raw.get("files", [])
    if not isinstance(files, list) or not all(isinstance(f, str) for f in files):
        raise InputError(f"{where}: effects.files: should be a list of file names")
    folder = path.parent if path else Path()
    own: dict[str, OwnEffect] = {}
    for file in files:
        found = own_effect(str(folder / file))
        twice = own.setdefault(found.effect.id, found)
        if twice != found:
            raise InputError(
                f"{where}: effects.files: two effects are called {found.effect.id}: "
                f"{twice.where}, {found.where}"
            )
    stated = {name: params for name, params in raw.items() if name != "files"}
    missing = [name for name in stated if name not in EFFECTS and name not in own]
    installed = plugin_names() if missing else []
    plugins = {n: own_effect(f"plugin {n}") for n in missing if n in installed}
    return {**own, **plugins}, stated


def _of_plugin(name: str) -> OwnEffect:
    from importlib import import_module
    from importlib.metadata import entry_points

    where = f"plugin {name}"
    points = [p for p in entry_points(group=GROUP) if p.name == name]
    if not points:
        raise InputError(f"{where}: not installed")
    try:
        module = import_module(points[0].module)
        source = inspect.getsource(module).encode()
    except FOREIGN as error:
        raise InputError(f"{where}: {_told(error)}") from None
    made = _checked(where, module, source)
    if made.effect.id != name:
        raise InputError(
            f"{where}: the entry point should be named as its effect: {made.effect.id}"
        )
    return made


@functools.cache
def _of_source(where: str, source: bytes) -> OwnEffect:
    module = ModuleType(KERNEL_MODULE)
    module.__file__ = where
    try:
        exec(compile(source, where, "exec"), vars(module))
    except FOREIGN as error:
        raise InputError(f"{where}: {_told(error)}") from None
    return _checked(where, module, source)


def _checked(where: str, module: ModuleType, source: bytes) -> OwnEffect:
    effect = getattr(module, "EFFECT", None)
    if not isinstance(effect, Effect):
        raise InputError(
            f"{where}: EFFECT: missing",
            "an effect's file holds EFFECT = Effect(...), from rcc_sim.physics.effect",
        )
    _check_claims(where, effect)
    found = [kind for kind in KINDS if callable(getattr(module, kind, None))]
    if len(found) != 1:
        raise InputError(
            f"{where}: should hold one function named {', '.join(KINDS)}: "
            f"{', '.join(found) or 'none'}",
        )
    kind = found[0]
    function = getattr(module, kind)
    helpers = [
        value
        for value in vars(module).values()
        if isinstance(value, FunctionType) and value.__module__ == module.__name__
    ]
    digest = _digest(source, helpers)
    for helper in helpers:
        helper.__dict__["__cache_folder__"] = cache_folder() / f"own-{digest}"
        makes_arrays(helper)
    takes = tuple(inspect.signature(function).parameters)
    if kind == "sensed":
        effect = replace(effect, sensor=True)
    elif not effect.sink:
        effect = replace(effect, sink=effect.id)
    if effect.sink in SINKS:
        raise InputError(f"{where}: EFFECT.sink: already another's: {effect.sink}")
    made = OwnEffect(effect, kind, function, takes, where, digest)
    _check_signature(made)
    if kind == "sensed":
        _try_columns(made)
    else:
        _try_number(made)
    return made


def _digest(source: bytes, helpers: Iterable[FunctionType]) -> str:
    """Return a digest of an effect: its source, and the values that its code reads.

    A constant may come from a file, or from another module: machine code holds it.
    """
    digest = hashlib.blake2b(source, digest_size=8)
    digest.update(Path(__file__).read_bytes())
    for helper in helpers:
        for name, value in sorted(used(helper).items()):
            if isinstance(value, FunctionType):
                file = Path(value.__code__.co_filename)
                read = file.read_bytes() if file.is_file() else value.__code__.co_code
            elif hasattr(value, "tobytes"):
                read = f"{value.dtype} {value.shape}".encode() + value.tobytes()
            else:
                read = repr(value).encode()
            digest.update(name.encode() + read)
    return digest.hexdigest()


def _check_claims(where: str, effect: Effect) -> None:
    at = f"{where}: EFFECT"
    if not re.fullmatch(r"[a-z][a-z0-9_]*", effect.id):
        raise InputError(f"{at}.id: should be lower_snake_case: {effect.id!r}")
    if effect.id in EFFECTS or effect.id in PARAMS or effect.id == "files":
        raise InputError(f"{at}.id: already another's: {effect.id}")
    if effect.sink and not re.fullmatch(r"[a-z][a-z0-9_]*", effect.sink):
        raise InputError(f"{at}.sink: should be lower_snake_case: {effect.sink!r}")
    if not effect.params:
        raise InputError(f"{at}.params: should hold at least one Param")
    for param in effect.params:
        name = f"{at}: {param.name}"
        if not param.name.isidentifier() or param.name in MOMENT:
            raise InputError(f"{name}: cannot be the name of a parameter")
        if not param.bounds[0] <= param.neutral <= param.bounds[1]:
            raise InputError(f"{name}: neutral should lie within bounds")
        if not param.bounds[0] <= param.typical[0] < param.typical[1]:
            raise InputError(f"{name}: typical should be a range within bounds")
        if not param.typical[1] <= param.bounds[1]:
            raise InputError(f"{name}: typical should be a range within bounds")
        sought = param.sought
        _check_words(f"{name}: sought.of", [sought.of], OF)
        _check_words(f"{name}: sought.acts", [sought.acts], ACTS)
        _check_words(f"{name}: sought.shows_in", sought.shows_in, DRIVES)
    _check_words(f"{at}.shows_in", effect.shows_in, DRIVES)


def _check_words(at: str, words: Iterable[str], known: Iterable[str]) -> None:
    for word in words:
        if word not in known:
            raise InputError(f"{at}: {word!r}", did_you_mean(word, known))


def _check_signature(own: OwnEffect) -> None:
    params = [param.name for param in own.effect.params]
    at = f"{own.where}: {own.kind}({', '.join(own.takes)})"
    if own.kind == "sensed":
        if own.takes != ("columns", "time", *params):
            wanted = ", ".join(("columns", "time", *params))
            raise InputError(f"{at}: should be sensed({wanted})")
        return
    unknown = [name for name in own.takes if name not in (*MOMENT, *params)]
    if unknown:
        raise InputError(
            f"{at}: no such quantity: {unknown[0]}",
            f"it may take {', '.join((*MOMENT, *params))}",
        )
    unused = [name for name in params if name not in own.takes]
    if unused:
        raise InputError(f"{at}: should take its parameter {unused[0]}")


def _try_number(own: OwnEffect) -> None:
    neutral = own.effect.neutral
    usual = {p.name: 0.5 * (p.typical[0] + p.typical[1]) for p in own.effect.params}
    for values, what in ((neutral, "neutral"), (usual, "a typical value")):
        arguments = [(MOMENT | values)[name] for name in own.takes]
        try:
            result = own.function(*arguments)
            number = float(result)
        except FOREIGN as error:
            raise InputError(f"{own.where}: {own.kind}: {_told(error)}") from None
        if not math.isfinite(number):
            raise InputError(f"{own.where}: {own.kind}: {number} at {what}")
        if values is neutral and number != 0.0:
            raise InputError(
                f"{own.where}: {own.kind}: should vanish at neutral: {number:g} "
                f"{KINDS[own.kind]}",
                "so that an effect may be switched off by its parameters alone",
            )


def _try_columns(own: OwnEffect) -> None:
    import numpy as np

    time = np.arange(4.0)
    columns = {name: np.ones(4) for name in (*own.effect.channels, "speed_mps")}
    usual = [0.5 * (p.typical[0] + p.typical[1]) for p in own.effect.params]
    try:
        sensed_by(own, columns | {"time_s": time}, usual)
    except FOREIGN as error:
        raise InputError(f"{own.where}: sensed: {_told(error)}") from None


def sensed_by(
    own: OwnEffect, columns: dict[str, Any], values: Iterable[float]
) -> dict[str, Any]:
    """Return the columns that an own sensor effect changes, checked.

    Raises
    ------
    InputError
        If what it returns is no mapping of such columns, or not finite.
    """
    import numpy as np

    at = f"{own.where}: sensed"
    try:
        changed = own.function(columns, columns["time_s"], *values)
        seen = {k: np.asarray(v, dtype=float) for k, v in dict(changed).items()}
    except FOREIGN as error:
        raise InputError(f"{at}: {_told(error)}") from None
    for name, column in seen.items():
        if name not in columns or name == "time_s":
            raise InputError(f"{at}: returns a column that is not there: {name}")
        if column.shape != columns["time_s"].shape:
            raise InputError(
                f"{at}: {name}: should have {len(columns['time_s'])} rows: "
                f"{column.size}"
            )
        if not np.isfinite(column).all():
            raise InputError(f"{at}: {name}: should be finite throughout")
    return seen


def _told(error: BaseException) -> str:
    line = getattr(error, "lineno", None)
    at = f" (line {line})" if isinstance(error, SyntaxError) and line else ""
    text = error.msg if isinstance(error, SyntaxError) else str(error)
    return f"{type(error).__name__}: {text.splitlines()[0] if text else ''}{at}"
