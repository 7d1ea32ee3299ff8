"""What was run: versions, inputs with their hashes, seed, command line."""

from __future__ import annotations

import hashlib
import platform
import shlex
import sys
from collections.abc import Sequence
from importlib import metadata
from pathlib import Path
from typing import Any

from rcc_sim.definitions.library import names

LIBRARIES = ("numpy", "scipy", "numba", "pandas", "pyarrow")


def run_record(inputs: Sequence[str | Path], seed: int | None = None) -> dict[str, Any]:
    """Return what somebody needs to run the same again.

    Parameters
    ----------
    inputs : sequence of str or Path
        What the command read: files, or vehicles by name; ``-`` has no hash.
    seed : int, optional
        Of the draws, where there were any.
    """
    from rcc_sim import __version__

    versions = {"rccsim": __version__, "python": platform.python_version()}
    versions |= {name: metadata.version(name) for name in LIBRARIES}
    arguments = [Path(sys.argv[0]).name, *sys.argv[1:]]
    if arguments[0] == "__main__.py":
        arguments[0] = "rccsim"
    return {
        "command": shlex.join(arguments),
        "seed": seed,
        "inputs": [{"name": str(i), "sha256": sha256(i)} for i in inputs],
        "versions": versions,
    }


def sha256(name: str | Path) -> str | None:
    """Return the SHA-256 of a file, or of a vehicle's by its name; None for ``-``.

    Raises
    ------
    OSError
        If the file cannot be read.
    """
    path = Path(name)
    if not path.is_file():
        known = names("vehicles", (".toml",))
        path = next((e.path for e in known if e.name == str(name)), path)
    if not path.is_file():
        return None
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()
