"""A report as one HTML file that needs nothing else: no network, no other file."""

from __future__ import annotations

import base64
import hashlib
import json
import re
from importlib import resources
from typing import IO

from rcc_sim.report import html_causes, html_energy, html_record
from rcc_sim.report.findings import Report
from rcc_sim.report.html_charts import drawn, drawn_apart, packed
from rcc_sim.report.html_parts import cards, section
from rcc_sim.report.panels import Charts, charts_of
from rcc_sim.report.signature import signature
from rcc_sim.report.text import Markup, escaped, figures, percent, tag
from rcc_sim.report.verdict import STATUS, verdict_of


def write_html(report: Report, file: IO[str]) -> None:
    """Write a report to an open text file (UTF-8)."""
    file.write(page(report))


def page(report: Report) -> str:
    """Return a report as one self-contained HTML page.

    All text that comes from files is escaped; the page's own script is the only one
    that a browser will run (by its hash), and the page may load nothing.
    """
    charts = charts_of(report)
    script, style = _file("report.js"), _file("report.css")
    digest = base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()
    policy = (
        f"default-src 'none'; script-src 'sha256-{digest}'; style-src 'unsafe-inline'; "
        "base-uri 'none'; form-action 'none'"
    )
    data = json.dumps(packed(charts), separators=(",", ":")) if charts else "{}"
    sections = _sections(report, charts)
    head = tag(
        "head",
        tag("meta", charset="utf-8"),
        tag("meta", name_="viewport", content="width=device-width, initial-scale=1"),
        tag("meta", http_equiv="Content-Security-Policy", content=policy),
        tag("title", report.title),
        tag("style", Markup(style)),
    )
    body = tag(
        "body",
        _header(report, sections),
        tag("main", *sections.values()),
        tag("footer", "Written by rccsim. This page is one file and loads nothing."),
        tag(
            "script",
            Markup(data.replace("<", "\\u003c")),
            type="application/json",
            id="data",
        ),
        tag("script", Markup(script)),
    )
    return f"<!doctype html>\n{tag('html', head, body, lang='en')}\n"


def _file(name: str) -> str:
    return resources.files("rcc_sim.report").joinpath(name).read_text(encoding="utf-8")


def _header(report: Report, sections: dict[str, Markup]) -> Markup:
    links = [
        tag("li", tag("a", name, href=f"#{key.partition(' ')[0]}"))
        for key, name in _NAMES.items()
        if sections.get(key)
    ]
    return tag(
        "header",
        tag(
            "div",
            tag("h1", report.title),
            tag("button", "Light / dark", id="theme", type="button", hidden=True),
            class_="top",
        ),
        _verdict(report.verdict or verdict_of(report.diagnosis)),
        cards(_figures(report)),
        tag("nav", tag("ul", *links), aria_label="Sections"),
    )


def _verdict(sentence: str) -> Markup:
    """Return a verdict, its first clause larger than what follows."""
    first, *more = re.split(r"(?<=;) (?![^(]*\))", sentence, maxsplit=1)
    rest = [tag("span", _unbroken(text)) for text in more]
    return tag("p", _unbroken(first), " " * bool(more), *rest, class_="verdict")


def _unbroken(text: str) -> Markup:
    """Return a sentence whose figures stay on one line with their units."""
    return Markup(re.sub(r"(?<=\d) (?=%|\w{1,2}\b)", "&nbsp;", escaped(text)))


_NAMES = {
    "totals": "Drives",
    "time": "Over time",
    "energy": "Energy",
    "driving": "Kinds of driving",
    "causes": "What it is",
    "signature": "Signature",
    "proof": "Proof",
    "next": "Next",
    "where": "Where",
    "check": "Log check",
    "vehicle": "Vehicle",
    "run": "What was run",
}


def _sections(report: Report, charts: Charts | None) -> dict[str, Markup]:
    compared = report.measured is not None
    title = "Measured against simulated" if compared else "The drives over time"
    title += f": {report.which}" if report.which else ""
    energy = html_energy.ledgers(report) or section(
        "energy", "Where the watt-hours went", html_energy.waterfall(report)
    )
    return {
        "totals": html_energy.totals(report),
        "time": section("time", title, drawn(charts) if charts else ""),
        "energy": energy,
        "driving": html_energy.driving(report),
        "causes": html_causes.causes(report),
        "signature": signature(
            report, drawn_apart(charts, "signature") if charts else Markup("")
        ),
        "proof": html_causes.held_out(report),
        "next": html_causes.next_experiment(report),
        "where": html_energy.where(report),
        "check": html_record.log_check(report),
        "vehicle": html_record.vehicle_diff(report),
        "run": html_record.record(report),
    }


def _figures(report: Report) -> list[tuple[str, str, str]]:
    diagnosis = report.diagnosis
    energy = diagnosis.get("where", {}).get("energy") or {}
    # where no cause stands, what shrank is what the file's sds allow
    shrink = (diagnosis.get("shrink") or {}) if diagnosis.get("causes") else {}
    found = []
    if diagnosis.get("status"):
        status = str(diagnosis["status"])
        found.append(("Status", STATUS.get(status, status), ""))
    for key, what in (("measured_wh", "Measured"), ("simulated_wh", "Simulated")):
        if energy.get(key) is not None:
            place = f"{energy.get('at') or 'battery'} energy"
            found.append((what, f"{figures(energy[key])} Wh", place))
    if energy.get("gap_wh") is not None:
        share = energy.get("gap_percent")
        word = "" if share is None else f"{figures(share)} % of the measured"
        found.append(("Gap", f"{figures(energy['gap_wh'])} Wh", word))
    if energy.get("u_val_wh") is not None:
        twice = 2.0 * float(energy["u_val_wh"])
        found.append(("Doubt", f"± {figures(twice, 2)} Wh", "twice u_val"))
    if shrink.get("energy_gap_percent_after") is not None:
        word = "held out" if shrink.get("held_out") else "not held out"
        if shrink.get("energy_by_measured_torque"):
            word += ", by the torque measured"
        after = f"{figures(shrink['energy_gap_percent_after'], 2)} %"
        found.append(("Energy gap once mended", after, word))
    if shrink.get("explained") is not None:
        low, high = shrink.get("low"), shrink.get("high")
        word = f"{percent(low)} to {percent(high)}" if None not in (low, high) else ""
        found.append(("Explained", percent(shrink["explained"]), word))
    for drive in report.energy[:4] if not energy else ():
        per_km = f"{figures(drive.wh_per_km, 4)} Wh/km"
        found.append((drive.name, per_km, f"{figures(drive.energy_wh, 4)} Wh"))
    return found
