"""A batch: parts that are not done yet are done, kept, and counted."""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

from rcc_sim.batch.engine import Engine
from rcc_sim.batch.store import Manifest, Store
from rcc_sim.processes import Work

if TYPE_CHECKING:
    import pyarrow


class Task(Protocol):
    """What a batch does: the parts of a sweep, or of a list of logs."""

    @property
    def manifest(self) -> Manifest:
        """What it is."""

    @property
    def work(self) -> Work:
        """The function that does a part, wherever: of setup and part."""

    @property
    def setup(self) -> Any:
        """What every part shares."""

    def prepared(self, start: int, stop: int) -> tuple[Any, Any]:
        """Return the part of some rows, and what is to be kept of it here."""

    def table(self, start: int, kept: Any, result: Any) -> pyarrow.Table:
        """Return the rows of a part."""


@dataclass
class Progress:
    """How far a batch is.

    Parameters
    ----------
    total : int
        Rows in all.
    before : int
        Rows that were there when it began.
    done : int
        Rows that are there.
    failures : Counter
        What went wrong -> how often.
    first, log : dict
        What went wrong -> the first row with it, and the log that it is of, if any.
    began : float
        When it began, on the clock that only goes forward. [s]
    """

    total: int
    before: int = 0
    done: int = 0
    failures: Counter[str] = field(default_factory=Counter)
    first: dict[str, int] = field(default_factory=dict)
    log: dict[str, str] = field(default_factory=dict)
    began: float = field(default_factory=time.monotonic)

    @property
    def rate(self) -> float:
        """Rows per second since it began."""
        return (self.done - self.before) / max(time.monotonic() - self.began, 1e-9)

    @property
    def left_s(self) -> float:
        """Time that the rest will take at this rate. [s]"""
        return (self.total - self.done) / max(self.rate, 1e-9)

    @property
    def failed(self) -> int:
        """Rows that hold an error."""
        return self.failures.total()

    def count(self, start: int, table: pyarrow.Table) -> None:
        """Count the rows of a part, and its errors."""
        self.done += len(table)
        errors = table["error"]
        if errors.null_count == len(errors):
            return
        named = "log" in table.column_names
        logs = table["log"].to_pylist() if named else [""] * len(errors)
        for i, (error, log) in enumerate(zip(errors.to_pylist(), logs, strict=True)):
            if error is not None:
                what = kind_of(error, log)
                self.failures[what] += 1
                if start + i < self.first.get(what, self.total):
                    self.first[what], self.log[what] = start + i, log


def kind_of(error: str, log: str) -> str:
    """Return what went wrong with a log without its name: many may fail alike."""
    return error.removeprefix(f"{log}: ")


def run_batch(
    task: Task,
    output: Path,
    engine: Engine | None = None,
    tell: Callable[[Progress], None] | None = None,
) -> Progress:
    """Do what is not done yet of a batch; kill it, and the same call goes on.

    Parameters
    ----------
    task : Task
        What is to be done.
    output : Path
        A folder for a dataset of Parquet files, or a ``.parquet`` file.
    engine : Engine or None
        Where; in this process if not given.
    tell : callable or None
        Called after each part.

    Raises
    ------
    InputError
        If the place holds something else, or the engine cannot be reached.
    """
    store = Store(output, task.manifest)
    engine = engine or Engine()
    progress = Progress(task.manifest.rows)
    with store.opened():
        done = store.done()
        ranges = [task.manifest.range(k) for k in done]
        progress.before = progress.done = sum(stop - start for start, stop in ranges)
        if len(done) < task.manifest.parts:
            with engine.ready(task.work, task.setup) as give:
                _do_rest(task, store, done, give, progress, tell)
        store.finish()
        if done:
            progress = _counted(store, progress)
    return progress


def rows_of(task: Task, engine: Engine | None = None) -> Iterator[pyarrow.Table]:
    """Give the rows of a batch, in order, and keep nothing on the disk."""
    kept: dict[int, Any] = {}
    ready: dict[int, pyarrow.Table] = {}
    following = 0
    with (engine or Engine()).ready(task.work, task.setup) as give:
        parts = _parts(task, range(task.manifest.parts), kept)
        for k, result in give(parts):
            ready[k] = task.table(task.manifest.range(k)[0], kept.pop(k), result)
            while following in ready:
                yield ready.pop(following)
                following += 1


def _do_rest(
    task: Task,
    store: Store,
    done: set[int],
    give: Callable[[Any], Iterator[tuple[int, Any]]],
    progress: Progress,
    tell: Callable[[Progress], None] | None,
) -> None:
    kept: dict[int, Any] = {}
    rest = [k for k in range(task.manifest.parts) if k not in done]
    for k, result in give(_parts(task, rest, kept)):
        start, _ = task.manifest.range(k)
        table = task.table(start, kept.pop(k), result)
        store.write(k, table)
        progress.count(start, table)
        if tell is not None:
            tell(progress)


def _parts(task: Task, which: Any, kept: dict[int, Any]) -> Iterator[tuple[int, Any]]:
    for k in which:
        part, kept[k] = task.prepared(*task.manifest.range(k))
        yield k, part


def _counted(store: Store, progress: Progress) -> Progress:
    """Count the errors of every row that is there, of earlier runs too."""
    whole = Progress(progress.total, progress.before, began=progress.began)
    start = 0
    for table in store.tables(store.named("error", "log")):
        whole.count(start, table)
        start += len(table)
    return whole
