"""Check a log together with what its reader had to say of the file."""

from __future__ import annotations

from contextlib import suppress

from rcc_sim.analyse.logcheck.check import check_log
from rcc_sim.analyse.logcheck.finding import ORDER, Checked, Finding
from rcc_sim.analyse.logcheck.one_clock import one_clock
from rcc_sim.analyse.stale import refreshed
from rcc_sim.definitions.vehicle import Vehicle
from rcc_sim.errors import InputError
from rcc_sim.readers import Log, with_vehicle


def check_reading(reading: Log, vehicle: Vehicle | None = None) -> Checked:
    """Return what :func:`check_log` finds, and what is wrong with the file itself.

    Parameters
    ----------
    reading : Log
        As read.
    vehicle : Vehicle or None
        As in :func:`check_log`.

    Raises
    ------
    InputError
        As :func:`check_log` does.
    """
    if vehicle is not None:
        with suppress(InputError):  # it does not state wheel, gear or poles
            reading = with_vehicle(reading, vehicle)
    trace, clocks = one_clock(reading.trace)
    checked = check_log(trace, vehicle)
    _, held = refreshed(checked.trace)
    found = sorted(
        (*file_findings(reading), *clocks, *checked.findings, *held),
        key=lambda f: ORDER.index(f.severity),
    )
    return Checked(checked.trace, tuple(found), checked.rate)


def file_findings(reading: Log) -> tuple[Finding, ...]:
    """Return what the reader found wrong with the file, and what it had to assume."""
    flaws = [
        Finding(
            flaw.kind,
            flaw.channel or "file",
            flaw.what,
            action=flaw.action,
            severity="warning" if flaw.severe else "info",
        )
        for flaw in reading.flaws
    ]
    for guess in reading.guessed:
        channel, _, what = guess.partition(": ")
        taken = Finding("guess", channel, what, sure=0.5, action="taken to be so")
        flaws.append(taken)
    return tuple(flaws)
