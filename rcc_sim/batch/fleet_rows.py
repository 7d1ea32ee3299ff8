"""What each command says of one log of a fleet, as a row of plain values."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from datetime import UTC, datetime
from functools import lru_cache
from typing import TYPE_CHECKING, Any

import numpy as np

from rcc_sim.analyse.logged import COMPARED
from rcc_sim.readers.log import HELD

if TYPE_CHECKING:
    from rcc_sim.analyse.logcheck.finding import Finding
    from rcc_sim.analyse.logged import Logged
    from rcc_sim.definitions.vehicle import Vehicle
    from rcc_sim.diagnose.diagnosis import Diagnosis
    from rcc_sim.trace import Trace

Row = dict[str, Any]

TEMPERATURE = "ambient_temperature_degc"

CLOCK = (3e8, 1e10)
"""Stamps that are taken for Unix time: 1979 to 2286. [s]"""

CONTEXT = {
    "date": "string",
    TEMPERATURE: "double",
    "duration_s": "double",
    "constants": "string",
}
"""When, in what weather, how long, and what else was constant: JSON."""

FOUND = {"findings": "list string", "findings_count": "int64"}

CHECK = {
    **CONTEXT,
    "sound": "bool",
    "rows": "int64",
    "rate_hz": "double",
    "errors": "int64",
    "warnings": "int64",
    "infos": "int64",
    **FOUND,
}

ENERGIES = {
    "at": "string",
    "measured_wh": "double",
    "simulated_wh": "double",
    "gap_wh": "double",
    "gap_percent": "double",
    "u_val_wh": "double",
    "within": "bool",
}

GAP = {**CONTEXT, "mode": "string", **ENERGIES, "beyond": "list string", **FOUND}

DIAGNOSE = {
    **CONTEXT,
    "mode": "string",
    "status": "string",
    **ENERGIES,
    "cause": "string",
    "probability": "double",
    "nats": "double",
    "parameter": "string",
    "value": "double",
    "low": "double",
    "high": "double",
    "causes": "list string",
    "causes_json": "string",
    "explained": "double",
    "unexplained": "double",
    **FOUND,
    "pool_columns": "string",
    "pool": "list double",
}
"""Columns of a diagnosis: first cause with its first figure, all as JSON, evidence."""

UNREAD = ("pool", "pool_columns")
"""Columns that a table for people leaves out."""


def check_row(log: str, options: Mapping[str, Any]) -> Row:
    """Return what `check` finds of a log: sound or not, and the findings by kind.

    Parameters
    ----------
    log : str
        Path.
    options : mapping
        ``vehicle``: name or path of a vehicle to judge by, or None. ``reader``,
        ``map``: as `check` has them.
    """
    from rcc_sim.analyse.logcheck import check_reading, report
    from rcc_sim.readers import read_log

    name = options.get("vehicle")
    car = model(name) if name else None
    reading = read_log(log, reader=options.get("reader"), columns=options.get("map"))
    checked = check_reading(reading, car)
    whole = report.document([checked])
    return {
        **({"vehicle": car.name} if car else {}),
        **context(reading.trace, reading.start_s),
        **{key: whole[key] for key in ("sound", "rows", "rate_hz", "duration_s")},
        **{f"{severity}s": n for severity, n in whole["counts"].items()},
        **found(checked.findings),
    }


def gap_row(log: str, options: Mapping[str, Any]) -> Row:
    """Return where a log and the model part: energies, the gap, and its places.

    Parameters
    ----------
    log : str
        Path.
    options : mapping
        ``vehicle``: the model. ``hide``, ``reader``, ``map``: as `gap` has them.
    """
    from rcc_sim.analyse.gap import gap
    from rcc_sim.analyse.gap_report import energy_block

    car, logged = opened(log, options)
    gaps = gap(logged, car)
    energy = energy_block(gaps.energy)
    return {
        "vehicle": car.name,
        **context(logged.log, logged.reading.start_s),
        "mode": gaps.mode,
        **{key: energy[key] for key in ENERGIES},
        "beyond": [c.channel for c in gaps.channels if (c.ratio or 0) > 1],
        **found(gaps.findings),
    }


def diagnose_row(log: str, options: Mapping[str, Any]) -> Row:
    """Return what a diagnosis finds in a log, and its evidence for the pool.

    Parameters
    ----------
    log : str
        Path.
    options : mapping
        As of `gap`, and ``withhold`` and ``candidates``: effects.
    """
    from rcc_sim.diagnose.run import diagnose

    car, logged = opened(log, options)
    candidates = options.get("candidates") or ()
    withheld = options.get("withhold") or ()
    result = diagnose([logged], car, candidates=candidates, withheld=withheld)
    energy = result.document()["where"]["energy"]
    return {
        "vehicle": car.name,
        **context(logged.log, logged.reading.start_s),
        "mode": result.gap.mode,
        "status": result.status,
        **{key: energy[key] for key in ENERGIES},
        **causes(result),
        "explained": result.proof.shrink.explained,
        "unexplained": result.document()["unexplained"]["fraction"],
        **found(result.gap.findings),
        **evidence(result, candidates, withheld),
    }


def opened(log: str, options: Mapping[str, Any]) -> tuple[Vehicle, Logged]:
    """Return the model and the log, made ready."""
    from rcc_sim.analyse.logged import open_log

    car = model(options["vehicle"])
    if options.get("withhold"):
        car = car.changed(without=tuple(options["withhold"]))
    logged = open_log(
        log,
        car,
        reader=options.get("reader"),
        columns=options.get("map"),
        hide=options.get("hide") or (),
    )
    return car, logged


@lru_cache(maxsize=64)
def model(name: str) -> Vehicle:
    """Return a vehicle, read once in a process."""
    from rcc_sim.definitions.vehicle import load_vehicle

    return load_vehicle(name)


def context(trace: Trace, start_s: float = 0.0) -> Row:
    """Return when and in what weather a log was driven, where it tells.

    Parameters
    ----------
    trace : Trace
        The log.
    start_s : float
        What its stamps count from. [s since 1970]
    """
    time = trace["time_s"]
    known = time[np.isfinite(time)]
    row: Row = {"duration_s": float(known[-1] - known[0])}
    began = start_s + float(known[0])
    if CLOCK[0] < began < CLOCK[1]:
        row["date"] = datetime.fromtimestamp(began, UTC).date().isoformat()
    warm = trace.columns.get(TEMPERATURE)
    if warm is not None and np.isfinite(warm).any():
        row[TEMPERATURE] = float(np.nanmean(warm))
    apart = {"time_s", TEMPERATURE, *COMPARED, *HELD}
    same = {
        name: float(values[0])
        for name, values in trace.columns.items()
        if name not in apart and np.isfinite(values[0]) and np.all(values == values[0])
    }
    return row | ({"constants": json.dumps(same, sort_keys=True)} if same else {})


def found(findings: Sequence[Finding]) -> Row:
    """Return the kinds of findings that are worse than a note, and their number."""
    bad = [f"{f.kind}:{f.channel}" for f in findings if f.severity != "info"]
    return {"findings": bad, "findings_count": len(bad)}


def causes(result: Diagnosis) -> Row:
    """Return the causes of a diagnosis: the first in columns, all as JSON."""
    every = result.document()["causes"]
    row: Row = {
        "causes": [cause["effect"] for cause in every],
        "causes_json": json.dumps(every),
    }
    if every:
        first = every[0]
        row |= {
            "cause": first["effect"],
            "probability": first["probability"],
            "nats": first["nats"],
        }
        for name, figure in list(first["parameters"].items())[:1]:
            row |= {"parameter": name, **figure}
    return row


def evidence(result: Diagnosis, only: Sequence[str], withheld: Sequence[str]) -> Row:
    """Return what the log says of every candidate, to be added to that of others.

    As it was explained: thinned, on the road that was felt, its commands held or not.
    """
    from rcc_sim.diagnose.causes.candidates import candidates_for
    from rcc_sim.diagnose.fitting.engine import Engine
    from rcc_sim.diagnose.fleet.pool import evidence_of, packed

    problems = [result.problem]
    able = candidates_for(problems, only, withheld)
    form = evidence_of(Engine(problems), result.found.null, able)
    columns, numbers = packed(form)
    return {"pool_columns": columns, "pool": numbers}
