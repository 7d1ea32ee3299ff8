"""Options that commands over many runs share, and what they tell while at it."""

from __future__ import annotations

import sys
import time
from typing import TYPE_CHECKING, Annotated

import typer

from rcc_sim.cli.output import say, warn

if TYPE_CHECKING:
    from rcc_sim.batch.batch import Progress

Jobs = Annotated[
    int, typer.Option("--jobs", "-j", help="Processes of this machine.", min=1)
]
Dask = Annotated[
    str | None,
    typer.Option(
        "--dask", metavar="ADDRESS", help="Work on this Dask scheduler's workers."
    ),
]
Draws = Annotated[
    int | None,
    typer.Option(
        "--draws",
        metavar="N",
        min=2,
        help="Give 90 % intervals from N draws of the file's sds and ranges.",
    ),
]
Method = Annotated[
    str, typer.Option("--method", help="How to draw: lhs, sobol or random.")
]
Seed = Annotated[int, typer.Option("--seed", help="Of the draws.", min=0)]

EVERY_S = 0.2
"""How often the line of progress changes. [s]"""

SHOWN = 5
"""Kinds of failure that the summary names."""


class ProgressLine:
    """A line on the terminal that says how far it is; nothing where none looks on."""

    def __init__(self, what: str) -> None:
        self.what = what
        self.last = 0.0
        self.shown = False

    def __call__(self, progress: Progress) -> None:
        """Change the line, now and then."""
        now = time.monotonic()
        if not sys.stderr.isatty() or now - self.last < EVERY_S:
            return
        self.last, self.shown = now, True
        failed = f", {progress.failed:,} failed" if progress.failed else ""
        sys.stderr.write(
            f"\r{progress.done:,} of {progress.total:,} {self.what}{failed}, "
            f"{progress.rate:,.4g} a second, {_words(progress.left_s)} left\x1b[K"
        )
        sys.stderr.flush()

    def end(self) -> None:
        """Leave the line."""
        if self.shown:
            sys.stderr.write("\r\x1b[K")


def tell_failures(progress: Progress, what: str) -> None:
    """Say which runs failed, and of what, the most frequent first."""
    if not progress.failed:
        return
    warn(f"{progress.failed:,} of {progress.total:,} {what} failed")
    kinds = progress.failures.most_common()
    for error, count in kinds[:SHOWN]:
        say(f"  {count:,} (first: {progress.first[error]}): {error}")
    rest = sum(count for _, count in kinds[SHOWN:])
    if rest:
        say(f"  {rest:,} of {len(kinds) - SHOWN:,} other kinds")


def _words(seconds: float) -> str:
    if seconds < 90:
        return f"{seconds:.0f} s"
    if seconds < 5400:
        return f"{seconds / 60:.0f} min"
    return f"{seconds / 3600:.1f} h"
