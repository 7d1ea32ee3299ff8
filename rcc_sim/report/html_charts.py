"""Charts of a report: SVG that is whole without a script, and the data to zoom it."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np

from rcc_sim.report.findings import Span
from rcc_sim.report.lines import HEIGHT, WIDTH, Packer, bounds, path, ticks
from rcc_sim.report.panels import Charts, Panel
from rcc_sim.report.text import Markup, tag

UP, ALONG = 5, 6
"""Marks on an axis, about."""


def drawn(charts: Charts) -> Markup:
    """Return the charts as HTML: a toolbar, a legend of regimes, a figure a panel."""
    clock = "Time since the log's start [s]" if charts.since_start else "Time [s]"
    return tag(
        "div",
        _tools(),
        _legend(charts),
        *(_figure(charts, k) for k, p in enumerate(charts.panels) if p.place == "time"),
        tag("p", clock, class_="clock"),
        id="charts",
        tabindex="0",
        role="group",
        aria_label="Charts over time; arrows move, plus and minus zoom, 0 shows all",
    )


def drawn_apart(charts: Charts, place: str) -> Markup:
    """Return the charts of another section; they move with the others."""
    numbers = [k for k, p in enumerate(charts.panels) if p.place == place]
    return tag("div", *(_figure(charts, k) for k in numbers)) if numbers else Markup("")


def _tools() -> Markup:
    tools = {
        "in": ("+", "Zoom in"),
        "out": ("−", "Zoom out"),
        "left": ("◀", "Earlier"),
        "right": ("▶", "Later"),
        "all": ("All", "Show the whole time"),
    }
    buttons = (
        tag("button", sign, type="button", data_do=name, aria_label=title, title=title)
        for name, (sign, title) in tools.items()
    )
    return tag(
        "div",
        *buttons,
        tag("span", "Drag across a chart to zoom; double-click shows all."),
        tag("output", "", id="at", aria_live="off"),
        class_="tools",
        hidden=True,
    )


def _legend(charts: Charts) -> Markup:
    keys = [
        tag("li", tag("i", "", class_=f"patch t{tint}"), name)
        for name, tint in charts.tints.items()
    ]
    if any(panel.flagged for panel in charts.panels):
        keys.append(
            tag(
                "li",
                tag("i", "", class_="patch flagged"),
                "flagged: where most of the gap sits",
            )
        )
    return tag("ul", *keys, class_="legend shades") if keys else Markup("")


def _figure(charts: Charts, number: int) -> Markup:
    panel = charts.panels[number]
    reach = bounds(list(panel.lines))
    names = tag(
        "ul",
        *(
            tag(
                "li",
                tag(
                    "button",
                    tag("i", "", class_=f"stroke {line.kind}"),
                    line.name,
                    tag("b", "", class_="value"),
                    type="button",
                    aria_pressed="true",
                ),
            )
            for line in panel.lines
        ),
        class_="legend",
    )
    return tag(
        "figure",
        tag("figcaption", tag("span", panel.title, class_="axis"), names),
        tag(
            "div",
            tag("div", *_marks(reach, vertical=True), class_="ys", aria_hidden="true"),
            tag("div", _svg(charts, panel, reach), class_="plot"),
            tag(
                "div",
                *_marks(charts.span, vertical=False),
                class_="xs",
                aria_hidden="true",
            ),
            class_="frame",
        ),
        class_="panel",
        data_panel=str(number),
    )


def _marks(reach: tuple[float, float], *, vertical: bool) -> list[Markup]:
    size = reach[1] - reach[0]
    marks = []
    for value, text in ticks(*reach, UP if vertical else ALONG):
        share = 100 * (value - reach[0]) / size
        where = f"bottom:{share:.2f}%" if vertical else f"left:{share:.2f}%"
        marks.append(tag("span", text, style=where))
    return marks


def _svg(charts: Charts, panel: Panel, reach: tuple[float, float]) -> Markup:
    span = charts.span
    shades = [
        tag(
            "path",
            d=_boxes(_named(charts.regimes, name), span),
            class_=f"shade t{tint}",
        )
        for name, tint in charts.tints.items()
    ]
    if panel.flagged:
        shades.append(
            tag("path", d=_boxes(panel.flagged, span), class_="shade flagged")
        )
    grid = "".join(
        f"M0 {round((reach[1] - v) * HEIGHT / (reach[1] - reach[0]))}H{WIDTH}"
        for v, _ in ticks(*reach, UP)
    )
    return tag(
        "svg",
        *shades,
        tag("path", d=grid, class_="grid"),
        *(
            tag("path", d=path(line, span, reach), class_=f"line {line.kind}")
            for line in panel.lines
        ),
        tag("path", d="", class_="cursor"),
        viewBox=f"0 0 {WIDTH} {HEIGHT}",
        preserveAspectRatio="none",
        role="img",
        aria_label=_described(panel),
    )


def _described(panel: Panel) -> str:
    """Return a chart in words, for those who do not see it."""
    parts = []
    for line in panel.lines:
        good = line.y[np.isfinite(line.y)]
        if len(good):
            parts.append(
                f"{line.name} from {good.min():.4g} to {good.max():.4g}, "
                f"mean {good.mean():.4g}"
            )
    return f"{panel.title}: " + "; ".join(parts)


def _named(spans: tuple[Span, ...], name: str) -> tuple[Span, ...]:
    return tuple(span for span in spans if span.name == name)


def _boxes(spans: Iterable[Span], span: tuple[float, float]) -> str:
    scale = WIDTH / (span[1] - span[0])
    words = []
    for s in spans:
        a, b = (
            (max(min(t, span[1]), span[0]) - span[0]) * scale
            for t in (s.start_s, s.end_s)
        )
        if b > a:
            words.append(f"M{a:.1f} 0V{HEIGHT}H{b:.1f}V0Z")
    return "".join(words)


def packed(charts: Charts) -> dict[str, Any]:
    """Return what the page's script needs to draw the charts at any zoom."""
    lines = [line for panel in charts.panels for line in panel.lines]
    packer = Packer(len(lines), sum(len(line.x) for line in lines))
    panels = [
        {
            "lines": [packer.pack(line) for line in panel.lines],
            "flagged": [[s.start_s, s.end_s] for s in panel.flagged],
            "unit": panel.unit if panel.unit != "1" else "",
        }
        for panel in charts.panels
    ]
    regimes = [
        {
            "name": name,
            "spans": [[s.start_s, s.end_s] for s in _named(charts.regimes, name)],
        }
        for name in charts.tints
    ]
    return {
        "span": charts.span,
        "panels": panels,
        "regimes": regimes,
        "axes": packer.axes,
    }
