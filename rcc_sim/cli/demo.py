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
    """UDDS at the RC car's scale, with and without lane changes: an energy report.

    Writes the scaled cycle, both traces and the plots into a folder, and prints the
    commands that do the same by hand.
    """
    from rcc_sim.report.demo import run_demo

    result = run_demo(folder, say)
    emit(None, result.rows, title=result.title)
    for path in result.files:
        say(f"wrote {path}")
