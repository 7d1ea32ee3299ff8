"""A diagnosis as a page: where, which, how much, proven, and the mended file."""

from __future__ import annotations

import difflib
import io
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from rcc_sim.analyse.gap_regimes import REGIMES
from rcc_sim.diagnose.causes.prices import with_profiles
from rcc_sim.diagnose.deliver import write_mended, write_profiles
from rcc_sim.diagnose.diagnosis import Diagnosis
from rcc_sim.diagnose.fitting.knobs import figures_of
from rcc_sim.diagnose.residuals.posed import by_motion
from rcc_sim.diagnose.signatures import signatures
from rcc_sim.report.findings import Report, spans_of
from rcc_sim.report.provenance import run_record
from rcc_sim.report.text import short
from rcc_sim.trace import Trace, read_trace

Columns = Mapping[str, NDArray[np.float64]]


def diagnosis_page(found: Diagnosis, inputs: Sequence[str | Path] = ()) -> Report:
    """Return what the page of a diagnosis shows.

    Parameters
    ----------
    found : Diagnosis
        From :func:`rcc_sim.diagnose.run.diagnose`.
    inputs : sequence of str or Path
        Files that the command read: logs and vehicle.
    """
    gap = found.gap
    shown = {channel.channel for channel in gap.channels} | {"speed_mps"}
    after = mended(found)
    given_away = signatures(found) if found.status != "no_gap" else None
    names = [short(g.log) for g in found.gaps]
    many = f"{short(gap.log)}, one of {len(names)} logs" if names[1:] else ""
    return Report(
        title=f"Diagnosis of {', '.join(names)} against {gap.vehicle} ({gap.mode})",
        diagnosis=found.document(),
        measured=gap.measured,
        which=many,
        before={c: v for c, v in gap.simulated.items() if c in shown},
        after={c: v for c, v in after.items() if c in shown},
        regimes=spans_of(gap.measured["time_s"], gap.kinds, REGIMES),
        prices=found.prices,
        signatures=given_away,
        log_check=gap.findings,
        vehicle_diff=_diff(found),
        profiles=_profiles(found),
        run=run_record(inputs),
    )


def mended(found: Diagnosis) -> Columns:
    """Return a free run of the mended vehicle at the rows of the log shown.

    By its motion, as the stated one's: not by the torque that was logged.
    """
    figures = figures_of(found.fit.values, found.shown)
    on = with_profiles(found.plain, [a.cause for a in found.asserted], found.shown)
    return replace(by_motion(on), turned=None).driven(figures)


def _diff(found: Diagnosis) -> str:
    path = found.vehicle.path
    if path is None or not path.is_file():
        return ""
    with tempfile.TemporaryDirectory() as folder:
        target = Path(folder) / path.name
        write_mended(found, target)
        old, new = (p.read_text("utf-8").splitlines() for p in (path, target))
    lines = difflib.unified_diff(old, new, path.name, "mended", lineterm="", n=1)
    return "\n".join(lines)


def _profiles(found: Diagnosis) -> Trace | None:
    if not any(a.cause.profiles for a in found.asserted):
        return None
    file = io.BytesIO()
    write_profiles(found, file, found.shown)
    return read_trace("-", io.BytesIO(file.getvalue()))
