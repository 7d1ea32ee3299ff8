"""Options that commands over many runs share, and what they tell while at it."""

from __future__ import annotations

import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from rcc_sim.cli.complete import cycle_names, vehicle_names
from rcc_sim.cli.output import say, warn

if TYPE_CHECKING:
    from rcc_sim.batch.batch import Progress
    from rcc_sim.simulate.run import LaneChanges

Vehicle = Annotated[
    str, typer.Argument(help="Name or file.", autocompletion=vehicle_names)
]
CYCLE = typer.Option(
    "--cycle",
    help="Name, file, slice as udds[20:125], or - for stdin.",
    autocompletion=cycle_names,
)
Cycle = Annotated[str, CYCLE]
Imposed = Annotated[
    bool,
    typer.Option("--imposed", help="Take the cycle's speed as it is, at its own step."),
]
LaneEvery = Annotated[
    float | None, typer.Option(help="Distance between lane changes. [m]")
]
LaneWidth = Annotated[float | None, typer.Option(help="Default: one wheelbase. [m]")]
LaneLength = Annotated[
    float | None,
    typer.Option(help="Distance of one change; default: 20 wheelbases. [m]"),
]

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


def lanes_of(
    every: float | None, width: float | None, length: float | None
) -> LaneChanges | None:
    """Return the lane changes that options state; None where there are none.

    Raises
    ------
    InputError
        If a size is stated without a distance between them.
    """
    from rcc_sim.errors import InputError
    from rcc_sim.simulate.run import LaneChanges

    if every is None:
        if width is not None or length is not None:
            raise InputError(
                "--lane-width and --lane-change-length need --lane-change-every"
            )
        return None
    return LaneChanges(every, width, length)


def tell_failures(progress: Progress, what: str) -> None:
    """Say which runs failed, and of what, the most frequent first."""
    if not progress.failed:
        return
    warn(f"{progress.failed:,} of {progress.total:,} {what} failed")
    kinds = progress.failures.most_common()
    for error, count in kinds[:SHOWN]:
        first = progress.log[error] or progress.first[error]
        say(f"  {count:,} (first: {first}): {error}")
    rest = sum(count for _, count in kinds[SHOWN:])
    if rest:
        say(f"  {rest:,} of {len(kinds) - SHOWN:,} other kinds")


def _words(seconds: float) -> str:
    if seconds < 90:
        return f"{seconds:.0f} s"
    if seconds < 5400:
        return f"{seconds / 60:.0f} min"
    return f"{seconds / 3600:.1f} h"


@contextmanager
def going_on(output: Path | None) -> Iterator[None]:
    """Say of a batch that is interrupted that the same command goes on."""
    try:
        yield
    except KeyboardInterrupt:
        if output is not None:
            say(f"{output}: what is done is kept; the same command goes on")
        raise
