"""The rows of a fleet as CSV."""

from __future__ import annotations

import csv
from collections.abc import Iterable, Mapping
from typing import IO, Any

from rcc_sim.batch.fleet_rows import UNREAD


def write_csv(rows: Iterable[Mapping[str, Any]], file: IO[str]) -> None:
    """Write rows as CSV: lists joined by semicolons, the pool's evidence left out."""
    writer = csv.writer(file, lineterminator="\n")
    head: list[str] = []
    for row in rows:
        if not head:
            head = [name for name in row if name not in UNREAD]
            writer.writerow(head)
        writer.writerow([_cell(row[name]) for name in head])
    file.flush()


def _cell(value: Any) -> Any:
    if value is None:
        return ""
    if isinstance(value, list):
        return ";".join(str(v) for v in value)
    if isinstance(value, bool):
        return str(value).lower()
    return f"{value:.9g}" if isinstance(value, float) else value
