"""The log's check, the mended vehicle, and what was run."""

from __future__ import annotations

from rcc_sim.report.channels import title_of
from rcc_sim.report.findings import Report
from rcc_sim.report.html_parts import Column, section, table
from rcc_sim.report.text import Markup, escaped, joined, tag

WORDS = {"info": "note", "warning": "warning", "error": "error"}


def log_check(report: Report) -> Markup:
    """Return what `check` found in the log."""
    if report.measured is None:
        return Markup("")
    rows = [
        {
            "channel": title_of(f.channel) if f.channel else "whole log",
            "weight": WORDS[f.severity],
            "what": f.what,
            "where": f.where,
            "sure": f"{100 * f.sure:.0f} %",
            "action": f.action,
        }
        for f in report.log_check
    ]
    columns = (
        Column("Channel", "channel"),
        Column("Weight", "weight"),
        Column("What", "what"),
        Column("Where", "where"),
        Column("Sure", "sure", number=True),
        Column("What rccsim does", "action"),
    )
    content = table(columns, rows) or tag("p", "Nothing found.")
    return section("check", "Is the log sound?", content)


def vehicle_diff(report: Report) -> Markup:
    """Return what changes in the vehicle file, as a diff of TOML."""
    if not report.vehicle_diff.strip():
        return Markup("")
    lines = []
    for line in report.vehicle_diff.splitlines():
        kind = {"+": "ins", "-": "del"}.get(line[:1])
        head = line.startswith(("+++", "---"))
        lines.append(tag(kind, line) if kind and not head else escaped(line))
    text = Markup("\n".join(lines))
    return section("vehicle", "The mended vehicle file", tag("pre", text, tabindex="0"))


def record(report: Report) -> Markup:
    """Return versions, inputs with hashes, seed and command line."""
    run = report.run
    if not run:
        return Markup("")
    command = run.get("command")
    versions = run.get("versions") or {}
    seed = run.get("seed")
    rows = [
        {
            "name": tag("code", str(entry.get("name", ""))),
            "hash": tag("code", entry["sha256"])
            if entry.get("sha256")
            else "not a file",
        }
        for entry in run.get("inputs") or []
    ]
    told = ", ".join(f"{name} {version}" for name, version in versions.items())
    known = {"command", "versions", "seed", "inputs"}
    more = [
        tag("p", f"{str(key).replace('_', ' ').capitalize()}: {value}")
        for key, value in run.items()
        if key not in known
    ]
    return section(
        "run",
        "What was run",
        tag("pre", command, tabindex="0") if command else "",
        table((Column("Input", "name"), Column("SHA-256", "hash")), rows),
        joined(*more),
        tag("p", f"Seed: {seed}") if seed is not None else "",
        tag("p", f"Versions: {told}", class_="note") if told else "",
    )
