"""CSV in rccsim's own columns: the fast path."""

from __future__ import annotations

import numpy as np

from rcc_sim.errors import InputError
from rcc_sim.readers.build import Report, finished
from rcc_sim.readers.column_map import UNITS, ColumnMap
from rcc_sim.readers.csv_table import (
    TextTable,
    read_columns,
    text_table,
    written,
)
from rcc_sim.readers.log import Array, Flaw, Log, Mapped
from rcc_sim.readers.words import is_number
from rcc_sim.source import Source
from rcc_sim.units import SUFFIXES, unit_of

NAME = "rccsim"
SUMMARY = "CSV in rccsim's own columns (time_s and at least one channel)"

UNITLESS = ("throttle", "slope", "steering", "duty_cycle", "direction", "on_stand")
"""Own columns that carry no unit."""

NOT_OURS = "its name ends in no unit, as those of rccsim's columns do"
NONE_OURS = "beside the time it holds none of rccsim's columns"
MAPPED = (
    "compared with nothing; a --map says what a column is: `rccsim convert LOG "
    "--suggest-map` drafts one"
)

WRITTEN = {
    "kmh": "km/h",
    "kph": "km/h",
    "mph": "mph",
    "degps": "deg/s",
    "dps": "deg/s",
    "deg": "deg",
    "rpm": "rpm",
    "kw": "kW",
    "mv": "mV",
    "ma": "mA",
    "ms": "ms",
    "km": "km",
}
"""How a name may end in a unit that is not ours -> the unit."""


def sniff(source: Source) -> bool:
    """Whether the header has ``time_s``, or ``time_ms``."""
    table = text_table(source)
    return table is not None and not {"time_s", "time_ms"}.isdisjoint(table.names)


def read(source: Source, columns: ColumnMap | None = None) -> Log:
    """Read it; columns of words that are none of ours are dropped.

    Raises
    ------
    InputError
        As in `read_columns` and `finished`.
    """
    table = text_table(source)
    if table is None:
        raise InputError(f"{source.name}: not a CSV table")
    twice = next((n for n in table.names if n.endswith(" (2)")), "")
    if unit_of(twice.removesuffix(" (2)")) != "1":
        name = twice.removesuffix(" (2)")
        raise InputError(f"{source.name}: {name}: stands twice in the header")
    report = Report()
    wanted = [n for k, n in enumerate(table.names) if n and _is_ours(table, n, k)]
    report.dropped += [n for n in table.names if n and n not in wanted]
    read, flaws = read_columns(table, wanted)
    report.flaws += flaws
    report.notes += written(table)
    found: dict[str, Array] = {}
    for name in wanted:
        ours, factor = converted(name)
        if ours in table.names or ours in found:
            ours, factor = name, 1.0
        if not is_named_so(ours):
            report.flaws.append(Flaw("unknown", name, NOT_OURS, MAPPED))
        report.mapped.append(Mapped(ours, name, factor))
        found[ours] = factor * np.asarray(read[name], dtype=float)
    if not any(is_named_so(name) for name in found.keys() - {"time_s", "time_ms"}):
        report.flaws.append(Flaw("nothing_known", "", NONE_OURS, MAPPED, severe=True))
    return finished(source.name, found, NAME, report)


def converted(name: str) -> tuple[str, float]:
    """Return a name with our unit in place of another that it ends in, and the factor.

    >>> converted("speed_kmh")[0], converted("speed_mps")
    ('speed_mps', ('speed_mps', 1.0))
    """
    stem, _, end = name.rpartition("_")
    if not stem or end not in WRITTEN or (end == "ms" and stem != "time"):
        return name, 1.0  # speed_ms is no time
    factor, unit = UNITS[WRITTEN[end]]
    ours = next(suffix for suffix, written in SUFFIXES.items() if written == unit)
    return f"{stem}_{ours}", factor


def _is_ours(table: TextTable, name: str, place: int) -> bool:
    """Whether a column should be numbers: by its unit, its name or its first row."""
    if is_named_so(converted(name)[0]):
        return True
    return place >= len(table.first) or is_number(table.first[place], table.decimal)


def is_named_so(name: str) -> bool:
    """Whether a name is that of one of our columns: by its unit, or without one."""
    return unit_of(name) != "1" or name in UNITLESS
