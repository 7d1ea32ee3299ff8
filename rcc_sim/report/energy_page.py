"""The energy report of drives as a page."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from rcc_sim.analyse.energy import (
    REGIMES,
    EnergyReport,
    compared,
    kinds_of_driving,
)
from rcc_sim.report.findings import Report, Span
from rcc_sim.report.provenance import run_record
from rcc_sim.report.text import figures, percent
from rcc_sim.trace import Trace

SHORTEST = 0.002
"""Share of a drive below which a change of regime is not shaded."""


def energy_page(
    drives: Sequence[Trace],
    reports: Sequence[EnergyReport],
    inputs: Sequence[str | Path] = (),
) -> Report:
    """Return what the page of an energy report shows."""
    return Report(
        title="Energy of " + " against ".join(report.name for report in reports),
        verdict=energy_verdict(reports),
        runs=tuple(
            Trace(drive.columns, name=report.name)
            for drive, report in zip(drives, reports, strict=True)
        ),
        energy=tuple(reports),
        regimes=regime_spans(drives[0]),
        run=run_record(inputs),
    )


def energy_verdict(reports: Sequence[EnergyReport]) -> str:
    """Return consumption, what it mostly went into, and how the drives differ."""
    first = reports[0]
    text = f"{first.name} took {figures(first.wh_per_km)} Wh/km"
    if first.wh_per_km is None:
        text = f"{first.name} took {figures(first.energy_wh)} Wh and never moved"
    if first.ledger and first.energy_wh > 0:
        most = max(first.ledger, key=lambda sink: first.ledger[sink])
        share = percent(first.ledger[most] / first.energy_wh)
        text += f", {share} of it into {most.replace('_', ' ')}"
    told = []
    for other, change in zip(reports[1:], compared(reports), strict=True):
        against = change["wh_per_km_percent"]
        if against is None:
            told.append(f"{other.name} took {figures(other.energy_wh)} Wh")
            continue
        more = "more" if against >= 0 else "less"
        told.append(
            f"{other.name} took {figures(abs(against))} % {more} "
            f"({figures(other.wh_per_km)} Wh/km)"
        )
    return "; ".join([text, *told]) + "."


def regime_spans(trace: Trace) -> tuple[Span, ...]:
    """Return stretches of one kind of driving; those too short to see join the last."""
    if "speed_mps" not in trace or len(trace) < 2:
        return ()
    time, kind = trace["time_s"], kinds_of_driving(trace)
    starts = np.concatenate([[0], np.flatnonzero(np.diff(kind)) + 1])
    ends = np.append(starts[1:], len(kind))
    least = SHORTEST * float(time[-1] - time[0])
    spans: list[Span] = []
    for a, b in zip(starts.tolist(), ends.tolist(), strict=True):
        name, end = REGIMES[int(kind[a])], float(time[b])
        if spans and (name == spans[-1].name or end - float(time[a]) < least):
            spans[-1] = Span(spans[-1].start_s, end, spans[-1].name)
        else:
            spans.append(Span(float(time[a]), end, name))
    return tuple(spans)
