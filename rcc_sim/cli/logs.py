"""Options that commands over logs share, and what they tell of a log."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from math import inf
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from rcc_sim.cli.complete import column_names, map_names, vehicle_names
from rcc_sim.cli.output import say
from rcc_sim.errors import InputError
from rcc_sim.files import atomic

if TYPE_CHECKING:
    from rcc_sim.analyse.logcheck.finding import Finding
    from rcc_sim.definitions.vehicle import Vehicle
    from rcc_sim.report.findings import Report
    from rcc_sim.trace import Trace

Model = Annotated[
    str,
    typer.Option(
        "--vehicle", help="The model: a name or file.", autocompletion=vehicle_names
    ),
]
Hide = Annotated[
    list[str] | None,
    typer.Option(
        help="Leave a logged column out; repeatable.",
        metavar="COLUMN",
        autocompletion=column_names,
    ),
]
Span = Annotated[
    str | None,
    typer.Option(
        help="Only these seconds of a log's own clock, as 20:80, 20: or :80; of each "
        "log but those held out.",
        metavar="FROM:TO",
    ),
]
Repeats = Annotated[
    list[str] | None,
    typer.Option(
        help="Another log of the same drive: how they scatter is the noise by which "
        "gap and causes are judged; repeatable.",
        metavar="LOG",
    ),
]
Reader = Annotated[
    str | None, typer.Option(help="Force a reader; the file tells otherwise.")
]
Map = Annotated[
    str | None,
    typer.Option(
        "--map",
        help="Column map: a TOML file or a shipped name.",
        autocompletion=map_names,
    ),
]
Plot = Annotated[
    Path | None, typer.Option(help="Draw it: PNG, SVG or PDF.", metavar="F")
]
Html = Annotated[
    Path | None, typer.Option(help="Write it as one HTML page.", metavar="F")
]


def trace_of(log: str, columns: str | None, vehicle: Vehicle | None = None) -> Trace:
    """Return the trace of a log of any format, at the rows of its speed.

    ``columns`` is its map; a vehicle's wheels may tell its speed.
    """
    from rcc_sim.readers import on_one_clock, read_log, with_vehicle

    reading = read_log(log, columns=columns)
    if vehicle is not None:
        reading = with_vehicle(reading, vehicle)
    trace = reading.trace
    return on_one_clock(trace) if "speed_mps" in trace else trace


def span_of(text: str | None) -> tuple[float, float]:
    """Return from when to when a log counts. [s]

    Raises
    ------
    InputError
        If the text is not FROM:TO, or ends before it begins.
    """
    ends = (text or ":").split(":")
    try:
        start, end = (
            float(x) if x.strip() else default
            for x, default in zip(ends, (-inf, inf), strict=True)
        )
    except ValueError:
        raise InputError(
            f"--span {text}: should be FROM:TO, in seconds", "as 20:80, 20: or :80"
        ) from None
    if not start < end:
        raise InputError(f"--span {text}: ends before it begins", "FROM is the less")
    return start, end


def once(names: Sequence[str]) -> None:
    """Raise if a log is given twice: it would count, or be judged, by itself."""
    seen = set()
    for name in names:
        path = Path(name).resolve()
        if name != "-" and path in seen:
            raise InputError(f"{name}: given twice", "each log counts once")
        seen.add(path)


def write_page(page: Report, path: Path) -> None:
    """Write a report as an HTML page, whole or not at all."""
    from rcc_sim.report.html import write_html

    with atomic(path) as file:
        write_html(page, file)
    say(f"wrote {path}")


def notes_of(findings: Iterable[Finding], notes: Iterable[str] = ()) -> list[str]:
    """Return what was found wrong with a log, what is none of ours, and other notes."""
    findings = list(findings)
    told = [
        f"{f.channel} {f.what}; {f.action}" for f in findings if f.severity != "info"
    ]
    unknown = [f for f in findings if f.kind == "unknown"]
    if unknown:
        names = ", ".join(f.channel for f in unknown)
        told.append(f"{names}: no column of rccsim's; {unknown[0].action}")
    return [*told, *notes]


def tell_notes(notes: Sequence[tuple[str, list[str]]]) -> None:
    """Say the notes of each log; of several by name, and what they share once."""
    logs: dict[str, list[str]] = {}
    for log, mine in notes:
        for note in mine:
            logs.setdefault(note, []).append(log)
    for note, named in logs.items():
        of = f"{named[0]}: "
        if len(named) > 1:
            some = "all" if len(named) == len(notes) else f"{len(named)} of"
            of = f"{some} {len(notes)} logs: "
        say(f"note: {of if len(notes) > 1 else ''}{note}")
