"""The only compiler decorator: plain Python functions with a machine-code twin.

A function marked with :func:`jit` stays plain Python, so short runs pay for no
compiler and importing the physics costs nothing. :func:`compiled` builds its
machine-code twin with numba, and with it the twins of every marked function that
it calls. Both give the same result to the last bit: no fast-math, no reordering.
"""

from __future__ import annotations

import dis
import functools
import os
import sys
from collections.abc import Callable, Mapping
from pathlib import Path
from threading import Lock
from types import FunctionType
from typing import Any, TypeVar

F = TypeVar("F", bound=Callable[..., Any])


KERNELS = ("physics/**/*.py", "blind/plant*.py", "units.py", "jit.py")
"""Files of the package that kernel code, and the constants that it reads, stand in."""

ONE_FOLDER = Lock()
"""Held while numba looks where to keep a twin: threads ask for twins side by side."""

TELL: list[Callable[[str], None]] = []
"""What is told, once a process, that it has to compile and how long that takes."""


def jit(function: F) -> F:
    """Mark a function as kernel code (floats, arrays and records only).

    Kernel code calls other kernel code by its bare name (``from x import f``). It makes
    no arrays: who made none need not count who holds those that it is handed, which
    costs atomic operations wherever one is handed on, twice the time of a whole tick.
    """
    function.__kernel__ = True  # type: ignore[attr-defined]
    return function


def makes_arrays(function: F) -> F:
    """Mark kernel code that may make arrays, and counts who holds them."""
    function.__makes_arrays__ = True  # type: ignore[attr-defined]
    return jit(function)


def over_arrays(function: F) -> F:
    """Mark kernel code that goes through whole arrays, and is not in any hot loop.

    It is called where it stands, not written out there, and compiles several times as
    fast.
    """
    function.__called__ = True  # type: ignore[attr-defined]
    return makes_arrays(function)


@functools.cache
def compiled(
    function: Callable[..., Any], *, inner: bool = False
) -> Callable[..., Any]:
    """Return the machine-code twin of a function marked with :func:`jit`.

    An ``inner`` one is called by other twins alone: without what lets Python call it
    it takes two thirds of the time to compile. The twin is cached on disk below
    :func:`cache_folder`, whose name follows :data:`KERNELS`: an edit of any of them is
    a new cache, because numba's own check looks at the file of the called function
    alone. Where that folder cannot be written, it compiles anew.
    """
    numba = _numba()
    assert isinstance(function, FunctionType)
    twin = _twin(function, Twins(used(function)))
    folder = getattr(function, "__cache_folder__", cache_folder())
    options: dict[str, Any] = {
        "cache": _can_cache(),
        "error_model": "numpy",
        "nogil": True,
        "_nrt": hasattr(function, "__makes_arrays__"),
        "forceinline": not hasattr(function, "__called__"),
    }
    if inner:
        options |= {"no_cpython_wrapper": True, "no_cfunc_wrapper": True}
    # the two ways have the same name there: Python calls one of them, and dies of the
    # other
    with ONE_FOLDER:
        numba.config.CACHE_DIR = str(folder / "inner" if inner else folder)
        made: Callable[..., Any] = numba.njit(**options)(twin)
    return made


@functools.cache
def _numba() -> Any:
    """Return numba, loaded without its linear algebra, which no kernel uses.

    It would load ``scipy.linalg`` to see whether there is a BLAS, a fifth of a second.
    """
    import numba

    absent = "scipy.linalg" not in sys.modules
    if absent:
        sys.modules["scipy.linalg"] = None  # type: ignore[assignment]
    try:
        import numba.np.arraymath
    finally:
        if absent:
            del sys.modules["scipy.linalg"]
    if TELL:
        _announce()
    return numba


def _announce() -> None:
    """Have each of ``TELL`` called as the first kernel that is on no disk compiles."""
    from numba.core import event

    class Compiling(event.Listener):
        def on_start(self, event: Any) -> None:
            kept = "once for this version"
            if not _can_cache():
                kept = (
                    f"for this run alone: {cache_folder().parent} cannot be written, "
                    "RCCSIM_CACHE may name another folder"
                )
            while TELL:
                TELL.pop()(f"compiling the kernel (some tens of seconds), {kept}")

        def on_end(self, event: Any) -> None:
            pass

    event.register("numba:compile", Compiling())


def bound(
    function: Callable[..., Any], names: Mapping[str, Any], folder: Path
) -> Callable[..., Any]:
    """Return kernel code with other values for some of the global names that it reads.

    The copy reaches through every kernel function that it calls; it is kernel code too,
    whose machine code is kept in ``folder``.
    """
    made: dict[Callable[..., Any], Callable[..., Any]] = {}

    def copied(value: Any) -> Any:
        if not hasattr(value, "__kernel__"):
            return value
        if value not in made:
            made[value] = twin = _twin(
                value,
                {
                    name: names[name] if name in names else copied(inner)
                    for name, inner in used(value).items()
                },
            )
            twin.__dict__.update(value.__dict__)
            twin.__cache_folder__ = folder
        return made[value]

    twin: Callable[..., Any] = copied(function)
    return twin


class Twins(dict[str, Any]):
    """Global names that kernel code reads, with the twins of the kernel code it calls.

    These are made once asked for: not at all where the caller's own machine code is
    found on disk.
    """

    def __init__(self, names: Mapping[str, Any]) -> None:
        kernels = {k for k, value in names.items() if hasattr(value, "__kernel__")}
        super().__init__({k: v for k, v in names.items() if k not in kernels})
        self._kernels = {k: names[k] for k in kernels}

    def __missing__(self, name: str) -> Any:
        self[name] = twin = compiled(self._kernels[name], inner=True)
        return twin


def _twin(function: Any, names: dict[str, Any]) -> Any:
    """Return a function of the same code that reads other globals."""
    names["__builtins__"] = __builtins__
    names["__name__"] = function.__module__
    twin = FunctionType(
        function.__code__,
        names,
        function.__name__,
        function.__defaults__,
    )
    twin.__module__ = function.__module__
    twin.__qualname__ = function.__qualname__
    return twin


def used(function: Any) -> dict[str, Any]:
    """Return the globals that a function reads, whose values its machine code holds.

    (co_names holds attributes too.)
    """
    names = {
        step.argval
        for step in dis.get_instructions(function)
        if step.opname == "LOAD_GLOBAL"
    }
    return {k: v for k, v in function.__globals__.items() if k in names}


def compiler_is_loaded() -> bool:
    """Tell whether numba has been paid for already in this process."""
    return "numba" in sys.modules


@functools.cache
def cache_folder() -> Path:
    """Return the folder that holds the compiled kernels of exactly this source."""
    import platformdirs

    root = os.environ.get("RCCSIM_CACHE") or platformdirs.user_cache_dir("rccsim")
    return Path(root) / f"kernels-{source_digest()}"


@functools.cache
def _can_cache() -> bool:
    """Tell whether the cache folder can be written; if not, each process compiles."""
    try:
        cache_folder().mkdir(parents=True, exist_ok=True)
    except OSError:
        return False
    return os.access(cache_folder(), os.W_OK)


@functools.cache
def source_digest() -> str:
    """Return a digest of the package's kernel source, :data:`KERNELS`."""
    import hashlib  # 10 ms that no short command has to pay

    package = Path(__file__).parent
    digest = hashlib.blake2b(digest_size=8)
    for path in sorted(path for kind in KERNELS for path in package.glob(kind)):
        digest.update(path.relative_to(package).as_posix().encode())
        digest.update(path.read_bytes())
    return digest.hexdigest()
