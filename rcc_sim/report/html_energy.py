"""Where the energy went, and where the gap sits."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from rcc_sim.analyse.energy import compared
from rcc_sim.report.channels import title_of
from rcc_sim.report.findings import Report
from rcc_sim.report.html_parts import (
    METERS,
    OR_TIE,
    OTHER_DRIVE,
    SHIFTS,
    SMALL,
    Column,
    bar,
    effect_title,
    section,
    table,
)
from rcc_sim.report.text import Markup, figures, percent, tag
from rcc_sim.units import unit_of

CLOSE = 0.5
"""Share of the longest bar at which the bars may begin, where all steps lie above."""


def waterfall(report: Report) -> Markup:
    """Return the steps from the simulated to the measured energy, unexplained last."""
    energy = report.diagnosis.get("where", {}).get("energy") or {}
    measured, simulated = energy.get("measured_wh"), energy.get("simulated_wh")
    if measured is None or simulated is None:
        return Markup("")
    some = SMALL * max(abs(measured), abs(simulated))
    every = cause_steps(report)
    rest = measured - simulated - sum(wh for _, wh in every)
    steps = [(name, wh) for name, wh in every if abs(wh) > some]
    word = "unexplained" if steps else "the gap"
    if steps or abs(rest) > some:
        steps.append((word, rest))
    at = simulated
    rows = [_step("simulated", simulated, 0.0, simulated, "b", total=True)]
    for name, wh in steps:
        kind = "open" if name == word else ("s2" if wh >= 0 else "s3")
        rows.append(_step(name, wh, at, at + wh, kind))
        at += wh
    rows.append(_step("measured", measured, 0.0, measured, "m", total=True))
    low, high = _axis([row["reach"][1] for row in rows])
    for row in rows:
        row["bar"] = bar(row["reach"], low, high, row["kind"])
        row["share"] = percent(row["wh"] / measured) if measured else ""
    columns = (
        Column("", "name"),
        Column("Energy [Wh]", "text", number=True),
        Column("Of the measured", "share", number=True),
        Column("", "bar"),
    )
    caption = "From the simulated energy to the measured, step by step."
    if low > 0:
        caption += f" The bars begin at {figures(low)} Wh, not at zero."
    return table(columns, rows, caption)


def _axis(ends: Sequence[float]) -> tuple[float, float]:
    """Return the bars' axis: from zero, unless the steps would be too small to see."""
    low, high = min(ends), max(ends)
    begin = low - (high - low)
    return (begin, high) if begin > CLOSE * high else (min(0.0, low), max(0.0, high))


def _step(
    name: str, wh: float, start: float, end: float, kind: str, total: bool = False
) -> dict[str, Any]:
    sign = "+" if wh > 0 and not total else ""
    return {
        "name": name,
        "wh": wh,
        "text": sign + figures(wh, 4),
        "reach": (start, end),
        "kind": kind,
        "total": total,
    }


def cause_steps(report: Report) -> Sequence[tuple[str, float]]:
    """Return what each cause adds to the simulated energy [Wh], by name."""
    prices = report.prices
    if prices is None:
        return []
    causes = report.diagnosis.get("causes") or []
    ties = {c["effect"] for c in causes if c.get("indistinguishable_from")}
    steps = [
        (effect_title(name) + OR_TIE * (name in ties), wh)
        for name, wh in prices.causes.items()
    ]
    steps.append((SHIFTS, prices.figures_wh))
    steps.append((METERS, prices.meters_wh))
    return [(OTHER_DRIVE, prices.drive_wh), *steps]


def where(report: Report) -> Markup:
    """Return where the gap sits: kind of driving, stage, channel, stretch."""
    found = report.diagnosis.get("where") or {}
    return section(
        "where",
        "Where the gap sits",
        _shares("By kind of driving", "regime", found.get("regimes") or []),
        _shares("By stage of the power chain", "stage", found.get("stages") or []),
        _channels(found.get("channels") or []),
        _windows(found.get("windows") or []),
    )


def _shares(title: str, key: str, rows: Sequence[Mapping[str, Any]]) -> Markup:
    if not rows:
        return Markup("")
    gaps = [float(row.get("gap_wh") or 0.0) for row in rows]
    low, high = min(0.0, *gaps), max(0.0, *gaps)
    told = [
        {
            "name": str(row.get(key, "")).replace("_", " "),
            "time": figures(row.get("time_s")) if "time_s" in row else "",
            "gap": figures(row.get("gap_wh")),
            "share": percent(row.get("share")),
            "bar": bar((0.0, gap), low, high, "b" if gap >= 0 else "a"),
        }
        for row, gap in zip(rows, gaps, strict=True)
    ]
    columns = (
        Column(key.capitalize(), "name"),
        Column("Time [s]", "time", number=True),
        Column("Gap [Wh]", "gap", number=True),
        Column("Share of all gaps' sizes", "share", number=True),
        Column("", "bar"),
    )
    return Markup(tag("h3", title) + table(columns, told))


