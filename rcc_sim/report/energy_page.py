"""The energy report of drives as a page."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from rcc_sim.analyse.energy import (
    REGIMES,
    EnergyReport,
    compared,
    kinds_of_driving,
)
from rcc_sim.report.findings import Report, Span, spans_of
from rcc_sim.report.provenance import run_record
from rcc_sim.report.text import figures, percent
from rcc_sim.trace import Trace


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
    text = f"{first.name} took {figures(first.wh_per_km, 4)} Wh/km"
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
            f"{other.name} took {figures(abs(against), 2)} % {more} "
            f"({figures(other.wh_per_km, 4)} Wh/km)"
        )
    return "; ".join([text, *told]) + "."


def regime_spans(trace: Trace) -> tuple[Span, ...]:
    """Return stretches of one kind of driving."""
    if "speed_mps" not in trace:
        return ()
    names = (*REGIMES, "speed_unknown")  # the last, as kind -1
    return spans_of(trace["time_s"], kinds_of_driving(trace), names)
