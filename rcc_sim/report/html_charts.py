"""Charts of a report: SVG that is whole without a script, and the data to zoom it."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np

from rcc_sim.analyse.energy import REGIMES, cumulative_energy
from rcc_sim.report.channels import in_order, labelled, title_of
from rcc_sim.report.findings import Report, Span
from rcc_sim.report.lines import HEIGHT, WIDTH, Array, Line, Packer, bounds, path, ticks
from rcc_sim.report.text import Markup, tag
from rcc_sim.trace import Trace
from rcc_sim.units import J_PER_WH, unit_of

EPOCH = 1e6
"""Seconds above which a clock is one since 1970, and the page counts from its start."""

TINTS = 6
"""Colours of regimes, and of lines laid over each other."""

UP, ALONG = 5, 6
"""Marks on an axis, about."""

RUN_COLUMNS = (
    "speed_mps",
    "motor_current_a",
    "motor_torque_nm",
    "battery_power_w",
    "steer_cmd_rad",
    "yaw_rate_radps",
    "accel_y_mps2",
)
"""What is drawn of drives laid over each other."""

RIVALS = 4
"""Signatures that are drawn beside the measured gap."""


@dataclass(frozen=True)
class Panel:
    """One chart: lines of one unit over time, and the stretches flagged in it."""

    name: str
    title: str
    unit: str
    lines: tuple[Line, ...]
    flagged: tuple[Span, ...] = ()


@dataclass(frozen=True)
class Charts:
    """Panels on one time axis, and what is shaded behind all of them."""

    panels: tuple[Panel, ...]
    regimes: tuple[Span, ...]
    since_start: bool

    @property
    def span(self) -> tuple[float, float]:
        """First and last moment of any line. [s]"""
        lines = [line for p in self.panels for line in p.lines if len(line.x)]
        low = min(float(line.x[0]) for line in lines)
        high = max(float(line.x[-1]) for line in lines)
        return low, high if high > low else low + 1.0

    @property
    def tints(self) -> dict[str, int]:
        """Name of a regime -> number of its tint."""
        names = dict.fromkeys(span.name for span in self.regimes)
        order = [*REGIMES, *(name for name in names if name not in REGIMES)]
        return {name: k % TINTS for k, name in enumerate(order) if name in names}


def charts_of(report: Report) -> Charts | None:
    """Return the charts of a report; None if it has nothing over time."""
    first = report.measured or (report.runs[0] if report.runs else None)
    if first is None or not len(first):
        return None
    start = float(first["time_s"][0])
    shift = start if abs(start) > EPOCH else 0.0
    panels = [p for p in _panels(report, shift) if p.lines]
    if not panels:
        return None
    return Charts(tuple(panels), _moved(report.regimes, shift), shift != 0.0)


def _panels(report: Report, shift: float) -> Iterable[Panel]:
    if report.measured is None:
        yield from _run_panels(report.runs)
        return
    log = report.measured
    time = log["time_s"] - shift
    for column in _compared(report):
        told = (
            ("measured", "m", log.columns),
            ("simulated before", "b", report.before),
            ("simulated after", "a", report.after),
        )
        lines = tuple(
            Line(
                name if k != "b" or report.after else "simulated", k, time, part[column]
            )
            for name, k, part in told
            if column in part
        )
        flagged = _moved(_flagged(report, column), shift)
        yield Panel(column, labelled(column), unit_of(column), lines, flagged)
    yield from _signature_panels(report, time)
    if report.profiles is not None:
        yield from _profile_panels(report.profiles, shift)


def _run_panels(runs: tuple[Trace, ...]) -> Iterable[Panel]:
    for column in RUN_COLUMNS:
        lines = tuple(
            Line(
                run.name or f"run {k + 1}", f"s{k % TINTS}", run["time_s"], run[column]
            )
            for k, run in enumerate(runs)
            if column in run and np.nan_to_num(run[column]).any()
        )
        yield Panel(column, labelled(column), unit_of(column), lines)
    energy = tuple(
        Line(
            run.name or f"run {k + 1}",
            f"s{k % TINTS}",
            run["time_s"],
            (joules - joules[0]) / J_PER_WH,
        )
        for k, run in enumerate(runs)
        for joules in (cumulative_energy(run),)
    )
    column = "battery_energy_wh"
    yield Panel(column, labelled(column), unit_of(column), energy)


def _signature_panels(report: Report, time: Array) -> Iterable[Panel]:
    log, before = report.measured, report.before
    if log is None:
        return
    columns = dict.fromkeys(c for s in report.signatures.values() for c in s)
    for column in in_order(list(columns)):
        if column not in before or column not in log:
            continue
        rivals = [n for n, s in report.signatures.items() if column in s][:RIVALS]
        lines = [
            Line("gap: measured − simulated", "m", time, log[column] - before[column])
        ]
        lines += [
            Line(
                f"what {name.replace('_', ' ')} would do", f"s{k}", time, found[column]
            )
            for k, name in enumerate(rivals)
            for found in (report.signatures[name],)
        ]
        unit = unit_of(column)
        title = f"Signature in {title_of(column).lower()} [{unit}]"
        yield Panel(f"signature {column}", title, unit, tuple(lines))


def _profile_panels(profiles: Trace, shift: float) -> Iterable[Panel]:
    time = profiles["time_s"] - shift
    for column, values in profiles.columns.items():
        if column == "time_s":
            continue
        effect, _, key = column.partition(".")
        title = f"Found: {effect.replace('_', ' ')}, {labelled(key)}"
        yield Panel(column, title, unit_of(key), (Line(key, "a", time, values),))


def _compared(report: Report) -> list[str]:
    """Return the columns to draw: those compared, where most is wrong first."""
    told = report.diagnosis.get("where", {}).get("channels") or []
    ranked = [c.get("channel", "") for c in told]
    both = [c for c in (*report.before, *report.after) if c != "time_s"]
    both = in_order(list(dict.fromkeys(both))) or [
        c for c in ranked if report.measured is not None and c in report.measured
    ]
    return sorted(both, key=lambda c: c != "speed_mps")


def _flagged(report: Report, column: str) -> tuple[Span, ...]:
    diagnosis = report.diagnosis
    windows = [
        *(diagnosis.get("where", {}).get("windows") or []),
        *(diagnosis.get("unexplained", {}).get("windows") or []),
    ]
    return tuple(
        Span(float(w["start_s"]), float(w["end_s"]), "flagged")
        for w in windows
        if w.get("channel", column) == column
    )


def _moved(spans: tuple[Span, ...], shift: float) -> tuple[Span, ...]:
    return tuple(Span(s.start_s - shift, s.end_s - shift, s.name) for s in spans)


def drawn(charts: Charts) -> Markup:
    """Return the charts as HTML: a toolbar, a legend of regimes, a figure a panel."""
    clock = "Time since the log's start [s]" if charts.since_start else "Time [s]"
    return tag(
        "div",
        _tools(),
        _legend(charts),
        *(_figure(charts, k) for k in range(len(charts.panels))),
        tag("p", clock, class_="clock"),
        id="charts",
        tabindex="0",
        role="group",
        aria_label="Charts over time; arrows move, plus and minus zoom, 0 shows all",
    )


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
