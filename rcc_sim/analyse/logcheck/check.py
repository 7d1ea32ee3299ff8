"""Check a log: one channel at a time, then channels against each other."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from rcc_sim.analyse.logcheck.blame import blame
from rcc_sim.analyse.logcheck.channels import (
    clipped,
    clipped_rows,
    coarse,
    dead,
    held,
    stuck,
    stuck_findings,
    stuck_rows,
    zero_start,
)
from rcc_sim.analyse.logcheck.clocks import offsets
from rcc_sim.analyse.logcheck.finding import (
    ORDER,
    Array,
    Checked,
    Columns,
    Finding,
    Mask,
    by_map,
    is_constant,
)
from rcc_sim.analyse.logcheck.glitches import (
    backwards,
    height_leaps,
    pose_jumps,
    spike_findings,
    spikes,
)
from rcc_sim.analyse.logcheck.mistakes import follows_erpm
from rcc_sim.analyse.logcheck.relation import means
from rcc_sim.analyse.logcheck.relations import relations
from rcc_sim.analyse.logcheck.rest import biases, late_commands
from rcc_sim.analyse.logcheck.timebase import TimeBase, missing, time_base
from rcc_sim.analyse.logcheck.units import (
    beyond_reach,
    by_size,
    geared,
    net_sign,
    unsigned,
)
from rcc_sim.definitions.vehicle import Vehicle
from rcc_sim.errors import InputError
from rcc_sim.trace import Trace

SURE = 5.0
"""Looseness of a relation beyond which a channel's size still tells its unit."""

LARGEST = 1e30
"""Beyond this a reading is as good as infinite. [the column's unit]"""

MAY_STAY = "on_stand", "battery_voltage_v"
"""What tells something though it stays the same: a stiff battery's volts are judged."""

FEWEST = 3
"""Rows below which a table is no log."""


def check_log(trace: Trace, vehicle: Vehicle | None = None) -> Checked:
    """Return what is wrong with a log, and the log as far as it can be used.

    Nothing is repaired: rows without a usable time and dead channels are left out,
    glitches and stuck stretches become NaN, and each finding says so. A unit or a sign
    that physics contradicts is reported with its likely mend, and not mended.

    Parameters
    ----------
    trace : Trace
        A log as read; rows may be irregular, channels may hold NaN.
    vehicle : Vehicle or None
        Its file, by which motor speed, voltage and power are judged too.

    Returns
    -------
    Checked
        The usable trace, the findings (worst first) and the rows per second.

    Raises
    ------
    InputError
        If the table is no log: no time, no channel, hardly a row.
    """
    _refuse(trace)
    base = time_base(trace)
    checked = _checked(trace, vehicle, base)
    time = next((f for f in checked.findings if _is_time(f)), None)
    if time is not None and time.factor is not None:  # look again, at the right pace
        checked = _checked(trace, vehicle, _repaced(base, time.factor))
    return checked


def _is_time(finding: Finding) -> bool:
    return finding.kind == "unit" and finding.channel == "time_s"


def _repaced(base: TimeBase, factor: float) -> TimeBase:
    """Return a time base whose unit is another, as the motion says."""
    whole = base.factor * factor
    what = f"is not in seconds: the car's motion asks for a factor of {whole:g}"
    found = Finding(
        "time_unit",
        "time_s",
        what,
        sure=0.95,
        action=f"not mended; {by_map(whole)}",
        severity="error",
        factor=whole,
    )
    rest = [f for f in base.findings if f.kind != "time_unit"]
    return TimeBase(base.keep, [found, *rest], base.rate / factor, whole)


def _checked(trace: Trace, vehicle: Vehicle | None, base: TimeBase) -> Checked:
    if base.keep.sum() < FEWEST:
        raise InputError(
            f"{trace.name}: time_s: {base.keep.sum()} usable rows of {len(trace)}",
            "time should increase from row to row",
        )
    findings = list(base.findings)
    columns = _finite(trace, base.keep, findings)
    gone = dead(columns, 1 / base.rate)
    findings += gone
    for finding in gone:
        if finding.kind == "dead":
            del columns[finding.channel]
    if not any(np.isfinite(columns[n]).any() for n in columns if n != "time_s"):
        raise InputError(f"{trace.name}: no channel holds a value")
    skip, found = zero_start(columns["time_s"] * base.factor, columns)
    findings += found
    columns = {name: values[skip:] for name, values in columns.items()}
    seconds = columns["time_s"] * base.factor
    findings += _each(seconds, columns)
    findings += _together(columns, seconds, vehicle)
    findings.sort(key=lambda f: ORDER.index(f.severity))
    return Checked(Trace(columns, name=trace.name), tuple(findings), base.rate)


