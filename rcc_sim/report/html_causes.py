"""Which effects, how sure, what proves it, what to drive next."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from rcc_sim.report.channels import mend_of, title_of, way_of
from rcc_sim.report.findings import Report
from rcc_sim.report.html_parts import (
    Column,
    bar,
    effect_name,
    effect_title,
    section,
    table,
)
from rcc_sim.report.promise import promise
from rcc_sim.report.text import (
    Markup,
    figures,
    joined,
    percent,
    probable,
    short,
    signed,
    tag,
)
from rcc_sim.report.verdict import TAKEN_UP, unaccounted
from rcc_sim.units import unit_of

SHOWN = 8
"""Candidates that have a row; the others are named."""


def causes(report: Report) -> Markup:
    """Return what the diagnosis asserts, and how the candidates rank."""
    diagnosis = report.diagnosis
    if "status" not in diagnosis:
        return Markup("")
    return section(
        "causes",
        "What it is",
        asserted(diagnosis),
        _ranked(diagnosis),
        _left(diagnosis),
    )


def asserted(diagnosis: Mapping[str, Any]) -> Markup:
    """Return the causes that stand, or why there is none."""
    found = diagnosis.get("causes") or []
    if not found:
        reason = {
            "no_gap": "No cause is asserted: row by row there is no gap beyond noise "
            "and the doubt that the vehicle file states.",
            "unexplained": "No cause is asserted: a real gap that "
            f"{unaccounted(diagnosis.get('candidates') or [])}. The flagged stretches "
            "say where it sits.",
        }
        if diagnosis.get("taken_up"):
            return tag("p", f"No cause is asserted: the gap is real, and {TAKEN_UP}.")
        return tag("p", reason.get(diagnosis["status"], "No cause is asserted."))
    rows = [
        {
            "effect": effect_name(str(cause.get("effect", "?"))),
            "figures": _parameters(cause.get("parameters") or {}),
            "probability": probable(cause.get("probability")),
            "explains": percent(cause.get("explains")),
            "energy": _added(cause.get("energy_wh")),
            "others": _others(cause),
        }
        for cause in found
    ]
    columns = (
        Column("Effect", "effect"),
        Column("Figures of the mended file (90 % interval)", "figures"),
        Column("Adds [Wh]", "energy", number=True),
        Column("Probability", "probability", number=True),
        Column("Explains", "explains", number=True),
        Column("This log cannot tell it from", "others"),
    )
    return table(columns, rows)


def _others(cause: Mapping[str, Any]) -> Markup | str:
    """Return what would do in a cause's place, and how strong it would be."""
    own = cause.get("instead") or {}
    lines = [
        tag("div", effect_title(str(name)), _parameters(own.get(name) or {}))
        for name in cause.get("indistinguishable_from") or []
    ]
    return joined(*lines) if lines else "–"


def _added(energy: Any) -> str:
    if energy is None:
        return ""
    return signed(float(energy))


def _parameters(parameters: Mapping[str, Any]) -> Markup:
    lines = []
    for name, told in parameters.items():
        figure = told if isinstance(told, Mapping) else {"value": told}
        unit = unit_of(name)
        text = f"{figures(figure.get('value'), 4)}"
        if figure.get("low") is not None and figure.get("high") is not None:
            text += f" ({figures(figure['low'], 4)} to {figures(figure['high'], 4)})"
        text += f" {unit}" if unit != "1" else ""
        if figure.get("stated") is not None:
            text += f", stated {figures(figure['stated'], 4)}"
        lines.append(tag("div", tag("code", name), " ", text))
    return joined(*lines)


def _ranked(diagnosis: Mapping[str, Any]) -> Markup:
    ranking = diagnosis.get("ranking") or []
    if not ranking:
        return Markup("")
    ties = {
        str(o): str(cause.get("effect"))
        for cause in diagnosis.get("causes") or []
        for o in cause.get("indistinguishable_from") or []
    }
    rows = [
        {
            "effect": effect_name(str(row.get("effect", "?"))),
            "probability": probable(row.get("probability")),
            "bar": bar((0.0, float(row.get("probability") or 0.0)), 0.0, 1.0, "a"),
            "explains": percent(row.get("explains")),
            "tie": f"tied with {effect_title(ties[row['effect']])}"
            if row.get("effect") in ties
            else "",
        }
        for row in ranking[:SHOWN]
    ]
    columns = (
        Column("Candidate", "effect"),
        Column("Probability", "probability", number=True),
        Column("", "bar"),
        Column("Explains", "explains", number=True),
        Column("Tie", "tie"),
    )
    told = (
        "Probability that the effect acts, given this log and the stated doubt. "
        "Explains: of what the best candidate explains, each taken alone."
    )
    rest = [effect_title(str(row.get("effect"))) for row in ranking[SHOWN:]]
    more = ""
    if rest:
        head = tag("summary", f"{len(rest)} more that are less probable")
        more = tag("details", head, tag("p", ", ".join(rest) + ".", class_="note"))
    return Markup(tag("h3", "Candidates") + table(columns, rows, told) + more)


