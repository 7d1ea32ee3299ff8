"""What a report shows: the one structure that every command fills in."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from rcc_sim.analyse.energy import EnergyReport
from rcc_sim.analyse.logcheck.finding import Finding
from rcc_sim.trace import Trace

if TYPE_CHECKING:
    from rcc_sim.diagnose.causes.prices import Prices
    from rcc_sim.diagnose.signatures import Signatures

Columns = Mapping[str, NDArray[np.float64]]


@dataclass(frozen=True)
class Span:
    """A stretch of the log with a name, on the log's own clock. [s]"""

    start_s: float
    end_s: float
    name: str


@dataclass(frozen=True)
class Report:
    """Everything that the HTML report may show; what is empty is left out.

    Parameters
    ----------
    title : str
        Heading of the page.
    verdict : str
        One sentence with its figures; made from ``diagnosis`` where it is empty.
    diagnosis : dict
        The object that ``diagnose --json`` prints, or a part: ``gap`` has ``where``.
    measured : Trace or None
        The log.
    which : str
        Which of several logs that is; empty where there is one.
    before, after : dict of ndarray, each as long as the log
        Column -> what was simulated at the log's rows, with the vehicle as it was and
        as mended. NaN where nothing was simulated.
    runs : tuple of Trace
        Drives laid over each other where there is no measurement; each its own clock.
    energy : tuple of EnergyReport
        Ledgers to show beside each other.
    regimes : tuple of Span
        Kinds of driving, shaded.
    prices : Prices or None
        What each cause adds to the energy: the steps of the waterfall.
    signatures : Signatures or None
        What the winner and its rivals would change in each channel.
    log_check : tuple of Finding
        What `check` says of the log.
    vehicle_diff : str
        Unified diff of the vehicle file.
    profiles : Trace or None
        Causes that vary over the drive, ``effect.parameter`` over time.
    run : dict
        What was run (`provenance.run_record`), so that it can be run again.
    """

    title: str
    verdict: str = ""
    diagnosis: Mapping[str, Any] = field(default_factory=dict)
    measured: Trace | None = None
    which: str = ""
    before: Columns = field(default_factory=dict)
    after: Columns = field(default_factory=dict)
    runs: tuple[Trace, ...] = ()
    energy: tuple[EnergyReport, ...] = ()
    regimes: tuple[Span, ...] = ()
    prices: Prices | None = None
    signatures: Signatures | None = None
    log_check: tuple[Finding, ...] = ()
    vehicle_diff: str = ""
    profiles: Trace | None = None
    run: Mapping[str, Any] = field(default_factory=dict)


PARTS = 1000
"""Parts of a drive that a page has room to shade."""


def spans_of(
    time: NDArray[np.float64], kinds: NDArray[np.intp], names: Sequence[str]
) -> tuple[Span, ...]:
    """Return stretches of one kind; where some are too short to see, ``PARTS`` at most.

    Each part is then of the kind in its middle: the shares stay right.

    Parameters
    ----------
    time : ndarray, shape (n,)
        Rows of the log. [s]
    kinds : ndarray of int, shape (n,) or (n - 1,)
        Which of ``names`` each row, or each step to the next, is; -1 is the last.
    """
    if len(time) < 2:
        return ()
    kinds = kinds[: len(time) - 1] % len(names)
    edges = _edges(kinds)
    if np.diff(time[edges]).min() < (time[-1] - time[0]) / PARTS:
        time, kinds = _sampled(time, kinds)
        edges = _edges(kinds)
    return tuple(
        Span(float(time[a]), float(time[b]), names[int(kinds[a])].replace("_", " "))
        for a, b in pairwise(edges)
    )


def _edges(kinds: NDArray[np.intp]) -> NDArray[np.intp]:
    """Return where each stretch of one kind starts, and where the last ends."""
    return np.concatenate([[0], np.flatnonzero(np.diff(kinds)) + 1, [len(kinds)]])


def _sampled(
    time: NDArray[np.float64], kinds: NDArray[np.intp]
) -> tuple[NDArray[np.float64], NDArray[np.intp]]:
    """Return the edges of ``PARTS`` parts, and the kind in the middle of each."""
    edges = np.linspace(time[0], time[-1], PARTS + 1)
    middle = 0.5 * (edges[1:] + edges[:-1])
    return edges, kinds[np.searchsorted(time, middle, side="right") - 1]
