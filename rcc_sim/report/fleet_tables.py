"""What a fleet came to, in lines and in tables for a screen or a page."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from rcc_sim.batch.fleet_rows import TEMPERATURE
from rcc_sim.diagnose.fleet.pooled import POOLED_ENOUGH
from rcc_sim.report.html_parts import effect_title
from rcc_sim.report.text import figures, listed, percent

Doc = Mapping[str, Any]
Table = list[dict[str, Any]]

TITLES = {TEMPERATURE: "temperature [°C]"}

SHOWN = 12
"""Kinds of finding that a screen shows."""

MANY = 20
"""Logs below which a tenth of them is none: the least and the most are told."""

NAMED = 3
"""Effects that the line of single logs names."""

STATUS = {
    "no_gap": "without a gap",
    "explained": "explained",
    "partly_explained": "partly explained",
    "unexplained": "unexplained",
}


def lines(found: Doc) -> list[str]:
    """Return the whole in some lines."""
    told = [f"{found['command']}: {_logs(found['logs'])}, {found['failed']} failed"]
    if "sound" in found:
        told.append(f"{found['sound']} sound")
    energy = found.get("energy") or {}
    if energy.get("logs"):
        most = "in 9 logs of 10 " * (energy["logs"] >= MANY)
        told.append(
            f"energy gap {figures(energy['gap_percent'])} % of "
            f"{figures(energy['measured_wh'], 4)} Wh measured{place_of(energy)}; "
            f"{most}from "
            f"{figures(energy['gap_percent_low'])} to "
            f"{figures(energy['gap_percent_high'])} %; "
            f"{energy['within']} within what noise and the file's sds explain"
        )
    if found.get("status"):
        counted = [f"{n} {STATUS.get(s, s)}" for s, n in found["status"].items()]
        named = [
            f"{e['effect']} named in {e['logs']}{_strength(e)}"
            for e in (found.get("effects") or [])[:NAMED]
        ]
        told.append("each on its own: " + ", ".join([*counted, *named]))
    if found.get("pooled"):
        told += pooled_lines(found["pooled"], found.get("effects") or [])
    return told


def place_of(energy: Doc) -> str:
    """Return where energy was measured, and how many logs know it elsewhere alone."""
    if not energy.get("at"):
        return ""
    rest = f" ({_logs(energy['elsewhere'])} elsewhere)" if energy["elsewhere"] else ""
    return f" at the {energy['at']}{rest}"


def pooled_lines(pooled: Doc, effects: list[Doc]) -> list[str]:
    """Return what the logs show together, beside what single ones name."""
    if strong := pooled.get("too_strong"):
        several = len(strong) > 1
        tied = {e["effect"]: e["indistinguishable_from"] for e in effects}
        each = [f"{name}{_or(tied.get(name, []))}" for name in strong]
        what = f"{listed(each)} {'are' if several else 'is'} too strong to be added up"
        told = [
            f"together, {_logs(pooled['logs'])}: {what}; the logs' own figures hold"
        ]
        return told + [_pooled_line(cause, pooled) for cause in pooled["causes"]]
    if not pooled["causes"]:
        best = next(iter(pooled["ranking"]), {"nats": POOLED_ENOUGH})
        most = ""
        if best["nats"] < POOLED_ENOUGH:  # else it is not what the logs have in common
            most = f" (the most: {best['effect']}, {figures(best['nats'])} nats)"
        return [f"together, {_logs(pooled['logs'])}: no cause{most}"]
    return [_pooled_line(cause, pooled) for cause in pooled["causes"]]


def _strength(effect: Doc) -> str:
    """Return the median strength of an effect in the logs that name it first."""
    if effect.get("parameter") is None or effect.get("median") is None:
        return ""
    return f" ({effect['parameter']} {figures(effect['median'])})"


def _or(tied: list[str]) -> str:
    """Return what logs cannot tell from an effect, in words."""
    return f" (or {', '.join(tied)}: these logs cannot tell)" if tied else ""


def _pooled_line(cause: Doc, pooled: Doc) -> str:
    same = _or(cause["indistinguishable_from"])
    scatter = (
        f", from log to log ± {figures(cause['spread'], 2)}" if cause["spread"] else ""
    )
    return (
        f"together, {_logs(pooled['logs'])}: {cause['effect']}{same}, "
        f"{cause['parameter']} {figures(cause['value'])} ({figures(cause['low'])} to "
        f"{figures(cause['high'])}{scatter}), {figures(cause['nats'])} nats; at most "
        f"{figures(cause['most_nats_in_a_log'])} in a single log, which named it "
        f"{cause['named_alone_in']} times"
    )


def tables(found: Doc) -> list[tuple[str, Table]]:
    """Return the tables of a fleet, each with its title."""
    parts = [
        ("What the logs show together", pooled_table(found.get("pooled") or {})),
        ("By car, together", cars_table(found.get("pooled") or {})),
        ("Causes of single logs", effects_table(found.get("effects") or [])),
        ("Channels beyond noise and tolerance", shares(found.get("beyond"), "beyond")),
        ("Findings", shares(found.get("findings"), "findings")),
        *(
            (f"By {TITLES.get(name, name)}", by_table(rows, name))
            for name, rows in found["by"].items()
        ),
        ("Failures", [dict(row) for row in found["failures"]]),
    ]
    return [(title, table) for title, table in parts if table]


def pooled_table(pooled: Doc) -> Table:
    """Return the causes that the logs show together."""
    return [
        {
            "effect": cause["effect"],
            "or": ", ".join(cause["indistinguishable_from"]),
            "parameter": cause["parameter"],
            "value": cause["value"],
            "low": cause["low"],
            "high": cause["high"],
            "scatter": cause["spread"],
            "nats": cause["nats"],
            "most in a log": cause["most_nats_in_a_log"],
            "logs": cause["logs"],
        }
        for cause in pooled.get("causes", [])
    ]


def cars_table(pooled: Doc) -> Table:
    """Return the same car by car."""
    return [
        {"effect": cause["effect"], **car}
        for cause in pooled.get("causes", [])
        for car in cause["cars"]
    ]


def effects_table(effects: list[Doc]) -> Table:
    """Return which effect how many logs name, and how strong."""
    return [
        {
            "effect": effect_title(row["effect"]),
            "or": ", ".join(row["indistinguishable_from"]),
            "logs": row["logs"],
            "share": percent(row["share"]),
            "parameter": row["parameter"] or "",
            "median": row["median"],
            "low": row["low"],
            "high": row["high"],
            "gap [%]": row["gap_percent_median"],
        }
        for row in effects
    ]


def shares(rows: list[Doc] | None, key: str) -> Table:
    """Return how many logs have each finding."""
    return [
        {
            "what": row[key],
            "logs": row["logs"],
            "share": percent(row["share"]),
            "first": row["first"],
        }
        for row in (rows or [])[:SHOWN]
    ]


def by_table(rows: list[Doc], name: str) -> Table:
    """Return the classes of a column."""
    words = {
        name: TITLES.get(name, name),
        "gap_percent": "gap [%]",
        "gap_percent_low": "low",
        "gap_percent_high": "high",
        "most_frequent_of_causes": "most frequent cause",
        "most_frequent_of_findings": "most frequent finding",
    }
    table = [{words.get(key, key): value for key, value in row.items()} for row in rows]
    for row in table:
        row["share"] = "" if row["share"] is None else percent(row["share"])
    return table


def _logs(count: int) -> str:
    return f"{count:,} log" if count == 1 else f"{count:,} logs"
