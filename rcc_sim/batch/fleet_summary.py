"""What the rows of a fleet come to: which effect, how often, how much, and where."""

from __future__ import annotations

import json
from collections import Counter, defaultdict
from collections.abc import Collection, Iterable, Mapping, Sequence
from itertools import chain, islice
from typing import Any

import numpy as np

from rcc_sim.analyse.gap_energy import percent_of
from rcc_sim.batch.batch import kind_of
from rcc_sim.batch.fleet_rows import TEMPERATURE
from rcc_sim.diagnose.fleet.pool import Evidence, unpacked
from rcc_sim.diagnose.fleet.pooled import Common, Explained, Pooled, pool

Row = Mapping[str, Any]
Ties = dict[str, list[str]]

SCHEMA = "rccsim.fleet/1"

DEGREES = 5.0
"""Width of a class of temperature. [°C]"""

MANY_DAYS = 31
"""Days above which dates are gathered by month."""

MOST_CLASSES = 50
"""Classes of one column that a summary lists, the largest first."""

MOST_KINDS = 20
"""Kinds of failure that a summary lists."""

BY = ("vehicle", TEMPERATURE, "date")
"""Columns by which logs are gathered where none is named."""

ENDS = (0.05, 0.95)

PLAIN = 0.8
"""Share of the logs that name a cause alone, from which on it is not a weak one."""


def summary(
    rows: Iterable[Row], command: str, *, by: Sequence[str] = (), car: str = ""
) -> dict[str, Any]:
    """Return what ``--json`` prints of a fleet.

    Parameters
    ----------
    rows : iterable of mapping
        In the order of the logs; gone through once.
    command : str
        check, gap or diagnose.
    by : sequence of str
        Columns by which logs are gathered; vehicle, temperature and date if none.
    car : str
        Column that names the car; a model is a car unless given.
    """
    good: list[Row] = []
    groups: defaultdict[str, list[Evidence]] = defaultdict(list)
    failures: Counter[str] = Counter()
    first: dict[str, str] = {}
    logs = 0
    for row in rows:
        logs += 1
        if row["error"] is not None:
            what = kind_of(row["error"], row["log"])
            failures[what] += 1
            first.setdefault(what, row["log"])
            continue
        if row.get("pool"):
            name = str(row.get(car or "vehicle"))
            groups[name].append(unpacked(row["pool_columns"], row["pool"]))
        good.append({k: v for k, v in row.items() if k not in ("pool", "pool_columns")})
    columns = [name for name in by or BY if by or _told(good, name)]
    return {
        "schema": SCHEMA,
        "command": command,
        "logs": logs,
        "failed": failures.total(),
        "failures": [
            {"error": error, "logs": n, "first": first[error]}
            for error, n in failures.most_common(MOST_KINDS)
        ],
        **_whole(good, command),
        "by": {name: _gathered(good, name, command) for name in columns},
        **({"pooled": pooled(groups, good)} if command == "diagnose" else {}),
    }


def _told(rows: Sequence[Row], name: str) -> bool:
    return any(row.get(name) is not None for row in rows)


def _whole(rows: Sequence[Row], command: str) -> dict[str, Any]:
    found: dict[str, Any] = {}
    if command == "check":
        found["sound"] = sum(bool(row["sound"]) for row in rows)
    else:
        found["energy"] = energy(rows)
    if command == "diagnose":
        found["status"] = dict(Counter(row["status"] for row in rows).most_common())
        found["effects"] = effects(rows)
    if command == "gap":
        found["beyond"] = recurring(rows, "beyond")
    found["findings"] = recurring(rows)
    return found


