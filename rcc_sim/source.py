"""What is to be read: a file, a folder or a pipe, and its first block."""

from __future__ import annotations

import contextlib
import gzip
import io
import sys
import tempfile
import zlib
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import IO, Any, cast

from rcc_sim.errors import InputError

BLOCK = 1 << 16
"""Bytes of the start that a reader may judge a file by."""

FREE = 1 << 26
"""Bytes that gzip may unpack to, whatever the ratio."""

RATIO = 250
"""Most that a log shrinks by gzip; above `FREE`, more than this is a bomb."""

MAX_ROWS = 50_000_000
"""Most rows of a log: 10 h at 1 kHz is 36 million."""

GZIP = b"\x1f\x8b"


@dataclass(frozen=True)
class Source:
    """A file, folder or pipe to read from.

    Parameters
    ----------
    name : str
        What errors call it.
    path : Path or None
        The file or folder; None for a pipe.
    data : bytes
        What came through the pipe.
    head : bytes
        The first block, unpacked; empty for a folder.
    packed : bool
        Whether it is gzip.
    """

    name: str
    path: Path | None
    data: bytes
    head: bytes
    packed: bool

    @contextlib.contextmanager
    def stream(self) -> Iterator[IO[bytes]]:
        """Open it for reading, unpacked.

        Raises
        ------
        InputError
            While reading, if it is a broken or a hugely expanding gzip file.
        """
        with self._raw() as raw:
            yield cast("IO[bytes]", _Unpacked(raw, self.name)) if self.packed else raw

    @contextlib.contextmanager
    def arrow_file(self) -> Iterator[Any]:
        """Open it for Arrow, whose threads must not meet an exception.

        Raises
        ------
        InputError
            On leaving, what `stream` would have raised while reading.
        """
        import pyarrow

        with self.stream() as stream:
            calm = _Calm(stream)
            try:
                yield pyarrow.PythonFile(calm, mode="r")
            finally:
                if calm.error is not None:
                    raise calm.error from None

    @contextlib.contextmanager
    def unpacked_path(self, suffix: str) -> Iterator[Path]:
        """Path of an unpacked file, for libraries that want one."""
        if self.path is not None and not self.packed and self.path.suffix == suffix:
            yield self.path
            return
        if self.path is not None and self.path.is_dir():
            yield self.path
            return
        with tempfile.TemporaryDirectory(prefix="rccsim-") as folder:
            path = Path(folder, f"log{suffix}")
            if self.path is not None and not self.packed:  # a name that they know
                path.symlink_to(self.path.resolve())
            else:
                with self.stream() as stream, path.open("wb") as file:
                    while block := stream.read(1 << 20):
                        file.write(block)
            yield path

    @contextlib.contextmanager
    def _raw(self) -> Iterator[IO[bytes]]:
        if self.path is None:
            yield io.BytesIO(self.data)
            return
        try:
            file = self.path.open("rb")
        except OSError as error:
            raise unreadable(self.name, error) from None
        with file:
            yield file


class _Calm(io.RawIOBase):
    """A stream that ends where it fails, and keeps the error."""

    def __init__(self, file: IO[bytes]) -> None:
        self.file = file
        self.error: InputError | None = None

    def readable(self) -> bool:
        return True

    def read(self, size: int = -1) -> bytes:
        if self.error is None:
            try:
                return self.file.read(size)
            except InputError as error:
                self.error = error
        return b""


class _Unpacked(io.RawIOBase):
    """A gzip stream that raises our errors, and stops a bomb."""

    def __init__(self, raw: IO[bytes], name: str) -> None:
        self.raw, self.name, self.size = raw, name, 0
        self.file = gzip.GzipFile(fileobj=raw)

    def readable(self) -> bool:
        return True

    def read(self, size: int = -1) -> bytes:
        if size is None or size < 0:
            return self.readall()
        try:
            block = self.file.read(size)
        except EOFError:
            raise InputError(
                f"{self.name}: the gzip file is cut short after {self.raw.tell()} "
                "bytes",
                "copy it again, or unpack what there is: `zcat FILE > PART`; its last "
                "row will be cut",
            ) from None
        except (OSError, zlib.error) as error:
            raise InputError(f"{self.name}: a broken gzip file: {error}") from None
        self.size += len(block)
        if self.size > FREE and self.size > RATIO * max(self.raw.tell(), 1):
            raise InputError(
                f"{self.name}: the gzip file unpacks to more than {RATIO} times its "
                f"size ({self.size >> 20} MB so far): not a log",
                "if it is one, unpack it first",
            )
        return block

    def readall(self) -> bytes:
        return b"".join(iter(lambda: self.read(1 << 20), b""))


def open_source(path: str | Path, stdin: IO[bytes] | None = None) -> Source:
    """Look at what is to be read: its first block, and whether it is packed.

    Raises
    ------
    InputError
        If there is nothing there, it cannot be read, or it is empty.
    """
    name = "stdin" if str(path) == "-" else str(path)
    place = None if name == "stdin" else Path(path).expanduser()
    if place is not None and place.is_dir():
        return Source(name, place, data=b"", head=b"", packed=False)
    try:
        piped = place is None or (place.exists() and not place.is_file())
        data = _whole(place, stdin, name) if piped else b""
        place = None if piped else place
        start = data[:2] if place is None else _start(place)
    except OSError as error:
        raise unreadable(name, error) from None
    bare = Source(name, place, data=data, head=b"", packed=start == GZIP)
    with bare.stream() as stream:
        head = stream.read(BLOCK)
    if not head.strip():
        hint = "the command before the pipe wrote nothing" if piped else ""
        raise InputError(f"{name}: the file is empty", hint)
    if not head.strip(b"\0"):
        raise InputError(f"{name}: begins with nothing but zeros: not a log")
    return Source(name, place, data=data, head=head, packed=start == GZIP)


def unreadable(name: str, error: OSError) -> InputError:
    """Return the error for a file that the system does not give."""
    return InputError(f"{name}: cannot be read: {error.strerror or error}")


def _whole(place: Path | None, stdin: IO[bytes] | None, name: str) -> bytes:
    """All that comes through a pipe, or a device that reads like one."""
    if place is None:
        return _drained(stdin or sys.stdin.buffer, name)
    with place.open("rb") as file:
        return _drained(file, name)


def _drained(file: IO[bytes], name: str) -> bytes:
    first = file.read(BLOCK)
    if first and not first.strip(b"\0"):
        raise InputError(f"{name}: begins with nothing but zeros: not a log")
    return first + file.read()


def _start(path: Path) -> bytes:
    with path.open("rb") as file:
        return file.read(2)
