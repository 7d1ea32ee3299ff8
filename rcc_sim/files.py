"""Files that appear whole or not at all."""

from __future__ import annotations

import contextlib
import os
import tempfile
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import IO, Any

from rcc_sim.errors import InputError, not_written


@contextlib.contextmanager
def atomic(path: Path, mode: str = "w") -> Iterator[IO[Any]]:
    """Open a file for writing that appears whole or not at all.

    Until it does it lies beside its place, its name ending alike; what is there
    already stays if the work within raises.

    Parameters
    ----------
    path : Path
        File to write; a device or a named pipe is written as it is.
    mode : str
        "w" for text in UTF-8, "wb" for bytes.

    Raises
    ------
    InputError
        If the folder is missing, not writable, or the disk is full.
    """
    text: dict[str, Any] = {} if "b" in mode else {"encoding": "utf-8", "newline": ""}
    temporary = None
    try:
        if path.exists() and not path.is_file():  # /dev/null, a named pipe
            if path.is_dir():
                raise InputError(f"{path}: is a folder; name a file in it")
            with open(path, mode, **text) as file:
                yield file
            return
        number, temporary = tempfile.mkstemp(
            dir=path.parent, prefix=f".{path.stem}.", suffix=path.suffix
        )
        os.close(number)
        with open(temporary, mode, **text) as file:
            yield file
            file.flush()
            os.fsync(file.fileno())
        mask = os.umask(0)
        os.umask(mask)
        os.chmod(temporary, 0o666 & ~mask)
        os.replace(temporary, path)
        temporary = None
    except OSError as error:
        if isinstance(error, BrokenPipeError):
            raise
        raise not_written(path, error) from None
    finally:
        if temporary is not None:
            with contextlib.suppress(OSError):
                os.unlink(temporary)


@contextlib.contextmanager
def restored(paths: Iterable[Path]) -> Iterator[None]:
    """Put files back as they were, or as missing as they were, if the work raises."""
    before = {path: path.read_bytes() if path.is_file() else None for path in paths}
    try:
        yield
    except BaseException:
        for path, data in before.items():
            if data is None:
                path.unlink(missing_ok=True)
            else:
                with atomic(path, "wb") as file:
                    file.write(data)
        raise