def energy(rows: Sequence[Row]) -> dict[str, Any]:
    """Return the energies of logs: their sums, and how the gap scatters.

    Those at the battery and those at the shaft are not one sum: it is of the place
    that most logs know, and how many know the other alone is told.
    """
    every = [row for row in rows if row.get("gap_wh") is not None]
    if not every:
        return {"logs": 0}
    places = Counter(row.get("at") for row in every)
    place = max(places, key=lambda at: (places[at], at == "battery"))
    known = [row for row in every if row.get("at") == place]
    measured = sum(row["measured_wh"] for row in known)
    simulated = sum(row["simulated_wh"] for row in known)
    percents = [r["gap_percent"] for r in known if r["gap_percent"] is not None]
    return {
        "logs": len(known),
        "at": place,
        "elsewhere": len(every) - len(known),
        "within": sum(bool(row["within"]) for row in known),
        "measured_wh": measured,
        "simulated_wh": simulated,
        "gap_wh": sum(row["gap_wh"] for row in known),
        "gap_percent": percent_of(measured, simulated),
        **_scatter("gap_percent", percents),
    }


def _scatter(name: str, values: Sequence[float]) -> dict[str, Any]:
    if not values:
        return {f"{name}_median": None, f"{name}_low": None, f"{name}_high": None}
    middle = np.median(values)
    # of few logs the least and the most: between two of them none lies
    low, high = np.quantile(values, ENDS, method="inverted_cdf")
    return {
        f"{name}_median": float(middle),
        f"{name}_low": float(low),
        f"{name}_high": float(high),
    }


def effects(rows: Sequence[Row]) -> list[dict[str, Any]]:
    """Return the causes that logs have on their own: how often, and how much."""
    counts, ties = recurring(rows, "causes"), ties_of(rows)
    for count in counts:
        count["effect"] = effect = count.pop("causes")
        count["indistinguishable_from"] = tied_with(ties, effect)
        leading = [row for row in rows if row.get("cause") == effect]
        count["first_cause_of"] = len(leading)
        values = [r["value"] for r in leading if r.get("value") is not None]
        count["parameter"] = next((r["parameter"] for r in leading), None)
        count |= {
            key.replace("value_", ""): x for key, x in _scatter("value", values).items()
        }
        gaps = [r["gap_percent"] for r in leading if r["gap_percent"] is not None]
        count["gap_percent_median"] = float(np.median(gaps)) if gaps else None
    return counts


def ties_of(rows: Iterable[Row]) -> list[Ties]:
    """Causes of each log, each with what the log cannot tell from it."""
    every = (json.loads(row.get("causes_json") or "[]") for row in rows)
    return [{c["effect"]: c["indistinguishable_from"] for c in one} for one in every]


def tied_with(ties: Sequence[Ties], effect: str) -> list[str]:
    """Return what most of the logs that name an effect cannot tell from it."""
    alike = [tied[effect] for tied in ties if effect in tied]
    count = Counter(name for some in alike for name in some)
    ranked = sorted(count.items(), key=lambda item: (-item[1], item[0]))
    return [name for name, n in ranked if n > len(alike) / 2]


def too_strong(rows: Sequence[Row], known: Collection[str]) -> list[str]:
    """Return what hardly a log fails to name, or to tie with what it names.

    Of effects that the logs cannot tell apart, the one that most of them name; none
    that is ``known`` already.
    """
    named = [row for row in rows if row.get("error") is None]
    ties = ties_of(named)
    count = Counter(e for t in ties for e in {*t, *chain(*t.values())})
    found: list[str] = []
    for one in recurring(named, "causes"):
        effect = one["causes"]
        alike = {effect, *tied_with(ties, effect)}
        if count[effect] >= PLAIN * len(named) and alike.isdisjoint({*known, *found}):
            found.append(effect)
    return found


