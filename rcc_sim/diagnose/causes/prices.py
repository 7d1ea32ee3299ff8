"""What each cause adds to the energy: the mended vehicle, cause by cause."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from rcc_sim.analyse.charge import Charge
from rcc_sim.analyse.gap_energy import energy_of, row_weights, without_offsets
from rcc_sim.analyse.gap_power import measured_power, power_of
from rcc_sim.diagnose.causes.profile import acted_on
from rcc_sim.diagnose.fitting.knobs import figures_of, offsets_of
from rcc_sim.diagnose.residuals.posed import by_motion
from rcc_sim.diagnose.residuals.problem import Problem
from rcc_sim.errors import InputError
from rcc_sim.units import J_PER_WH

if TYPE_CHECKING:
    from rcc_sim.diagnose.causes.cause import Cause

Array = NDArray[np.float64]

FIGURES = ""
"""Stands among the effects for the stated figures that the logs moved."""

ASTRAY = 100.0
"""Times all that a battery gave and took from which on a price is none: with a part of
what was found alone a vehicle may not hold the road."""


@dataclass(frozen=True)
class Prices:
    """The energy gap of a log, by what made it.

    Parameters
    ----------
    causes : dict
        Effect -> what it adds to the simulated energy. [Wh]
    figures_wh : float
        What the stated figures add that the logs moved. [Wh]
    unexplained_wh : float
        What is left of the gap. [Wh]
    meters_wh : float
        What was measured too much by the offsets that its meters were found to have.
        [Wh]
    drive_wh : float
        What is simulated more than for the gap because the drive is taken another way:
        on the road that was felt, or by its motion in place of its torque. [Wh]
    """

    causes: dict[str, float]
    figures_wh: float
    unexplained_wh: float
    meters_wh: float = 0.0
    drive_wh: float = 0.0


def prices(
    plain: Problem,
    causes: Sequence[Cause],
    values: Mapping[str, float],
    log: int = 0,
    charge: Charge | None = None,
    simulated: float | None = None,
) -> Prices | None:
    """Return what each cause adds to the energy of a drive.

    The model runs freely, the causes put in one after another and then the figures
    that moved, and again in the reverse order: what two of them cost together may be
    more than each alone. A price is the mean of both. All prices, the offsets of the
    meters and the remainder sum to the gap.

    Parameters
    ----------
    plain : Problem
        The log and the nominal vehicle, without any profile that was found.
    causes : sequence of Cause
        What is asserted.
    values : mapping
        Figures of the fit, dotted key -> value.
    log : int
        Which of the logs it is: a profile is that of this one.
    charge : Charge or None
        Stretches over which its power is known, and the model's is held likewise.
    simulated : float or None
        What the gap has the nominal vehicle take, where that may be another. [Wh]

    Returns
    -------
    Prices or None
        None where the log holds no energy, and where no vehicle could have the causes
        or the figures alone, or drive with them.
    """
    at, measured = measured_power(plain.log, plain.vehicle)
    read_right = without_offsets(plain.log, offsets_of(values, log))
    _, true = measured_power(read_right, plain.vehicle)
    if measured is None or true is None:
        return None
    plain = by_motion(plain)
    known = {c.effect: c for c in causes}

    def power(parts: Sequence[str]) -> Array:
        acting = [known[p] for p in parts if p != FIGURES]
        own = figures_of(values, log)
        figures = _figures(own, causes, acting, moved=FIGURES in parts)
        found = power_of(at, with_profiles(plain, acting, log).driven(figures))
        return found if charge is None else charge.at_rows(found)

    base = power(())
    ok = np.isfinite(measured) & np.isfinite(base)
    weights = row_weights(plain.drive.time, ok)

    def energy(parts: Sequence[str]) -> float:
        return energy_of(power(parts), weights) / J_PER_WH

    order = [*known, FIGURES]
    ends = energy_of(base, weights) / J_PER_WH, energy(order)
    steps = []
    for way in (order, order[::-1]):
        with suppress(InputError):
            steps.append(_steps(energy, way, ends))
    most = ASTRAY * energy_of(np.abs(measured), weights) / J_PER_WH
    steps = [s for s in steps if max(map(abs, s.values())) < most]
    if not steps:
        return None
    paid = {p: float(np.mean([s[p] for s in steps])) for p in order}
    figures = paid.pop(FIGURES)
    taken, spent = (energy_of(x, weights) / J_PER_WH for x in (measured, true))
    other = 0.0 if simulated is None else ends[0] - simulated
    return Prices(paid, figures, spent - ends[1], taken - spent, other)


def with_profiles(plain: Problem, causes: Sequence[Cause], log: int = 0) -> Problem:
    """Return a log's problem with the profiles of some causes on it."""
    found = plain
    for profile in (c.profiles[log] for c in causes if log in c.profiles):
        found = acted_on(found, profile)
    return found


def _figures(
    values: Mapping[str, float],
    causes: Sequence[Cause],
    acting: Sequence[Cause],
    *,
    moved: bool,
) -> dict[str, float]:
    """Return those of the acting causes, and of no cause where ``moved``."""
    own = {k for c in causes for k in c.keys}
    mine = {k for c in acting for k in c.keys}
    return {k: x for k, x in values.items() if k in mine or (moved and k not in own)}


def _steps(
    energy: Callable[[Sequence[str]], float],
    order: Sequence[str],
    ends: tuple[float, float],
) -> dict[str, float]:
    """Return what each part adds when it comes after those before it. [Wh]"""
    inner = [energy(order[: k + 1]) for k in range(len(order) - 1)]
    at = [ends[0], *inner, ends[1]]
    return dict(zip(order, np.diff(at).tolist(), strict=True))
