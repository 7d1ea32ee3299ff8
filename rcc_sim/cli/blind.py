"""`rccsim blind`: does the diagnosis deserve trust, where the effect is withheld."""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path
from typing import Annotated

import typer

from rcc_sim.cli.output import Csv, Json, Output, Text, emit, say

blind = typer.Typer(
    help="Data whose effect is withheld: make it, diagnose it, score that."
)


def register(app: typer.Typer) -> None:
    """Add the command and those under it to the app."""
    example = "Example: rccsim blind make cases"
    app.add_typer(blind, name="blind", epilog=example)


def counter(of: int) -> Callable[[int], None]:
    """Return what shows a count on a terminal, and nothing elsewhere."""

    def show(done: int) -> None:
        if sys.stderr.isatty():
            sys.stderr.write(f"\r{done} of {of}" + ("\n" if done >= of else ""))
            sys.stderr.flush()

    return show


@blind.command(
    epilog="Example: rccsim blind make cases --cases 20 --seed 1 --family rc --jobs 2"
)
def make(
    out: Annotated[Path, typer.Argument(help="Folder for the cases, new or empty.")],
    cases: Annotated[int, typer.Option(help="How many.")] = 20,
    seed: Annotated[int, typer.Option(help="Same seed, same bytes.", min=0)] = 0,
    kinds: Annotated[
        str,
        typer.Option(
            help="Of single and pair (one effect, or two, withheld), null (none), "
            "unknown (one of no library); by commas."
        ),
    ] = "single,pair,null,unknown",
    family: Annotated[
        str, typer.Option(help="Of rc, ev; by commas. With --vehicle, its own.")
    ] = "rc,ev",
    vehicle: Annotated[
        str | None, typer.Option(help="Draw around this vehicle instead.")
    ] = None,
    effects: Annotated[
        str,
        typer.Option(
            help="One of these acts in each single and pair; by commas. "
            "friction_brake, regeneration_fade and reference_delay are drawn only so.",
        ),
    ] = "",
    repeats: Annotated[
        int,
        typer.Option(
            help="Times that each drive is driven again, as rough: `run` gives these "
            "logs to diagnose as --repeats.",
            min=0,
        ),
    ] = 0,
    labels: Annotated[
        Path | None, typer.Option(help="Default: OUT.labels.json.", metavar="F")
    ] = None,
    jobs: Annotated[int, typer.Option(help="Processes.", min=1)] = 1,
    json: Json = False,
    csv: Csv = False,
) -> None:
    """Draw vehicles and drives, write their logs, and seal what acts in them."""
    from rcc_sim.blind.make import make
    from rcc_sim.blind.own import base_of

    seal = make(
        out,
        cases=cases,
        seed=seed,
        kinds=kinds.split(","),
        families=family.split(","),
        base=base_of(vehicle) if vehicle else None,
        effects=effects.split(",") if effects else (),
        repeats=repeats,
        labels=labels,
        jobs=jobs,
        done=counter(cases),
    )
    count = "1 case" if len(seal.cases) == 1 else f"{len(seal.cases)} cases"
    say(f"wrote {count} to {out}, labels to {seal.labels}")
    row = {"cases": len(seal.cases), "labels": str(seal.labels), "sha256": seal.sha256}
    emit(row, [row], json=json, csv=csv)


@blind.command(epilog="Example: rccsim blind run cases --jobs 2")
def run(
    out: Annotated[Path, typer.Argument(help="Folder that `blind make` wrote.")],
    jobs: Annotated[
        int, typer.Option(help="Cases at a time; 0: one a core.", min=0)
    ] = 0,
    only: Annotated[
        str | None, typer.Option(help="These cases alone; by commas.")
    ] = None,
    again: Annotated[
        bool, typer.Option("--again", help="Also those that have a result.")
    ] = False,
    json: Json = False,
    csv: Csv = False,
) -> None:
    """Diagnose each case without its label; then its gap on a fresh drive.

    Goes on where it was interrupted. Times mean something with one job alone.
    """
    import os

    from rcc_sim.blind.run import run

    jobs = jobs or os.cpu_count() or 1
    wanted = only.split(",") if only else []
    rows = []
    try:
        for row in run(out, jobs=jobs, only=wanted, again=again):
            told = f"{row['status']} {row['causes']} {row['error']}".rstrip()
            say(f"{row['done']} of {row['of']}  {row['case']}: {told}")
            rows.append(row)
    except KeyboardInterrupt:
        say("the same command goes on with the cases that have no result yet")
        raise
    if not rows:
        say("every case has its result; --again diagnoses them anew")
    emit(rows, rows, json=json, csv=csv)


@blind.command(
    epilog="Example: rccsim blind score cases --labels cases.labels.json "
    "--require 'single_first>=0.95' --require 'null_false_alarm<=0.02'"
)
def score(
    out: Annotated[Path, typer.Argument(help="Folder of cases that were run.")],
    labels: Annotated[
        Path | None,
        typer.Option(help="The sealed labels. Default: OUT.labels.json.", metavar="F"),
    ] = None,
    require: Annotated[
        list[str] | None,
        typer.Option(help="KEY>=VALUE or KEY<=VALUE; repeatable.", metavar="BAR"),
    ] = None,
    json: Json = False,
    csv: Csv = False,
    text: Text = False,
    output: Output = None,
) -> None:
    """Open the labels and count: right, false alarms, unknowns, calibration, times."""
    from rcc_sim.blind.make import labels_beside
    from rcc_sim.blind.score import failures, score, table
    from rcc_sim.errors import CheckFailed

    document = score(out, labels or labels_beside(out))
    left = document["cases"] - document["run"]
    if left:
        say(f"note: {left} of {document['cases']} cases have no result yet")
    missed = failures(document, require or [])
    rows = table(document)
    emit(document, rows, json=json, csv=csv, text=text, output=output)
    if missed:
        raise CheckFailed(f"{out}: {'; '.join(missed)}")