def recurring(rows: Iterable[Row], key: str = "findings") -> list[dict[str, Any]]:
    """Return what the logs have in common: each finding, in how many, which first.

    Parameters
    ----------
    rows : iterable of mapping
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


def _gathered(rows: Sequence[Row], name: str, command: str) -> list[dict[str, Any]]:
    """Return what the logs of each class of a column come to."""
    label = _labels(rows, name)
    classes: defaultdict[str, list[Row]] = defaultdict(list)
    for row in rows:
        classes[label(row.get(name))].append(row)
    largest = sorted(classes, key=lambda c: -len(classes[c]))[:MOST_CLASSES]
    numeric = any(isinstance(row.get(name), float) for row in rows)
    found = []
    for one in sorted(largest, key=_number if numeric else str):
        mine = classes[one]
        line: dict[str, Any] = {name: one, "logs": len(mine)}
        if command == "check":
            line["sound"] = sum(bool(r["sound"]) for r in mine)
        else:
            told = energy(mine)
            keys = ("within", "gap_percent", "gap_percent_low", "gap_percent_high")
            line |= {key: told.get(key) for key in keys}
        key = "causes" if command == "diagnose" else "findings"
        often = next(islice(recurring(mine, key), 1), None)
        line[f"most_frequent_of_{key}"] = often and often[key]
        line["share"] = often and often["share"]
        found.append(line)
    return found


def _labels(rows: Sequence[Row], name: str) -> Any:
    """Return the function from a cell to its class."""
    values = {row.get(name) for row in rows} - {None}
    if name == TEMPERATURE:
        return lambda x: "–" if x is None else _degrees(x)
    if name == "date" and len(values) > MANY_DAYS:
        return lambda x: "–" if x is None else str(x)[:7]
    return lambda x: "–" if x is None else str(x)


def _degrees(x: float) -> str:
    low = DEGREES * np.floor(x / DEGREES)
    return f"{low:g} to {low + DEGREES:g}"


def _number(label: str) -> tuple[float, str]:
    try:
        return float(label.split(" ")[0]), label
    except ValueError:
        return float("inf"), label


def pooled(
    groups: Mapping[str, Sequence[Evidence]], rows: Sequence[Row]
) -> dict[str, Any]:
    """Return what the logs show together, each too weak alone or not.

    Parameters
    ----------
    groups : mapping
        Car -> evidence of its logs.
    rows : sequence of mapping
        Rows of the logs, for what each names by itself.
    """
    found: Explained = pool(groups)
    causes = [_cause(cause, rows) for cause in found.causes]
    known = {e for c in causes for e in (c["effect"], *c["indistinguishable_from"])}
    if causes and not causes[0]["named_alone_in"]:  # no log sees what would be clearest
        known = set()
    strong = too_strong(rows, known)
    if strong:  # about none these forms do not hold, and others make up for that
        kept = (cause for cause in causes if cause["named_alone_in"])
        causes = [cause for cause in kept if cause["effect"] not in strong]
    return {
        "logs": sum(len(logs) for logs in groups.values()),
        "cars": len(groups),
        "causes": causes,
        "too_strong": strong,
        "ranking": [
            {"effect": p.effect, "parameter": _last(p.key), "nats": p.nats}
            for p in sorted(found.ranking, key=lambda p: -p.nats)[:10]
        ],
    }


def _cause(cause: Common, rows: Sequence[Row]) -> dict[str, Any]:
    p = cause.found
    names = {p.effect, *cause.tied}
    named = sum(not names.isdisjoint(row.get("causes") or ()) for row in rows)
    return {
        "effect": p.effect,
        **_figures(p),
        **_plain(p, rows),
        "nats_common": p.nats_common,
        "most_nats_in_a_log": cause.largest,
        "spread": p.spread,
        "named_alone_in": named,
        "indistinguishable_from": list(cause.tied),
        "cars": [{"car": name, **_figures(q)} for name, q in cause.cars.items()],
    }


def _plain(p: Pooled, rows: Sequence[Row]) -> dict[str, Any]:
    """Return the figure of a cause that hardly a log fails to name: from their fits.

    What all logs say together holds for weak causes, to first order about none. The
    interval stays that of a single log: what the file does not know is the same in all.
    """
    same = [
        row
        for row in rows
        if row.get("cause") == p.effect and row["parameter"] == _last(p.key)
    ]
    if len(same) < PLAIN * p.logs:
        return {"from": "all logs, to first order"}
    value = float(np.median([row["value"] for row in same]))
    half = float(np.median([row["high"] - row["low"] for row in same])) / 2
    low, high = value - half, value + half
    return {"value": value, "low": low, "high": high, "from": "the logs that name it"}


def _figures(p: Pooled) -> dict[str, Any]:
    return {
        "parameter": _last(p.key),
        "value": p.value,
        "low": p.low,
        "high": p.high,
        "nats": p.nats,
        "logs": p.logs,
    }


def _last(key: str) -> str:
    return key.rpartition(".")[2]
