"""A check as rows, as a JSON object, and in one line."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

from rcc_sim.analyse.logcheck.finding import ORDER, Checked


def is_sound(checked: Checked) -> bool:
    """Tell whether nothing worse than a note was found."""
    return all(finding.severity == "info" for finding in checked.findings)


def verdict(checked: Checked) -> str:
    """Return what was found in one line."""
    time = checked.trace["time_s"]
    count = _counts(checked)
    found = ", ".join(
        f"{count[severity]} {word if count[severity] == 1 else word + 's'}"
        for severity, word in zip(ORDER, ("error", "warning", "note"), strict=True)
        if count[severity]
    )
    return (
        f"{checked.trace.name}: {len(checked.trace)} rows in use, "
        f"{checked.rate:.4g} a second, {_duration(checked):.4g} s from "
        f"{float(time[0]):.10g}: {'sound' if is_sound(checked) else 'not sound'}"
        f" ({found or 'nothing found'})"
    )


def document(checks: Sequence[Checked]) -> Any:
    """Return what ``--json`` prints: one object, or one with a list of them."""
    logs = [
        {
            "log": checked.trace.name,
            "sound": is_sound(checked),
            "rows": len(checked.trace),
            "rate_hz": checked.rate,
            "duration_s": _duration(checked),
            "channels": [name for name in checked.trace.columns if name != "time_s"],
            "unusable": list(checked.unusable),
            "counts": _counts(checked),
            "findings": [asdict(finding) for finding in checked.findings],
        }
        for checked in checks
    ]
    return logs[0] if len(logs) == 1 else {"logs": logs}


def rows(checks: Sequence[Checked]) -> list[dict[str, Any]]:
    """Return the table: a row a finding, worst first within each log."""
    return [
        {"log": checked.trace.name, **asdict(finding)}
        for checked in checks
        for finding in checked.findings
    ]


def shown(checks: Sequence[Checked]) -> list[dict[str, Any]]:
    """Return the table as a person reads it, at any width; like findings as one."""
    table: dict[tuple[str, ...], list[str]] = {}
    for checked in checks:
        for f in checked.findings:
            doubt = "" if f.sure > 0.99 else f"{100 * f.sure:.0f} % sure"
            place = "" if f.where == "whole log" else f.where
            aside = ", ".join(word for word in (place, doubt) if word)
            text = "\n".join(part for part in (f.what, aside, f"→ {f.action}") if part)
            log = checked.trace.name if len(checks) > 1 else ""
            word = "note" if f.severity == "info" else f.severity
            table.setdefault((log, word, text), []).append(f.channel)
    return [
        {"log": log, "severity": word, "channel": ",\n".join(names), "finding": text}
        for (log, word, text), names in table.items()
    ]


def _counts(checked: Checked) -> dict[str, int]:
    return {
        severity: sum(finding.severity == severity for finding in checked.findings)
        for severity in ORDER
    }


def _duration(checked: Checked) -> float:
    """Return how long the log lasts, the unit mended where that is known. [s]"""
    time = checked.trace["time_s"]
    units = [f.factor for f in checked.findings if f.kind == "time_unit" and f.factor]
    return float(time[-1] - time[0]) * (units[0] if units else 1.0)
