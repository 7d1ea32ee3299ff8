"""One row a log, over many logs: each command gives a function of one log.

A row function takes the log's name and the options that all logs share, and returns a
row as a dict of plain values. A log that cannot be read is a row with its error. What
a row lists under ``causes`` or ``findings`` is counted over the fleet: a small cause
that recurs says more than it does in one log.
"""

from __future__ import annotations

import hashlib
import json
import math
import os
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rcc_sim.batch.engine import version
from rcc_sim.batch.store import Manifest
from rcc_sim.errors import InputError, RccError

if TYPE_CHECKING:
    import pyarrow

Row = dict[str, Any]
RowOf = Callable[[str, Mapping[str, Any]], Row]

ODD = (
    *(ArithmeticError, AttributeError, LookupError, OSError),
    *(RuntimeError, TypeError, ValueError),
)
"""What a log that is like no other may raise; among many it is a row."""

MOST_PARTS = 2_000
"""Parts of a batch of logs; up to so many logs each is kept as it is done."""

ENERGIES = (
    "measured_wh",
    "simulated_wh",
    "gap_wh",
    "gap_percent",
    "u_val_wh",
    "within",
)
"""What a row of a gap holds of the energy."""

SUFFIXES = (".csv", ".csv.gz", ".parquet", ".mcap", ".bag", ".mf4", ".db3")
"""Files of a folder that are taken for logs."""


@dataclass(frozen=True, eq=False)
class Fleet:
    """A command over many logs.

    Parameters
    ----------
    command : str
        What it is called.
    row : callable
        A function of a module: of the log's name and the options, to its row.
    logs : tuple of str
        Paths.
    options : dict
        What all logs share, as plain values.
    """

    command: str
    row: RowOf
    logs: tuple[str, ...]
    options: Mapping[str, Any]

    @property
    def work(self) -> Any:
        """The function that does a part."""
        return rows_of_logs

    @property
    def setup(self) -> Any:
        """What every part shares."""
        return self.row, dict(self.options), os.getcwd()

    @cached_property
    def manifest(self) -> Manifest:
        """What the rows follow from: the logs as they are, command and options."""
        about = {
            "command": self.command,
            "version": list(version()),
            "options": {key: str(value) for key, value in self.options.items()},
        }
        files = [_stamp(log) for log in self.logs]
        words = json.dumps([about, files], sort_keys=True)
        digest = hashlib.blake2b(words.encode(), digest_size=16).hexdigest()
        part = max(math.ceil(len(self.logs) / MOST_PARTS), 1)
        return Manifest(digest, len(self.logs), part, about)

    def prepared(self, start: int, stop: int) -> tuple[Any, None]:
        """Return the logs of a part."""
        return self.logs[start:stop], None

    def table(self, start: int, kept: None, result: Any) -> pyarrow.Table:
        """Return the rows of a part; they need not have the same columns."""
        import pyarrow

        names = dict.fromkeys(name for row in result for name in row)
        return pyarrow.table(
            {name: pyarrow.array([row.get(name) for row in result]) for name in names}
        )


def rows_of_logs(
    setup: tuple[RowOf, Mapping[str, Any], str], logs: Sequence[str]
) -> Any:
    """Return the row of each log; one that fails is a row with its error."""
    row, options, folder = setup
    rows = []
    for log in logs:
        try:
            found = row(os.path.join(folder, log), options)
            found = {"log": log, **found, "error": None}
        except RccError as error:
            found = {"log": log, "error": str(error)}
        except (*ODD, MemoryError) as error:
            found = {"log": log, "error": f"{type(error).__name__}: {error}"}
        rows.append(found)
    return rows


def logs_of(names: Iterable[str]) -> tuple[str, ...]:
    """Return the logs that paths, folders and patterns name, sorted, each once.

    Raises
    ------
    InputError
        If a folder or a pattern holds none.
    """
    found: dict[str, None] = {}
    for name in names:
        path = Path(name).expanduser()
        if path.is_dir():
            here = [p for p in path.rglob("*") if p.name.lower().endswith(SUFFIXES)]
        elif any(mark in name for mark in "*?[") and not path.exists():
            root = Path(path.anchor) if path.is_absolute() else Path()
            here = list(root.glob(str(path.relative_to(path.anchor))))
        else:
            here = [path]
        if not here:
            raise InputError(f"{name}: no logs there", f"{', '.join(SUFFIXES)} are")
        found |= dict.fromkeys(sorted(str(p) for p in here))
    return tuple(found)


def check_row(log: str, options: Mapping[str, Any]) -> Row:
    """Return what `check` finds of a log: sound or not, and the findings by kind.

    Parameters
    ----------
    log : str
        Path.
    options : mapping
        ``vehicle``: name or path of a vehicle to judge by, or None.
    """
    from rcc_sim.analyse.logcheck import check_reading, report
    from rcc_sim.definitions.vehicle import load_vehicle
    from rcc_sim.readers import read_log

    name = options.get("vehicle")
    checked = check_reading(read_log(log), load_vehicle(name) if name else None)
    whole = report.document([checked])
    return {
        **{key: whole[key] for key in ("sound", "rows", "rate_hz", "duration_s")},
        **{f"{severity}s": n for severity, n in whole["counts"].items()},
        "findings": [
            f"{f.kind}:{f.channel}" for f in checked.findings if f.severity != "info"
        ],
    }


def gap_row(log: str, options: Mapping[str, Any]) -> Row:
    """Return where a log and the model part: energies, the gap, and its places.

    Parameters
    ----------
    log : str
        Path.
    options : mapping
        ``vehicle``: the model. ``hide``: columns to leave out.
    """
    from rcc_sim.analyse.gap import gap
    from rcc_sim.analyse.gap_report import document
    from rcc_sim.analyse.logged import open_log
    from rcc_sim.definitions.vehicle import load_vehicle

    car = load_vehicle(options["vehicle"])
    logged = open_log(log, car, hide=options.get("hide") or ())
    whole = document(gap(logged, car))
    energy = whole["energy"]
    beyond = [c["channel"] for c in whole["channels"] if (c["ratio"] or 0) > 1]
    return {
        "vehicle": whole["vehicle"],
        "mode": whole["mode"],
        **{key: energy[key] for key in ENERGIES},
        "beyond": beyond,
    }


def recurring(rows: Iterable[Row], key: str = "findings") -> list[Row]:
    """Return what the logs have in common: each finding, in how many, which first.

    Parameters
    ----------
    rows : iterable of dict
        Rows of logs.
    key : str
        Column that lists what was found in a log.
    """
    logs = 0
    count: Counter[str] = Counter()
    first: dict[str, str] = {}
    for row in rows:
        if row.get("error") is not None:
            continue
        logs += 1
        for name in dict.fromkeys(row.get(key) or ()):
            count[name] += 1
            first.setdefault(name, row["log"])
    return [
        {key: name, "logs": n, "share": n / logs, "first": first[name]}
        for name, n in count.most_common()
    ]


def _stamp(log: str) -> list[Any]:
    try:
        about = Path(log).stat()
    except OSError:
        return [log, None, None]
    return [log, about.st_size, about.st_mtime_ns]