def _refuse(trace: Trace) -> None:
    if "time_s" not in trace:
        raise InputError(
            f"{trace.name}: no column time_s",
            f"there are {', '.join(trace.columns) or 'none'}",
        )
    if len(trace.columns) < 2:
        raise InputError(f"{trace.name}: no channel besides time_s")
    if len(trace) < FEWEST:
        what = f"{trace.name}: {len(trace)} rows are no log"
        raise InputError(what, f"a log has {FEWEST} at least")


def _finite(trace: Trace, keep: Mask, findings: list[Finding]) -> dict[str, Array]:
    """Return the kept rows, an infinity being no value."""
    out: dict[str, Array] = {}
    whole = bool(keep.all())
    for name, given in trace.columns.items():
        values = np.asarray(given, dtype=float)
        values = values if whole else values[keep]
        wild = np.abs(values) > LARGEST if name != "time_s" else np.isinf(values)
        if wild.any():
            values = np.where(wild, np.nan, values)
            findings.append(
                Finding(
                    "infinite",
                    name,
                    f"{int(wild.sum())} rows are infinite, or beyond any sensor",
                    action="masked (NaN)",
                    severity="warning",
                )
            )
        out[name] = values
    return out


def _each(seconds: Array, columns: dict[str, Array]) -> list[Finding]:
    """Check one channel at a time; mask the rows that cannot be used."""
    findings: list[Finding] = []
    speed = columns.get("speed_mps")
    jumps = pose_jumps(seconds, _without_spikes(seconds, columns))
    for name, values in list(columns.items()):
        if name == "time_s" or name.endswith("_j") or is_constant(values):
            continue
        findings += missing(seconds, name, values)
        findings += held(seconds, name, values)
        findings += coarse(name, values)
        frozen = stuck(seconds, name, values, speed)
        walls = clipped(seconds, name, values)
        bad = np.concatenate(
            [
                odd := spikes(seconds, name, values),
                stuck_rows(frozen),
                clipped_rows(values, [wall for wall, _ in walls]),
            ]
        ).astype(int)
        findings += stuck_findings(seconds, name, values, frozen)
        findings += [said for _, said in walls]
        findings += spike_findings(seconds, name, values, odd)
        if len(bad):
            masked = values.copy()
            masked[bad] = np.nan
            columns[name] = masked
    lost, leaps = height_leaps(seconds, columns)
    if len(lost):
        columns["elevation_m"] = columns["elevation_m"].copy()
        columns["elevation_m"][lost] = np.nan
    return findings + jumps + leaps


def _without_spikes(time: Array, columns: Columns) -> dict[str, Array]:
    out = dict(columns)
    for name in ("x_m", "y_m"):
        if name in out:
            rows = spikes(time, name, out[name])
            out[name] = out[name].copy()
            out[name][rows] = np.nan
    return out


def _together(
    columns: dict[str, Array], seconds: Array, vehicle: Vehicle | None
) -> list[Finding]:
    """Check channels against each other, and the car at rest."""
    live = {
        name: values
        for name, values in columns.items()
        if name != "time_s" and not is_constant(values)
    }
    twin = follows_erpm("speed_mps", live) and follows_erpm("motor_speed_radps", live)
    if twin:  # one reading, told twice
        del live["motor_speed_radps"]
    clocks = offsets(seconds, live)
    stays = {c: columns[c] for c in MAY_STAY if c in columns}
    windows = means(seconds, stays | live)
    known = relations(windows, vehicle)
    judged = live | stays | {"time_s": seconds}
    findings = _in_step(blame(known, judged, vehicle), clocks) + clocks
    if twin:
        what = "is wrong as speed_mps is: both are of motor_speed_erpm"
        findings += [
            replace(f, channel="motor_speed_radps", what=what)
            for f in findings
            if f.channel == "speed_mps" and f.severity == "error"
        ]
    wrong = [f.channel for f in findings if f.severity == "error"]
    told = {name for r in known if r.loose < SURE for name in r.powers}
    findings += by_size(live, [*wrong, *told])
    if not any(f.kind == "other_vehicle" for f in findings):
        findings += beyond_reach(live, vehicle, [f.channel for f in findings])
    findings += net_sign(live, wrong)
    findings += unsigned(windows, wrong)
    findings += geared(known, vehicle, wrong)
    wrong = [f.channel for f in findings if f.severity == "error"]
    sound = {name: values for name, values in live.items() if name not in wrong}
    checks: tuple[Callable[[Array, Columns], list[Finding]], ...] = (
        biases,
        late_commands,
        backwards,
    )
    for check in checks:
        findings += check(seconds, sound)
    return findings


def _in_step(findings: list[Finding], clocks: list[Finding]) -> list[Finding]:
    """Return the findings without signs that only seem wrong: half a wave too late."""
    shifted = {finding.channel for finding in clocks}
    if "yaw_rate_radps" in shifted:
        shifted.add("accel_y_mps2")
    return [f for f in findings if f.kind != "sign" or f.channel not in shifted]
