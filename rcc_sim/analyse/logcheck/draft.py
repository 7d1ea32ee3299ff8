"""A draft of a column map, mended by what the channels say of each other."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

from rcc_sim.analyse.logcheck.finding import Finding
from rcc_sim.analyse.logcheck.reading import check_reading
from rcc_sim.definitions.vehicle import Vehicle
from rcc_sim.errors import InputError
from rcc_sim.readers import plain_csv
from rcc_sim.readers.column_map import map_of
from rcc_sim.readers.suggest import Draft, drafted
from rcc_sim.source import Source

MENDED = ("unit", "sign", "time_unit")
"""Findings that a factor of their own channel mends."""


def checked_draft(
    source: Source, vehicle: Vehicle | None = None
) -> tuple[Draft, str | None]:
    """Return a column map by the header, with units and signs by the rows.

    Parameters
    ----------
    source : Source
        A CSV file.
    vehicle : Vehicle or None
        Its file, by which motor speed, voltage and power are judged too.

    Returns
    -------
    draft : Draft
    unread : str or None
        Why the rows could not be judged, where they could not.

    Raises
    ------
    InputError
        If the file is no table.
    """
    draft = drafted(source)
    try:
        found = _findings(draft, source, vehicle)
    except InputError as error:
        return draft, str(error)
    return _mended(draft, found), None


def _findings(
    draft: Draft, source: Source, vehicle: Vehicle | None
) -> dict[str, Finding]:
    """Return what is wrong with the file as drafted, by column."""
    log = plain_csv.read(source, map_of(draft.toml(), Path("draft.toml")))
    findings = check_reading(log, vehicle).findings
    return {f.channel: f for f in findings if f.kind in MENDED and f.factor is not None}


def _mended(draft: Draft, found: Mapping[str, Finding]) -> Draft:
    """Return the draft with the factors found."""
    entries = []
    for entry in draft.entries:
        finding = found.get(entry.column)
        if finding is not None and finding.factor is not None:
            entry = entry.times(finding.factor, finding.what)
        entries.append(entry)
    return replace(draft, entries=tuple(entries))
