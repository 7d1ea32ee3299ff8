"""A gap as a page: where a log and the model part."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from rcc_sim.analyse.gap import Gap
from rcc_sim.analyse.gap_regimes import REGIMES
from rcc_sim.analyse.gap_report import where
from rcc_sim.report.findings import Report, spans_of
from rcc_sim.report.provenance import run_record
from rcc_sim.report.text import short


def gap_page(gap: Gap, inputs: Sequence[str | Path] = ()) -> Report:
    """Return what the page of a gap shows.

    Parameters
    ----------
    gap : Gap
        From :func:`rcc_sim.analyse.gap.gap`.
    inputs : sequence of str or Path
        Files that the command read: the log, the vehicle, the repeats.
    """
    compared = {channel.channel for channel in gap.channels}
    shown = compared | {"speed_mps"}
    return Report(
        title=f"Gap of {short(gap.log)} against {gap.vehicle} ({gap.mode})",
        diagnosis={"where": where(gap)},
        measured=gap.measured,
        before={c: v for c, v in gap.simulated.items() if c in shown},
        regimes=spans_of(gap.measured["time_s"], gap.kinds, REGIMES),
        log_check=gap.findings,
        run={**run_record(inputs), "notes": "; ".join(gap.notes) or "none"},
    )
