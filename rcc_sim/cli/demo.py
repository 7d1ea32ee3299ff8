"""`rccsim demo`: the main job, on built-in input."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from rcc_sim.cli.output import emit, say

EXAMPLE = "Example: rccsim demo --folder demo"


def register(app: typer.Typer) -> None:
    """Add the command to the app."""
    app.command("demo", epilog=EXAMPLE)(demo)


def demo(
    folder: Annotated[Path, typer.Option(help="Where to write.")] = Path("demo"),
) -> None:
    """Energy of UDDS at the RC car's scale, and a gap diagnosed, on built-in input.

    Drives with and without lane changes; then finds the effect that is missing from
    a vehicle file, by a log of a plant that is not the model, and holds it against
    the truth that was sealed. Prints the commands that do the same by hand; ends with
    the path of the report.
    """
    import os

    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # logs keep the cores busy
    from rcc_sim.report.demo import run_demo

    result = run_demo(folder, say)
    for path in result.files[:-1]:
        say(f"wrote {path}")
    emit(None, result.rows, title=result.title)
    say(f"wrote the report {result.files[-1]}")
