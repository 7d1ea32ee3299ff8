"""What a command reads is never overwritten by what it writes.

Asked of every command before its work (:func:`guarded`), by what its options are
called: a new command has nothing to remember.
"""

from __future__ import annotations

import tempfile
from collections.abc import Collection, Iterable, Iterator, Mapping
from functools import wraps
from pathlib import Path
from typing import Any

from rcc_sim.errors import InputError

WRITES = (
    *("--output", "--plot", "--html"),
    *("--write-vehicle", "--profiles", "--next-run"),
)
"""Options whose value is a file to write; any other value may name one to read."""

TO_FOLDERS = ("sweep", "check", "gap", "diagnose")
"""Commands whose ``--output`` may be a folder, which takes the rows of a batch."""

ENDINGS = {
    "--html": (".html", ".htm"),
    "--write-vehicle": (".toml",),
    "--profiles": (".csv",),
    "--next-run": (".csv", ".mcap"),
}
"""How the name of what an option writes ends; of others their writers tell."""


def guarded(command: Any) -> None:
    """Let a command, and each under it, ask :func:`keep` of its values before its work.

    Parameters
    ----------
    command : click.Command
        Its callback is replaced.
    """
    for under in getattr(command, "commands", {}).values():
        guarded(under)
    work = command.callback
    options = {p.name: o for p in command.params for o in p.opts if o in WRITES}
    if work is None or not options:
        return
    folders = ("--output",) if command.name in TO_FOLDERS else ()

    @wraps(work)
    def checked(**values: Any) -> Any:
        written = {option: values[name] for name, option in options.items()}
        read = (v for name, v in values.items() if name not in options)
        files = {option: path and Path(path) for option, path in written.items()}
        keep(_names(read), files, folders)
        return work(**values)

    command.callback = checked


def _names(values: Iterable[Any]) -> Iterator[str]:
    """Give every word that may name a file, as that after ``effect.column=``."""
    for value in values:
        if isinstance(value, list | tuple):
            yield from _names(value)
        elif isinstance(value, str | Path):
            yield str(value)
            yield str(value).rpartition("=")[2]


def keep(
    read: Iterable[str | None],
    written: Mapping[str, Path | None],
    folders: Collection[str] = (),
) -> None:
    """Raise if a file that is read would be overwritten, or none can be written.

    Or if its name promises another kind of file than it will hold.

    Parameters
    ----------
    read : iterable of str or None
        Logs and vehicle, if it was given; a name that is no file counts for nothing.
    written : mapping
        Option -> the file that it writes, if it was given.
    folders : collection of str
        Options that may name a folder as well.

    Raises
    ------
    InputError
        Naming option and file.
    """
    known = [Path(name) for name in read if name and Path(name).is_file()]
    taken: dict[Path, str] = {}
    for option, path in written.items():
        if path is None:
            continue
        other = taken.setdefault(path.resolve(), option)
        if other != option and (path.is_file() or not path.exists()):
            raise InputError(
                f"{option}: {path}: {other} writes there too", "give another name"
            )
        if path.is_file() and any(map(path.samefile, known)):
            raise InputError(
                f"{option}: {path}: is read here, and would be lost",
                "give another name",
            )
        if path.is_dir() and option not in folders:
            raise InputError(f"{option}: {path}: is a folder", "name a file in it")
        ends = ENDINGS.get(option, ())
        if ends and path.suffix.lower() not in ends:
            raise InputError(f"{option}: {path}: should end in {' or '.join(ends)}")
        if not path.exists():
            _refuse_unwritable(option, path, path.parent)


def _refuse_unwritable(option: str, path: Path, folder: Path) -> None:
    """Raise if a folder takes no file, asked in the one sure way: by writing one."""
    what, hint = f"{folder} is a file, not a folder", "name another folder"
    if folder.is_dir():
        try:
            tempfile.TemporaryFile(dir=folder).close()
        except OSError:
            what, hint = f"the folder {folder} cannot be written to", "name another"
        else:
            return
    elif not folder.exists():
        what, hint = f"there is no folder {folder}", "make it first"
    raise InputError(f"{option}: {path}: {what}", hint)
