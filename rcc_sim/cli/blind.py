"""`rccsim blind`: does the diagnosis deserve trust, where the effect is withheld."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from rcc_sim.cli.output import Csv, Json, emit, say

blind = typer.Typer(
    help="Data whose effect is withheld: make it, diagnose it, score that."
)


def register(app: typer.Typer) -> None:
    """Add the command and those under it to the app."""
    example = "Example: rccsim blind make cases --cases 20 --seed 1"
    app.add_typer(blind, name="blind", epilog=example)


@blind.command(
    epilog="Example: rccsim blind make cases --cases 20 --seed 1 --family rc --jobs 2"
)
def make(
    out: Annotated[Path, typer.Argument(help="Folder for the cases, new or empty.")],
    cases: Annotated[int, typer.Option(help="How many.")] = 20,
    seed: Annotated[int, typer.Option(help="Same seed, same bytes.", min=0)] = 0,
    kinds: Annotated[
        str, typer.Option(help="Of single, pair, null, unknown; by commas.")
    ] = "single,pair,null,unknown",
    family: Annotated[str, typer.Option(help="Of rc, ev; by commas.")] = "rc,ev",
    vehicle: Annotated[
        str | None, typer.Option(help="Draw around this vehicle instead.")
    ] = None,
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
        labels=labels,
        jobs=jobs,
    )
    say(f"wrote {len(seal.cases)} cases to {out}, labels to {seal.labels}")
    row = {"cases": len(seal.cases), "labels": str(seal.labels), "sha256": seal.sha256}
    emit(row, [row], json=json, csv=csv)
