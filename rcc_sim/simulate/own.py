"""The kernel with a user's own effects in it: written out, compiled or interpreted."""

from __future__ import annotations

import functools
import hashlib
import traceback
from collections.abc import Callable
from dataclasses import dataclass
from math import inf
from pathlib import Path
from typing import Any

import numpy as np

from rcc_sim.definitions.own_effects import FOREIGN, KERNEL_MODULE, OwnEffect
from rcc_sim.definitions.vehicle import Vehicle
from rcc_sim.errors import InputError, RccError
from rcc_sim.jit import bound, cache_folder, compiled, jit
from rcc_sim.physics import params as schema
from rcc_sim.physics.record import Schema, arrays, column, dtype_of, floats

GIVEN = {
    "t": "s.t",
    "s": "s.s",
    "v": "v",
    "omega": "c.n * w",
    "a": "a",
    "slope": "u.slope",
    "delta": "u.delta",
}
"""What a function asks for by name -> where the kernel has it."""

ACTS = {"force": "pull", "torque": "twist", "power": "draw"}
WORK = {"force": "ds", "torque": "c.n * dw", "power": "dt"}


@dataclass(frozen=True)
class OwnTerms:
    """The own effects of a vehicle that act in the kernel; often none.

    Parameters
    ----------
    effects : tuple of OwnEffect
        In the order of their ids.
    """

    effects: tuple[OwnEffect, ...]

    @property
    def params(self) -> Schema:
        """The kernel's parameters."""
        own = {e.effect.id: floats(*e.effect.neutral) for e in self.effects}
        return {**schema.PARAMS, **own}

    @property
    def work(self) -> tuple[Schema, ...]:
        """The kernel's other records: chassis, state, inputs, forces, flow."""
        own = floats(*(f"own_{e.effect.id}" for e in self.effects))
        forces = {**schema.FORCES, **own}
        return schema.CHASSIS, schema.STATE, schema.INPUTS, forces, schema.FLOW

    @property
    def sinks(self) -> tuple[str, ...]:
        """Lines of the ledger."""
        return (*schema.SINKS, *(e.effect.sink for e in self.effects))

    def records(self) -> tuple[Any, tuple[Any, ...], Any]:
        """Return zeroed records for the compiled kernel: parameters, work, sinks."""
        P, *work, sinks = arrays(self._kinds)
        return P, tuple(work), sinks

    @functools.cached_property
    def _kinds(self) -> tuple[np.dtype[Any], ...]:
        every = (self.params, *self.work, floats(*self.sinks))
        return tuple(map(dtype_of, every))

    def call(self, kernel: Callable[..., Any], fast: bool, *args: Any) -> None:
        """Run the kernel.

        Raises
        ------
        NotCompiled
            If an own effect is no code that can be compiled.
        InputError
            If one raises.
        """
        if not self.effects:
            (compiled(kernel) if fast else kernel)(*args)
            return
        twin = _with_effects(kernel, self.effects)
        files = {own.where for own in self.effects}
        names = ", ".join(sorted(files))
        try:
            (compiled(twin) if fast else twin)(*args)
        except _compiler_errors(fast) as error:
            raise NotCompiled(f"{names}: cannot be compiled") from error
        except FOREIGN as error:
            passed = _files(error)
            in_compiler = any("numba" in Path(file).parts for file in passed)
            if files & passed or (fast and not in_compiler):
                what = f"raises {type(error).__name__}: {error}"
                raise InputError(f"{names}: {what}") from None
            raise

    def check(self, table: Any, sinks: Any) -> None:
        """Raise if an own effect gave what is no number."""
        for own in self.effects:
            bad = ~np.isfinite(column(sinks, own.effect.sink))
            if bad.any():
                t = column(table, "t")[max(int(bad.argmax()) - 1, 0)]
                v = column(table, "v")[max(int(bad.argmax()) - 1, 0)]
                raise InputError(
                    f"{own.where}: {own.kind}: not a finite number after {t:g} s, "
                    f"at {v:.3g} m/s",
                    "it is called at standstill too",
                )


class NotCompiled(RccError):
    """An own effect that only plain Python can run."""


def own_terms(vehicle: Vehicle) -> OwnTerms:
    """Return the own effects that a vehicle has switched on, sensors aside."""
    return _terms(tuple(o for o in vehicle.own_acting if o.kind != "sensed"))


_terms = functools.cache(OwnTerms)


def _compiler_errors(fast: bool) -> tuple[type[Exception], ...]:
    if not fast:
        return ()
    from numba.core.errors import NumbaError, UnsupportedBytecodeError

    return NumbaError, UnsupportedBytecodeError


def _files(error: BaseException) -> set[str]:
    """Return the files that an error passed through."""
    return {frame.filename for frame in traceback.extract_tb(error.__traceback__)}


@functools.cache
def _with_effects(
    kernel: Callable[..., Any], effects: tuple[OwnEffect, ...]
) -> Callable[..., Any]:
    source = written_out(effects)
    key = hashlib.blake2b(source.encode(), digest_size=8)
    key.update(Path(__file__).read_bytes())
    for own in effects:
        key.update(f"{own.where} {own.digest}".encode())
    folder = cache_folder() / f"own-{key.hexdigest()}"
    place = _kept(folder / "terms.py", source)
    names: dict[str, Any] = {f"own_{e.effect.id}": e.function for e in effects}
    names |= {"inf": inf, "__name__": KERNEL_MODULE}
    exec(compile(source, place, "exec"), names)
    acting = {name: jit(names[name]) for name in ("act", "book_extra", "book_draw")}
    for function in acting.values():
        function.__cache_folder__ = folder
    return bound(kernel, {"EXTRA": True, **acting}, folder)


def written_out(effects: tuple[OwnEffect, ...]) -> str:
    """Return the three functions of ``physics/extra.py`` for these effects."""
    act = ["f.pull = 0.0", "f.twist = 0.0", "f.draw = 0.0"]
    moved, drawn = ["pass"], ["pass"]
    for own in effects:
        name = own.effect.id
        given = ", ".join(GIVEN.get(a, f"p.{name}.{a}") for a in own.takes)
        act += [
            f"f.own_{name} = own_{name}({given})",
            f"if abs(f.own_{name}) < inf:",
            f"    f.{ACTS[own.kind]} += f.own_{name}",
        ]
        booked = drawn if own.kind == "power" else moved
        booked.append(f"E.{own.effect.sink} += f.own_{name} * {WORK[own.kind]}")
    parts = {
        "act(p, c, s, u, f, v, w, a)": act,
        "book_extra(c, f, E, ds, dw)": moved,
        "book_draw(f, E, dt)": drawn,
    }
    return "\n\n".join(
        f"def {head}:\n    " + "\n    ".join(body) + "\n"
        for head, body in parts.items()
    )


def _kept(path: Path, source: str) -> str:
    """Write the source beside its machine code, where that can be kept at all."""
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(source, encoding="utf-8")
    except OSError:
        return "<own effects>"
    return str(path)
