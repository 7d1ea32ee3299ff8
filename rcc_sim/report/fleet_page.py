"""A fleet as one HTML page: what the logs come to, and a row a log; no script."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from importlib import resources
from itertools import islice
from typing import Any

from rcc_sim.report.fleet_tables import STATUS, Doc, lines, place_of, tables
from rcc_sim.report.html_parts import Column, cards, section, table
from rcc_sim.report.provenance import run_record
from rcc_sim.report.text import Markup, figures, probable, tag

MOST_ROWS = 2_000
"""Logs that a page lists; the dataset holds them all."""

POLICY = (
    "default-src 'none'; style-src 'unsafe-inline'; base-uri 'none'; form-action 'none'"
)

NAMES = {"check": "Check", "gap": "Gap", "diagnose": "Diagnosis"}

LOGS = (
    Column("Log", "log"),
    Column("Vehicle", "vehicle"),
    Column("Date", "date"),
    Column("Status", "status"),
    Column("Sound", "sound"),
    Column("Measured Wh", "measured_wh", number=True),
    Column("Gap %", "gap_percent", number=True),
    Column("First cause", "cause"),
    Column("Probability", "probability", number=True),
    Column("Figure", "figure"),
    Column("Findings", "findings"),
    Column("Error", "error"),
)


def fleet_page(
    found: Doc, rows: Iterable[Mapping[str, Any]], inputs: Sequence[str] = ()
) -> str:
    """Return the page; all text that comes from files is escaped.

    Parameters
    ----------
    found : mapping
        What `rcc_sim.batch.fleet_summary.summary` returns.
    rows : iterable of mapping
        The rows of the logs.
    inputs : sequence of str
        Files of which the page gives the hash.
    """
    style = resources.files("rcc_sim.report").joinpath("report.css").read_text("utf-8")
    title = f"{NAMES[found['command']]} of {found['logs']:,} logs"
    head = tag(
        "head",
        tag("meta", charset="utf-8"),
        tag("meta", name_="viewport", content="width=device-width, initial-scale=1"),
        tag("meta", http_equiv="Content-Security-Policy", content=POLICY),
        tag("title", title),
        tag("style", Markup(style)),
    )
    *others, verdict = lines(found)
    told = [tag("p", verdict, class_="verdict"), *(tag("p", line) for line in others)]
    top = tag("header", tag("h1", title), *told, cards(list(_cards(found))))
    sections = [
        section(f"part{k}", name, _table(part))
        for k, (name, part) in enumerate(tables(found))
    ]
    body = tag(
        "body",
        top,
        tag("main", *sections, _logs(found, rows), _record(inputs)),
        tag("footer", "Written by rccsim. This page is one file and loads nothing."),
    )
    return f"<!doctype html>\n{tag('html', head, body, lang='en')}\n"


def _cards(found: Doc) -> Iterator[tuple[str, str, str]]:
    yield "Logs", f"{found['logs']:,}", f"{found['failed']:,} failed"
    if "sound" in found:
        yield "Sound", f"{found['sound']:,}", "nothing worse than a note"
    energy = found.get("energy") or {}
    if energy.get("logs"):
        share = f"{figures(energy['gap_percent'])} % of what was measured"
        share += place_of(energy)
        yield "Gap", f"{figures(energy['gap_wh'])} Wh", share
        yield "Within", f"{energy['within']:,}", "of noise and the file's sds"
    for status, count in (found.get("status") or {}).items():
        yield STATUS.get(status, status).capitalize(), f"{count:,}", "each on its own"


def _table(rows: Sequence[Mapping[str, Any]]) -> Markup:
    numbers = {k for row in rows for k, v in row.items() if isinstance(v, float | int)}
    columns = [Column(key, key, number=key in numbers) for key in rows[0]]
    shown = [
        {
            key: figures(value) if isinstance(value, float) else value
            for key, value in row.items()
        }
        for row in rows
    ]
    return table(columns, shown)


def _logs(found: Doc, rows: Iterable[Mapping[str, Any]]) -> Markup:
    listed = [_log(row) for row in islice(rows, MOST_ROWS)]
    rest = found["logs"] - len(listed)
    more = f"{rest:,} more logs are in the dataset." if rest > 0 else ""
    return section(
        "logs", "Every log", table(LOGS, listed), tag("p", more) if more else ""
    )


def _log(row: Mapping[str, Any]) -> dict[str, Any]:
    known = {k: v for k, v in row.items() if v is not None}
    shown = {k: known.get(k) for k in ("log", "vehicle", "date", "cause", "error")}
    status = known.get("status")
    shown["status"] = STATUS.get(status, status) if status else None
    if "sound" in known:
        shown["sound"] = "yes" if known["sound"] else "no"
    for key in ("measured_wh", "gap_percent"):
        shown[key] = figures(known[key]) if key in known else None
    if "probability" in known:
        shown["probability"] = probable(known["probability"])
    if "value" in known:
        ends = f"{figures(known.get('low'))} to {figures(known.get('high'))}"
        shown["figure"] = f"{known['parameter']} {figures(known['value'])} ({ends})"
    shown["findings"] = ", ".join(known.get("findings", []))
    return shown


def _record(inputs: Sequence[str]) -> Markup:
    run = run_record(inputs)
    versions = ", ".join(f"{name} {v}" for name, v in run["versions"].items())
    return section(
        "run",
        "What was run",
        tag("pre", run["command"], tabindex="0"),
        tag("p", versions),
    )