def _left(diagnosis: Mapping[str, Any]) -> Markup:
    left = diagnosis.get("unexplained") or {}
    if left.get("fraction") is None:
        return Markup("")
    if left["fraction"]:
        text = f"{percent(left['fraction'])} of the gap beyond noise stays unexplained"
    elif left.get("acts_as"):
        text = "No row is off beyond noise any more, but what is left hangs together"
    else:
        return tag("p", "Nothing beyond noise is left over.")
    if left.get("acts_as"):
        follows = title_of(str(left.get("follows", ""))).lower()
        way = way_of(str(left["acts_as"]), left.get("course"))
        text += f"; it acts like {way} that follows {follows}"
        text += "".join(
            f" (--candidates {x} asks for that)" for x in left.get("may_be", ())
        )
        mend = mend_of(str(left["acts_as"]), str(left.get("follows", "")))
        text += f" ({mend})" if mend else ""
    windows = left.get("windows") or []
    if windows:
        when = ", ".join(
            f"{figures(w.get('start_s'), 5)} to {figures(w.get('end_s'), 5)} s"
            for w in windows
        )
        text += f", most of it at {when}"
    if left.get("log"):
        text += f", in {left['log']}"
    return tag("p", f"{text}.")


def held_out(report: Report) -> Markup:
    """Return the proof on stretches of the log that no fit saw."""
    shrink = report.diagnosis.get("shrink") or {}
    before, after = shrink.get("before"), shrink.get("after")
    if before is None or after is None:
        return Markup("")
    most = max(float(before), float(after), 1e-12)
    rows = [
        {
            "what": "with the vehicle as it was",
            "left": figures(before),
            "bar": bar((0.0, float(before)), 0.0, most, "b"),
            "energy": _gap(shrink.get("energy_gap_percent_before")),
        },
        {
            "what": "with the mended vehicle",
            "left": figures(after),
            "bar": bar((0.0, float(after)), 0.0, most, "a"),
            "energy": _gap(shrink.get("energy_gap_percent_after")),
        },
    ]
    columns = (
        Column("Simulated", "what"),
        Column("Error beyond noise", "left", number=True),
        Column("", "bar"),
        Column("Energy gap", "energy", number=True),
    )
    seen = (
        f"Judged on {_judged_on(shrink)}."
        if shrink.get("held_out")
        else "Judged on the same data as fitted: no proof."
    )
    if shrink.get("courses_held_out") is False:
        seen += " The course of what varies was fitted there as well."
    told = seen + (
        " Mean square error beyond noise, channels in units of their noise: what their "
        "sensors scatter, and a rough road."
    )
    if shrink.get("explained") is not None:
        told += f" Explained: {percent(shrink['explained'])}"
        if shrink.get("low") is not None and shrink.get("high") is not None:
            low, high = percent(shrink["low"]), percent(shrink["high"])
            told += f" (90 % interval {low} to {high})"
        told += "."
    if gone := [effect_title(str(e)) for e in shrink.get("withdrawn") or []]:
        told += f" Withdrawn, for it did nothing there: {', '.join(gone)}."
    return section(
        "proof",
        "Does it hold on data it has not seen?",
        tag("p", told),
        table(columns, rows),
    )


def _judged_on(shrink: Mapping[str, Any]) -> str:
    logs = [short(str(name)) for name in shrink.get("logs") or []]
    if not logs:
        return "stretches of the log that no fit saw"
    return f"{', '.join(logs)}, which no fit saw"


def _gap(value: Any) -> str:
    return "" if value is None else f"{figures(value)} %"


def next_experiment(report: Report) -> Markup:
    """Return what to drive next, and what it would tell apart."""
    steps = report.diagnosis.get("next_experiment") or []
    items = []
    for step in steps:
        told = f" It {promise(step, effect_title)}."
        todo = str(step.get("do", "")).strip().rstrip(".")
        items.append(tag("li", tag("strong", todo[:1].upper() + todo[1:] + "."), told))
    if items:
        return section("next", "What to drive next", tag("ol", *items))
    causes = report.diagnosis.get("causes")
    if not causes:
        return Markup("")
    if any(c.get("indistinguishable_from") for c in causes):
        none = "No run of the menu would tell apart what is tied."
        return section("next", "What to drive next", tag("p", none))
    what = (
        "Nothing is tied. To see whether the shrink is real, drive once more and hold "
        "that log against the mended vehicle: ",
        tag("code", "rccsim gap OTHER.csv --vehicle mended.toml"),
    )
    return section("next", "What to drive next", tag("p", *what))
