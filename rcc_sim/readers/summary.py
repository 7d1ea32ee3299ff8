"""A log column by column, and what there is to read logs with."""

from __future__ import annotations

from typing import Any

import numpy as np

from rcc_sim.readers.column_map import shipped_maps
from rcc_sim.readers.log import Log
from rcc_sim.readers.plugins import readers
from rcc_sim.units import unit_of


def summary(log: Log) -> list[dict[str, Any]]:
    """A row a column: unit, where it came from, range, values and blanks."""
    sources: dict[str, list[str]] = {}
    for found in log.mapped:
        sources.setdefault(found.column, []).append(found.source)
    rows = []
    for name, values in log.trace.columns.items():
        known = values[np.isfinite(values)]
        rows.append(
            {
                "column": name,
                "unit": unit_of(name),
                "from": " + ".join(sources.get(name, [])),
                "low": float(known.min()) if len(known) else None,
                "high": float(known.max()) if len(known) else None,
                "values": len(known),
                "blanks": len(values) - len(known),
            }
        )
    return rows


def known() -> list[dict[str, Any]]:
    """Every reader and every shipped column map: kind, name, what it is for."""
    found = [
        {"kind": "reader", "name": r.NAME, "what": r.SUMMARY, "source": ""}
        for r in readers()
    ]
    return found + [
        {"kind": "map", "name": m.name, "what": m.title, "source": m.origin}
        for m in shipped_maps()
    ]
