"""One row a log, over many logs: each command gives a function of one log.

A row function takes the log's path and the options that all logs share, and returns a
row as a dict of plain values. A log that cannot be read is a row with its error.
"""

from __future__ import annotations

import hashlib
import json
import math
import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rcc_sim.batch.engine import version
from rcc_sim.batch.fleet_logs import Entry
from rcc_sim.batch.store import Manifest, Store
from rcc_sim.errors import RccError

if TYPE_CHECKING:
    import pyarrow

Row = dict[str, Any]
RowOf = Callable[[str, Mapping[str, Any]], Row]

ODD = (
    *(ArithmeticError, AttributeError, LookupError, OSError),
    *(RuntimeError, TypeError, ValueError),
)
"""What a log that is like no other may raise; among many it is a row."""

MOST_PARTS = 10_000
"""Parts of a batch of logs; a part is kept as it is done."""

LEAST_PARTS = 64
"""Parts below which none holds more than a log: no process waits for another."""

TOGETHER = {"check": 10, "gap": 5}
"""Logs of a part where a log takes less time than to keep it."""

PLACE = {"log": "string", "folder": "string", "vehicle": "string"}
"""Columns that begin every row."""


@dataclass(frozen=True, eq=False)
class Fleet:
    """A command over many logs.

    Parameters
    ----------
    command : str
        What it is called.
    row : callable
        A function of a module: of the log's path and the options, to its row.
    logs : tuple of Entry
        Each with the model of its own, if any, and its labels.
    columns : dict
        Column of a row -> its Arrow type, in their order.
    options : dict
        What all logs share, as plain values; ``vehicle`` is the model.
    models : tuple of str
        Every model that the logs are held against.
    """

    command: str
    row: RowOf
    logs: tuple[Entry, ...]
    columns: Mapping[str, str]
    options: Mapping[str, Any] = field(default_factory=dict)
    models: tuple[str, ...] = ()

    @property
    def work(self) -> Any:
        """The function that does a part."""
        return rows_of_logs

    @property
    def setup(self) -> Any:
        """What every part shares."""
        return self.row, dict(self.options), os.getcwd()

    @cached_property
    def labels(self) -> dict[str, str]:
        """Label -> Arrow type, of all logs."""
        found: dict[str, str] = {}
        for entry in self.logs:
            for name, value in entry.labels.items():
                found[name] = "double" if isinstance(value, float) else "string"
        return found

    @cached_property
    def manifest(self) -> Manifest:
        """What the rows follow from: the logs as they are, command and options."""
        about = {
            "command": self.command,
            "version": list(version()),
            "options": {key: str(value) for key, value in self.options.items()},
        }
        files = [[e.log, e.vehicle, dict(e.labels), *_stamp(e.log)] for e in self.logs]
        models = [_stated(name) for name in self.models]
        read = _contents(Path(self.options.get("map") or ""))
        words = json.dumps([about, files, models, read], sort_keys=True, default=str)
        digest = hashlib.blake2b(words.encode(), digest_size=16).hexdigest()
        count = len(self.logs)
        part = min(max(count // LEAST_PARTS, 1), TOGETHER.get(self.command, 1))
        part = max(part, math.ceil(count / MOST_PARTS))
        return Manifest(digest, count, part, about)

    def prepared(self, start: int, stop: int) -> tuple[Any, None]:
        """Return the logs of a part."""
        return self.logs[start:stop], None

    def table(self, start: int, kept: None, result: Any) -> pyarrow.Table:
        """Return the rows of a part; every part has the same columns."""
        import pyarrow

        labels = self.labels
        kinds = {**PLACE, **labels, **self.columns, **labels, "error": "string"}
        return pyarrow.table(
            {
                name: pyarrow.array([row.get(name) for row in result], _type(kind))
                for name, kind in kinds.items()
            }
        )


def rows_of_logs(
    setup: tuple[RowOf, Mapping[str, Any], str], logs: Sequence[Entry]
) -> list[Row]:
    """Return the row of each log; one that fails is a row with its error."""
    row, options, folder = setup
    rows = []
    for entry in logs:
        mine = {**options, **({"vehicle": entry.vehicle} if entry.vehicle else {})}
        here = {
            "log": entry.log,
            "folder": str(Path(entry.log).parent),
            "vehicle": mine.get("vehicle"),
        }
        try:
            path = os.path.join(folder, os.path.expanduser(entry.log))
            found = {**here, **row(path, mine), **entry.labels, "error": None}
        except RccError as error:
            what = str(error).replace(os.path.join(folder, ""), "")
            found = {**here, **entry.labels, "error": what}
        except (*ODD, MemoryError) as error:
            what = f"{type(error).__name__}: {error}"
            found = {**here, **entry.labels, "error": what}
        rows.append(found)
    return rows


def rows_in(place: Path, manifest: Manifest) -> Iterator[Row]:
    """Give the rows of a dataset that is done, in the order of the logs."""
    for table in Store(place, manifest).tables():
        yield from table.to_pylist()


def _type(name: str) -> Any:
    import pyarrow

    if name.startswith("list "):
        return pyarrow.list_(_type(name.removeprefix("list ")))
    return pyarrow.type_for_alias(name)


def _stamp(log: str) -> list[Any]:
    try:
        about = Path(log).expanduser().stat()
    except OSError:
        return [None, None]
    return [about.st_size, about.st_mtime_ns]


def _stated(name: str) -> list[Any]:
    """Return all that a model's file and those that it extends state.

    With what stands in the files that these name: own effects, maps, roads.
    """
    from rcc_sim.definitions.vehicle import load_vehicle

    car = load_vehicle(name)
    own = [effect.digest for effect in car.own.values()]
    return [car.raw, own, *map(_contents, car.named_files)]


def _contents(path: Path) -> str | None:
    """Return a digest of a file; None where there is none of that name."""
    if not path.is_file():
        return None
    return hashlib.blake2b(path.read_bytes(), digest_size=16).hexdigest()
