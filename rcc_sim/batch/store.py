"""Where the rows of a batch are kept: part by part, each whole or not there.

A part is a range of runs and holds the same bytes whoever does it. It is written beside
its place, brought to the disk, and then given its name, so that a kill at any moment
leaves the parts that are done and nothing else. What is to be done stands in a
manifest; another plan in the same place is an error.
"""

from __future__ import annotations

import contextlib
import json
import os
import shutil
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import IO, TYPE_CHECKING, Any

from rcc_sim.errors import InputError, not_written

if TYPE_CHECKING:
    import pyarrow

MANIFEST = "_rccsim.json"
"""What the folder holds; readers of datasets pass over names that begin so."""

LOCK = "_rccsim.lock"
KEY = b"rccsim"
TEMPORARY = ".tmp-"


@dataclass(frozen=True)
class Manifest:
    """What a batch is, as far as its rows depend on it.

    Parameters
    ----------
    digest : str
        Of everything that the rows follow from.
    rows, part : int
        Rows in all, and of each part but the last.
    about : dict
        The same in words: command, version, keys.
    """

    digest: str
    rows: int
    part: int
    about: dict[str, Any]

    @property
    def parts(self) -> int:
        """Number of parts."""
        return -(-self.rows // self.part)

    def range(self, k: int) -> tuple[int, int]:
        """Return the first row of part k, and the one after its last."""
        return k * self.part, min((k + 1) * self.part, self.rows)

    def text(self) -> bytes:
        """Return it as it stands in the folder and in each file."""
        whole = {"schema": "rccsim.batch/1", **self.__dict__}
        return (json.dumps(whole, indent=1, sort_keys=True) + "\n").encode()


@dataclass(frozen=True)
class Store:
    """The folder of a batch, or the file that it becomes.

    Parameters
    ----------
    output : Path
        A folder, or a ``.parquet`` file: its parts then lie in a folder beside it
        until all are done.
    manifest : Manifest
        What is to be in it.
    """

    output: Path
    manifest: Manifest

    @property
    def single(self) -> bool:
        """Whether the parts become one file."""
        return self.output.suffix == ".parquet"

    @property
    def folder(self) -> Path:
        """Where the parts lie."""
        if self.single:
            return self.output.with_name(f"{self.output.name}.parts")
        return self.output

    def path(self, k: int) -> Path:
        """Return where part k is or will be."""
        return self.folder / f"part-{k:06d}.parquet"

    @contextlib.contextmanager
    def opened(self) -> Iterator[None]:
        """Take the place for this batch, alone, until the end.

        Raises
        ------
        InputError
            If something else is there, or another process is at work on it.
        """
        with _explained(self.output):
            self._refuse_other()
            if self.is_finished():
                if self.folder.exists():
                    shutil.rmtree(self.folder)
                yield
                return
            fresh = not self.folder.exists()
            self.folder.mkdir(exist_ok=True)
        try:
            with self._alone():
                yield
        except BaseException:
            if fresh and not any(self.folder.glob("part-*")):
                shutil.rmtree(self.folder, ignore_errors=True)
            raise

    @contextlib.contextmanager
    def _alone(self) -> Iterator[None]:
        with _locked(self.folder / LOCK, self.output):
            with _explained(self.output):
                self._refuse_other()
                for path in self.folder.glob(f"{TEMPORARY}*"):
                    path.unlink()
                if not (self.folder / MANIFEST).exists():
                    text = self.manifest.text()
                    self._place(self.folder / MANIFEST, lambda f: f.write(text))
            yield

    def is_finished(self) -> bool:
        """Tell whether the one file is there, with these rows."""
        return self.single and _rows(self.output, self.manifest) == self.manifest.rows

    def _refuse_other(self) -> None:
        if self.single and self.output.exists() and not self.is_finished():
            raise self._other(self.output, _stated(self.output))
        if not self.folder.exists():
            return
        if not self.folder.is_dir():
            raise InputError(
                f"{self.folder}: is a file", "name a folder, or a file in .parquet"
            )
        path = self.folder / MANIFEST
        if not path.exists():
            names = {p.name for p in self.folder.iterdir()} - {LOCK}
            if any(not name.startswith(TEMPORARY) for name in names):
                raise InputError(
                    f"{self.folder}: holds other files", "name a new or an empty folder"
                )
            return
        if path.read_bytes() != self.manifest.text():
            raise self._other(self.folder, path.read_bytes())

    def _other(self, path: Path, there: bytes) -> InputError:
        return InputError(
            f"{path}: holds another plan: {_difference(there, self.manifest)}",
            "give the command that began it, or name another place",
        )

    def done(self) -> set[int]:
        """Return the parts that are there, whole; what is broken is taken away.

        A file that a power cut left without its end is done again.
        """
        if self.is_finished():
            return set(range(self.manifest.parts))
        found = set()
        for k in range(self.manifest.parts):
            start, stop = self.manifest.range(k)
            path = self.path(k)
            if path.exists():
                if _rows(path, self.manifest) == stop - start:
                    found.add(k)
                else:
                    path.unlink()
        return found

    def write(self, k: int, table: pyarrow.Table) -> None:
        """Write part k: whole, on the disk, and under its name only then.

        Raises
        ------
        InputError
            If the disk is full or the folder is gone.
        """
        with _explained(self.output):
            self._place(self.path(k), lambda file: _write(table, file, self.manifest))

    def finish(self) -> None:
        """Make the one file of the parts, where one was asked for."""
        if not self.single or self.is_finished():
            return
        import pyarrow
        import pyarrow.parquet as pq

        paths = [self.path(k) for k in range(self.manifest.parts)]
        schema = pyarrow.unify_schemas(
            [pq.read_schema(path).remove_metadata() for path in paths],
            promote_options="permissive",
        ).with_metadata({KEY: self.manifest.text()})

        def join(file: IO[bytes]) -> None:
            with pq.ParquetWriter(file, schema, write_page_checksum=True) as writer:
                for path in paths:
                    writer.write_table(_as(pq.read_table(path), schema))

        with _explained(self.output):
            self._place(self.output, join)
            shutil.rmtree(self.folder)

    def named(self, *columns: str) -> list[str]:
        """Return those of some columns that the rows have."""
        import pyarrow.parquet as pq

        place = self.output if self.is_finished() else self.path(0)
        there = pq.read_schema(place).names
        return [name for name in columns if name in there]

    def tables(self, columns: list[str] | None = None) -> Iterator[pyarrow.Table]:
        """Give the rows, part by part; all columns unless some are named."""
        import pyarrow.parquet as pq

        if self.is_finished():
            file = pq.ParquetFile(self.output)
            for k in range(file.num_row_groups):
                yield file.read_row_group(k, columns=columns)
        else:
            for k in range(self.manifest.parts):
                yield pq.read_table(self.path(k), columns=columns, partitioning=None)

    def _place(self, path: Path, write: Any) -> None:
        temporary = self.folder / f"{TEMPORARY}{os.getpid()}-{path.name}"
        try:
            with temporary.open("wb") as file:
                write(file)
                file.flush()
                os.fsync(file.fileno())
            os.replace(temporary, path)
        except BaseException:
            with contextlib.suppress(OSError):
                temporary.unlink()
            raise
        _sync_folder(path.parent)


def _write(table: pyarrow.Table, file: IO[bytes], manifest: Manifest) -> None:
    import pyarrow.parquet as pq

    marked = table.replace_schema_metadata({KEY: manifest.text()})
    pq.write_table(marked, file, write_page_checksum=True)


def _as(table: pyarrow.Table, schema: pyarrow.Schema) -> pyarrow.Table:
    """Return a table with the columns of a schema; those that it lacks are null."""
    import pyarrow

    columns = [
        table[field.name].cast(field.type)
        if field.name in table.column_names
        else pyarrow.nulls(len(table), field.type)
        for field in schema
    ]
    return pyarrow.table(columns, schema=schema)


def _rows(path: Path, manifest: Manifest) -> int | None:
    """Return the rows of a file of this batch; None if it is not one, or not whole."""
    if _stated(path) != manifest.text():
        return None
    import pyarrow.parquet as pq

    return int(pq.read_metadata(path).num_rows)


def _stated(path: Path) -> bytes:
    """Return the manifest that a file bears; nothing if it is not whole."""
    import pyarrow
    import pyarrow.parquet as pq

    try:
        return bytes((pq.read_metadata(path).metadata or {}).get(KEY, b""))
    except (OSError, pyarrow.ArrowInvalid):
        return b""


def is_rows(path: Path) -> bool:
    """Tell whether a file holds rows of a batch: its one file, a part, or its CSV."""
    if (path.parent / MANIFEST).is_file():
        return True
    if (path.with_name(f"{path.name}.parts") / MANIFEST).is_file():
        return True
    return path.suffix == ".parquet" and bool(_stated(path))


def _difference(text: bytes, manifest: Manifest) -> str:
    """Say in what a manifest differs from the one that is there."""
    try:
        there = json.loads(text)
        before = {**there.pop("about"), "rows": there["rows"]}
    except (ValueError, KeyError, TypeError):
        return "no rows of rccsim"
    after = {**manifest.about, "rows": manifest.rows}
    for key, old, new in _pairs(before, after):
        if old != new:
            return f"{key} {_short(old)}, now {_short(new)}"
    return "the same settings with other figures behind them"


def _pairs(before: Any, after: Any) -> Iterator[tuple[str, Any, Any]]:
    """Give each key with what both say of it, those of a table one by one."""
    for key in after:
        old, new = before.get(key), after[key]
        if isinstance(old, dict) and isinstance(new, dict):
            yield from _pairs(dict.fromkeys(new) | old, dict.fromkeys(old) | new)
        else:
            yield key, old, new


def _short(value: Any) -> str:
    text = "nothing" if value in (None, "", "None", "[]") else str(value)
    return text if len(text) <= 80 else text[:77] + "..."


@contextlib.contextmanager
def _locked(path: Path, output: Path) -> Iterator[None]:
    """Hold a lock that the system lets go of when this process ends, however it ends.

    Raises
    ------
    InputError
        If another process holds it.
    """
    if sys.platform == "win32":
        yield
        return
    import fcntl

    while True:
        with path.open("w") as file:
            try:
                fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except OSError:
                raise InputError(
                    f"{output}: another rccsim is at work on it",
                    "let it end, or end it",
                ) from None
            if not _is_there(file, path):
                continue  # the process before took it away as it was opened here
            try:
                yield
            finally:
                with contextlib.suppress(OSError):
                    path.unlink()
            return


def _is_there(file: IO[str], path: Path) -> bool:
    """Tell whether an open file is still the one of that name."""
    return path.exists() and os.path.samestat(os.fstat(file.fileno()), path.stat())


@contextlib.contextmanager
def _explained(output: Path) -> Iterator[None]:
    """Say what the system refused, in a line."""
    try:
        yield
    except OSError as error:
        more = "make room, and the same command goes on"
        raise not_written(output, error, more) from None


def _sync_folder(folder: Path) -> None:
    """Bring a new name to the disk too, where the system can."""
    with contextlib.suppress(OSError):
        number = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(number)
        finally:
            os.close(number)