def _channels(rows: Sequence[Mapping[str, Any]]) -> Markup:
    told = [
        {
            "name": title_of(str(row.get("channel", ""))),
            "unit": unit_of(str(row.get("channel", ""))),
            **{k: figures(row.get(k)) for k in ("rmse", "bias", "noise", "score")},
        }
        for row in rows
    ]
    columns = (
        Column("Channel", "name"),
        Column("Unit", "unit"),
        Column("Error, RMS", "rmse", number=True),
        Column("Mean error", "bias", number=True),
        Column("Noise", "noise", number=True),
        Column("ISO/TS 18571 score", "score", number=True),
    )
    caption = "Measured minus simulated; the score is 1 for curves that agree."
    return (
        Markup(tag("h3", "By channel") + table(columns, told, caption))
        if told
        else Markup("")
    )


def _windows(rows: Sequence[Mapping[str, Any]]) -> Markup:
    told = [
        {
            "when": f"{figures(w.get('start_s'), 5)} to {figures(w.get('end_s'), 5)}",
            "channel": title_of(str(w.get("channel", ""))),
            "share": percent(w.get("share")),
        }
        for w in rows
    ]
    columns = (
        Column("Stretch [s]", "when"),
        Column("Channel", "channel"),
        Column("Share of its error", "share", number=True),
    )
    return (
        Markup(tag("h3", "Flagged stretches") + table(columns, told))
        if told
        else Markup("")
    )


def ledgers(report: Report) -> Markup:
    """Return the ledgers of drives beside each other, by sink and in all."""
    drives = report.energy
    if not drives:
        return Markup("")
    sinks = dict.fromkeys(sink for drive in drives for sink in drive.ledger)
    sinks = dict.fromkeys(
        sorted(sinks, key=lambda s: -max(abs(d.ledger.get(s, 0.0)) for d in drives))
    )
    per_km = [1000.0 / d.distance_m if d.distance_m > 0 else 0.0 for d in drives]
    values = {
        s: [d.ledger.get(s, 0.0) * k for d, k in zip(drives, per_km, strict=True)]
        for s in sinks
    }
    low = min(0.0, *(v for row in values.values() for v in row)) if values else 0.0
    high = max(1e-12, *(v for row in values.values() for v in row)) if values else 1.0
    rows = [
        {
            "sink": sink.replace("_", " ") if k == 0 else "",
            "drive": drive.name if len(drives) > 1 else "",
            "value": figures(values[sink][k], 4),
            "share": percent(drive.ledger.get(sink, 0.0) / drive.energy_wh)
            if drive.energy_wh
            else "",
            "bar": bar((0.0, values[sink][k]), low, high, f"s{k % 6}"),
        }
        for sink in sinks
        for k, drive in enumerate(drives)
    ]
    columns = (
        Column("Sink", "sink"),
        Column("Drive", "drive"),
        Column("Wh/km", "value", number=True),
        Column("Of the battery's energy", "share", number=True),
        Column("", "bar"),
    )
    told = tag(
        "p",
        "A measured drive has no ledger: only a simulated one is booked by sink.",
        class_="note",
    )
    return section("energy", "Where the energy went", table(columns, rows) or told)


def totals(report: Report) -> Markup:
    """Return energy, distance and consumption of drives, against the first."""
    if not report.energy:
        return Markup("")
    changes = [None, *(c["wh_per_km_percent"] for c in compared(report.energy))]
    rows = [
        {
            "drive": d.name,
            "energy": figures(d.energy_wh, 4),
            "distance": figures(d.distance_m, 4),
            "time": figures(d.duration_s, 4),
            "per": figures(d.wh_per_km, 4),
            "against": "" if c is None else f"{c:+.2f} %".replace("-", "−"),
            "open": "" if d.residual is None else figures(d.residual, 2),
        }
        for d, c in zip(report.energy, changes, strict=True)
    ]
    columns = (
        Column("Drive", "drive"),
        Column("Energy [Wh]", "energy", number=True),
        Column("Distance [m]", "distance", number=True),
        Column("Time [s]", "time", number=True),
        Column("Consumption [Wh/km]", "per", number=True),
        Column("Against the first", "against", number=True),
        Column("Ledger left open", "open", number=True),
    )
    return section("totals", "The drives", table(columns, rows))


def driving(report: Report) -> Markup:
    """Return energy by kind of driving, of each drive."""
    rows = [
        {
            "kind": regime.name if k == 0 else "",
            "drive": d.name if len(report.energy) > 1 else "",
            "time": figures(regime.time_s),
            "energy": figures(regime.energy_wh),
            "share": percent(regime.energy_wh / d.energy_wh) if d.energy_wh else "",
        }
        for n in range(max((len(d.regimes) for d in report.energy), default=0))
        for k, d in enumerate(report.energy)
        if n < len(d.regimes)
        for regime in (d.regimes[n],)
    ]
    columns = (
        Column("Kind of driving", "kind"),
        Column("Drive", "drive"),
        Column("Time [s]", "time", number=True),
        Column("Energy [Wh]", "energy", number=True),
        Column("Of the battery's energy", "share", number=True),
    )
    return section("driving", "By kind of driving", table(columns, rows))
