"""A draft of a column map, mended by what the channels say of each other."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np

from rcc_sim.analyse.logcheck.finding import Finding
from rcc_sim.analyse.logcheck.reading import check_reading
from rcc_sim.definitions.vehicle import Vehicle
from rcc_sim.errors import InputError
from rcc_sim.readers import parquet, plain_csv
from rcc_sim.readers.column_map import map_of
from rcc_sim.readers.log import Log
from rcc_sim.readers.suggest import SHORT, Draft, drafted
from rcc_sim.source import Source
from rcc_sim.trace import Trace

STEER = "steer_cmd_rad"

MENDED = ("unit", "sign", "time_unit")
"""Findings that a factor of their own channel mends."""

OFTEN = 3
"""Rows at full lock, plus or minus 1, by which a steering is a controller's command."""

SAID = re.compile(r"[-−+±]\s*1\b")
"""What a header says of a command, as in ``steering [-1..1]``."""


def checked_draft(
    source: Source, vehicle: Vehicle | None = None
) -> tuple[Draft, str | None]:
    """Return a column map by the header, with units and signs by the rows.

    Parameters
    ----------
    source : Source
        A CSV or Parquet file.
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
        log = _read(draft, source)
        by_name, draft = draft, _by_command(draft, log.trace, vehicle)
        log = log if draft is by_name else _read(draft, source)
        findings = check_reading(log, vehicle).findings
    except InputError as error:
        return draft, str(error)
    known = [f for f in findings if f.kind in MENDED and f.factor is not None]
    return _mended(draft, {f.channel: f for f in known}), None


def _read(draft: Draft, source: Source) -> Log:
    """Return the file as drafted."""
    read = parquet.read if parquet.sniff(source) else plain_csv.read
    return read(source, map_of(draft.toml(), Path("draft.toml")))


def _by_command(draft: Draft, trace: Trace, vehicle: Vehicle | None) -> Draft:
    """Return the draft with a steering that is a controller's command as no angle.

    It ends at plus or minus 1; or it stays within, and the vehicle is steered by such,
    or its header says so.
    """
    entry = next((e for e in draft.entries if e.column == STEER), None)
    if entry is None or entry.unit or STEER not in trace:
        return draft
    size = np.abs(trace[STEER][np.isfinite(trace[STEER])])
    most = size.max(initial=0.0)
    ends = most == 1.0 and (size == 1.0).sum() >= OFTEN
    control = vehicle.controller if vehicle else None
    by_command = control is not None and control.steering_command is not None
    is_angle = entry.name in (STEER, *SHORT) or "angle" in entry.name.lower()
    within = most <= 1.0 and (by_command or SAID.search(entry.name))
    if is_angle or not (ends or within):
        return draft
    why = (
        "a command, -1 to 1: controller.steering_command and steering_angle_rad of the "
        "vehicle file say which angle it is"
    )
    mine = entry._replace(column="steering", because=why)
    entries = tuple(mine if e is entry else e for e in draft.entries)
    return replace(draft, entries=entries)


def _mended(draft: Draft, found: Mapping[str, Finding]) -> Draft:
    """Return the draft with the factors found."""
    entries = []
    for entry in draft.entries:
        finding = found.get(entry.column)
        if finding is not None and finding.factor is not None:
            entry = entry.times(finding.factor, finding.what)
        entries.append(entry)
    return replace(draft, entries=tuple(entries))
