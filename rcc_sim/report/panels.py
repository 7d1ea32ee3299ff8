"""What a report draws over time: panels of lines on one clock."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from rcc_sim.analyse.energy import cumulative_energy
from rcc_sim.report.channels import in_order, labelled
from rcc_sim.report.findings import Report, Span
from rcc_sim.report.lines import Array, Line
from rcc_sim.report.signature import signature_lines
from rcc_sim.trace import Trace
from rcc_sim.units import J_PER_WH, unit_of

EPOCH = 1e6
"""Seconds above which a clock is one since 1970, and the page counts from its start."""

COLOURS, TINTS = 6, 9
"""Colours of lines laid over each other, and of regimes."""

KINDS = {
    "standstill": 0,
    "acceleration": 1,
    "cruise": 2,
    "deceleration": 3,
    "braking": 3,
    "coast": 4,
    "launch": 5,
    "corner entry": 6,
    "corner mid": 7,
    "corner exit": 8,
}
"""Kind of driving -> its tint, on every page the same."""

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

BAND = ("_low", "_high")
"""Ends of the columns that hold the band of a profile."""


@dataclass(frozen=True)
class Panel:
    """One chart: lines of one unit over time, and the stretches flagged in it.

    ``place`` is the section of the page in which it stands.
    """

    name: str
    title: str
    unit: str
    lines: tuple[Line, ...]
    flagged: tuple[Span, ...] = ()
    place: str = "time"


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
        others = [name for name in names if name not in KINDS]
        free = {name: k % TINTS for k, name in enumerate(others)}
        return {n: k for n, k in (KINDS | free).items() if n in names}


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
    if report.profiles is not None:
        yield from _profile_panels(report.profiles, shift)
    yield from _signature_panels(report, time)


def _run_panels(runs: tuple[Trace, ...]) -> Iterable[Panel]:
    for column in RUN_COLUMNS:
        lines = tuple(
            Line(
                run.name or f"run {k + 1}",
                f"s{k % COLOURS}",
                run["time_s"],
                run[column],
            )
            for k, run in enumerate(runs)
            if column in run and np.nan_to_num(run[column]).any()
        )
        yield Panel(column, labelled(column), unit_of(column), lines)
    energy = tuple(
        Line(
            run.name or f"run {k + 1}",
            f"s{k % COLOURS}",
            run["time_s"],
            (joules - joules[0]) / J_PER_WH,
        )
        for k, run in enumerate(runs)
        for joules in (cumulative_energy(run),)
    )
    column = "battery_energy_wh"
    yield Panel(column, labelled(column), unit_of(column), energy)


def _signature_panels(report: Report, time: Array) -> Iterable[Panel]:
    for column, lines in signature_lines(report, time).items():
        unit = unit_of(column)
        yield Panel(
            f"signature {column}", labelled(column), unit, lines, place="signature"
        )


def _profile_panels(profiles: Trace, shift: float) -> Iterable[Panel]:
    time = profiles["time_s"] - shift
    for column, values in profiles.columns.items():
        if column == "time_s" or column.endswith(BAND):
            continue
        effect, _, key = column.partition(".")
        lines = [
            Line(f"90 % {end[1:]}", "s2", time, profiles[column + end])
            for end in BAND
            if column + end in profiles
        ]
        lines.append(Line("found", "a", time, values))
        title = f"Found: {effect.replace('_', ' ')}, {labelled(key)}"
        yield Panel(column, title, unit_of(key), tuple(lines))


def _compared(report: Report) -> list[str]:
    """Return the columns to draw: the speed, then where most is wrong first."""
    told = report.diagnosis.get("where", {}).get("channels") or []
    wrong = {str(c.get("channel")): float(c.get("ratio") or 0.0) for c in told}
    both = [c for c in (*report.before, *report.after) if c != "time_s"]
    both = in_order(list(dict.fromkeys(both))) or [
        c for c in wrong if report.measured is not None and c in report.measured
    ]
    return sorted(both, key=lambda c: (c != "speed_mps", -wrong.get(c, 0.0)))


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
