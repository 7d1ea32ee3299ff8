"""Libraries that only some readers need, and what broken files make them raise."""

from __future__ import annotations

import contextlib
import sqlite3
import struct
from collections.abc import Iterator
from importlib import import_module
from typing import Any

from rcc_sim.errors import InputError

BROKEN: tuple[type[Exception], ...] = (
    AssertionError,
    AttributeError,
    EOFError,
    LookupError,
    MemoryError,
    NotImplementedError,
    OSError,
    RuntimeError,
    TypeError,
    ValueError,
    sqlite3.Error,
    struct.error,
)
"""What libraries raise on a file that is cut short or not what it says."""


def library(name: str, extra: str, where: str) -> Any:
    """Import a module of an optional library.

    Raises
    ------
    InputError
        If it is not installed, with what to install.
    """
    try:
        return import_module(name)
    except ImportError:
        top = name.partition(".")[0]
        raise InputError(
            f"{where}: this format needs the library {top}, which is not installed",
            f"pip install 'rccsim[{extra}]'",
        ) from None


@contextlib.contextmanager
def broken_file(
    where: str, what: str, *also: type[Exception], hint: str = ""
) -> Iterator[None]:
    """Turn what a library raises on a broken file into our error.

    Raises
    ------
    InputError
        In place of it; one of our own passes.
    """
    try:
        yield
    except InputError:
        raise
    except (*BROKEN, *also) as error:
        reason = " ".join(str(error).split())[:200] or type(error).__name__
        raise InputError(f"{where}: a broken {what}: {reason}", hint) from None
