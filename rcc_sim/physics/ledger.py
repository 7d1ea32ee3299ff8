"""The energy ledger: what it must add up to, and when it fails."""

import math
from collections.abc import Mapping

from rcc_sim.errors import LedgerError

CLOSES = 1e-6
"""Largest fraction of the energy throughput that a ledger may leave open."""

LEAST = 1e-3
"""Energy below which rounding is all there is. [J]"""


def left_open(
    name: str, given: float, sinks: Mapping[str, float], through: float
) -> float:
    """Return what a ledger leaves open, as a fraction of the energy throughput.

    Parameters
    ----------
    name : str
        The run, for the error.
    given : float
        Energy that the battery's cells gave. [J]
    sinks : mapping
        Line of the ledger -> energy that went there. [J]
    through : float
        Energy that passed through the battery, either way; a coasting vehicle has
        none, so that the energy booked counts where it is more. [J]

    Raises
    ------
    LedgerError
        If it is more than 1e-6: the run cannot be trusted.
    """
    booked = math.fsum(abs(energy) for energy in sinks.values())
    open_ = (given - math.fsum(sinks.values())) / max(through, booked, LEAST)
    if not abs(open_) <= CLOSES:
        raise LedgerError(
            f"{name}: the energy ledger does not close: {open_:.1e} of the "
            "throughput is unaccounted for",
            "a figure may be extreme, or rows or columns were lost on the way",
        )
    return open_
