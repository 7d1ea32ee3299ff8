"""The signature of the winner beside its rivals: lines to draw, and a table."""

from __future__ import annotations

import numpy as np

from rcc_sim.channel import moving_mean, rows_in
from rcc_sim.report.channels import title_of
from rcc_sim.report.findings import Report
from rcc_sim.report.html_parts import Column, effect_name, section, table
from rcc_sim.report.lines import Array, Line
from rcc_sim.report.text import Markup, figures, percent, tag
from rcc_sim.report.verdict import strength

CHANNELS = 3
"""Channels that are drawn: those in which the winner shows most."""

PARTS, LONGEST = 150, 2.0
"""Parts of a drive over which the lines are averaged, and the longest of them [s]."""


def signature_lines(report: Report, time: Array) -> dict[str, tuple[Line, ...]]:
    """Return channel -> what is to be explained, and what each effect would change."""
    found = report.signatures
    if found is None or len(time) < PARTS:
        return {}
    rows = _rows(time)
    lines = {}
    for c in _shown(report, rows):
        told = [Line("to be explained", "m", time, moving_mean(found.left[c], rows))]
        told += [
            Line(
                e.effect.replace("_", " "), f"s{k}", time, moving_mean(e.moved[c], rows)
            )
            for k, e in enumerate(found.effects)
        ]
        lines[c] = tuple(told)
    return lines


def signature(report: Report, charts: Markup) -> Markup:
    """Return the section: what each would leave, and the charts."""
    found = report.signatures
    if found is None or not found.effects or not charts or report.measured is None:
        return Markup("")
    time = report.measured["time_s"]
    rows = _rows(time)
    shown = _shown(report, rows)
    told = []
    for e in found.effects:
        left = {
            c: _rms(moving_mean(found.left[c] - e.moved[c], rows))
            / (_rms(moving_mean(found.left[c], rows)) or 1.0)
            for c in shown
        }
        told.append(
            {
                "effect": effect_name(e.effect),
                "strength": ", ".join(strength(*pair) for pair in e.figures.items())
                or "varies over the drive",
                **{c: percent(left[c]) for c in shown},
            }
        )
    columns = (
        Column("With", "effect"),
        Column("At its best strength", "strength"),
        *(Column(f"Left in {title_of(c).lower()}", c, number=True) for c in shown),
    )
    has_winner = bool(report.diagnosis.get("causes"))
    first = "The first is the winner; the others do" if has_winner else "All do"
    words = (
        "What the log shows and the model does not, while everything else stands as "
        f"found (black), and what each effect would add. {first} their best in its "
        "place. Left: of the root mean square of the black line. Lines are averaged "
        f"over {figures(rows * float(np.median(np.diff(time))), 2)} s."
    )
    return section(
        "signature", "What gives it away", tag("p", words), table(columns, told), charts
    )


def _shown(report: Report, rows: int) -> list[str]:
    """Return the channels in which the first effect, or what is left, shows most."""
    found = report.signatures
    if found is None or not found.effects:
        return []
    lines = found.effects[0].moved if report.diagnosis.get("causes") else found.left
    told = report.diagnosis.get("where", {}).get("channels") or []
    noise = {str(c.get("channel")): float(c.get("noise") or 0.0) for c in told}
    size = {
        c: _rms(moving_mean(x, rows)) / (noise.get(c) or _rms(found.left[c]) or 1.0)
        for c, x in lines.items()
    }
    most = sorted(size, key=lambda c: -size[c])[:CHANNELS]
    return [c for c in size if c in most and size[c] > 0]


def _rows(time: Array) -> int:
    return rows_in(time, min(float(time[-1] - time[0]) / PARTS, LONGEST))


def _rms(x: Array) -> float:
    return float(np.sqrt(np.nanmean(x**2)))
