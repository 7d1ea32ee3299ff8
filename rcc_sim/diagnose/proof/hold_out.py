"""Does the gap shrink on stretches of the logs that no fit saw?"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from rcc_sim.analyse.gap_energy import (
    energy_of,
    percent_of,
    row_weights,
    without_offsets,
)
from rcc_sim.analyse.gap_power import measured_power, power_of
from rcc_sim.diagnose.causes.cause import Cause
from rcc_sim.diagnose.fitting.engine import Engine
from rcc_sim.diagnose.fitting.fit import Fit
from rcc_sim.diagnose.fitting.knobs import figures_of, offsets_of, scale_key
from rcc_sim.diagnose.proof.folds import Mask, halves
from rcc_sim.diagnose.proof.shrink import Shrink, hold_out, kept_back
from rcc_sim.diagnose.residuals.posed import by_motion
from rcc_sim.diagnose.residuals.problem import Problem
from rcc_sim.diagnose.residuals.shapes import ALTIMETER, TORQUE
from rcc_sim.diagnose.residuals.terminals import BEYOND_SHAFT

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Proof:
    """What causes do for rows that no fit saw.

    Parameters
    ----------
    shrink : Shrink
        Of what is beyond noise, row by row.
    before, after : float or None
        Energy gap there with the nominal vehicle, and with the mended one. [%]
    by_torque : bool
        Whether both ran by a torque that was measured: where there is one, the drive is
        imposed, and no cause changes anything up to the motor's shaft.
    """

    shrink: Shrink
    before: float | None
    after: float | None
    by_torque: bool


def proof(
    acting: Engine,
    nominal: Engine,
    fit: Fit,
    null: Fit,
    holdouts: Sequence[Problem],
    level: Mapping[str, float],
    *,
    by_torque: bool,
) -> Proof:
    """Return what causes do for rows held out.

    These are other logs that were kept back, else each half of the logs in turn, but
    for the course of what varies, which all rows gave. On another log such a cause acts
    at its ``level``. ``null`` is the fit of stated figures alone.
    ``by_torque``: an imposed drive's power follows from the torque that was measured,
    else from its motion.
    """
    driven = partial(driven_by, by_torque=by_torque)
    was: list[tuple[dict[str, float], Sequence[Mask] | None]]
    now: list[tuple[dict[str, float], Sequence[Mask] | None]]
    if holdouts:
        other, values = Engine(holdouts), {**fit.values, **level}
        shrink = kept_back(other, values, null.values)
        stated = mended = driven(holdouts)
        was, now = [({}, None)], [(values, None)]
    else:
        fitted, tolerated = halves((acting, fit), (nominal, null))
        shrink = hold_out(acting, nominal, fit, fitted, tolerated)
        stated, mended = driven(nominal.problems), driven(acting.problems)
        either = [a | b for a, b in zip(*(rows for _, rows in fitted), strict=True)]
        was = [({}, either)]
        now = [(half.values, rows) for half, rows in fitted]
    before, after = energy_percent(stated, was), energy_percent(mended, now)
    return Proof(shrink, before, after, by_torque)


def driven_by(problems: Sequence[Problem], *, by_torque: bool) -> Sequence[Problem]:
    """Return drives whose power follows from the torque measured, or the motion."""
    return problems if by_torque else [by_motion(p) for p in problems]


def leave_shaft(causes: Sequence[Cause], tracks: Sequence[tuple[int, str]]) -> bool:
    """Tell whether causes change nothing up to the motor's shaft.

    What they do to the energy then shows best in a drive by its measured torque: what
    is unknown of road and air is in it.
    """
    shaft = [k for k, (_, channel) in enumerate(tracks) if channel not in BEYOND_SHAFT]
    return bool(causes) and not any(c.shares[shaft].any() for c in causes)


def energy_percent(
    problems: Sequence[Problem],
    fitted: Iterable[tuple[dict[str, float], Sequence[Mask] | None]],
) -> float | None:
    """Energy gap of free runs with these figures on rows that they did not see. [%]

    Of several logs the mean of their sizes, in percent of all their energy: what one
    takes too much is not what another takes too little. Meters have the offset that
    their log says, and a torque that was measured reads as much too much as it says; in
    one that no fit saw, as the first says. A road is as it was felt; in one that no fit
    saw, as it was logged.
    """
    sums = np.zeros((len(problems), 2))
    for figures, rows in fitted:
        for i, p in enumerate(problems):
            if rows is None:
                found = energies(as_metered(p, figures, 0), figures_of(figures))
            else:
                true, own = as_read(p, figures, i), figures_of(figures, i)
                found = energies(true, own, rows[i])
            if found is None:
                return None
            sums[i] += found
    if len(problems) == 1:
        return percent_of(*sums[0].tolist())
    measured, simulated = sums.T
    whole = float(measured.sum())
    return percent_of(whole, whole - float(np.abs(measured - simulated).sum()))


def energy_by_log(
    problems: Sequence[Problem], figures: dict[str, float]
) -> list[float | None]:
    """Energy gap of each log that was fitted, in a free run with these figures. [%]"""
    found: list[float | None] = []
    for i, p in enumerate(problems):
        both = energies(as_read(p, figures, i), figures_of(figures, i))
        found.append(percent_of(*both) if both else None)
    return found


def as_read(p: Problem, figures: Mapping[str, float], log: int) -> Problem:
    """Return a log that was fitted as it was: what its meters tell, and its road.

    By how much too much its altimeter was found to read.
    """
    true = as_metered(p, figures, log)
    return true.by_felt_road(figures.get(scale_key(log, ALTIMETER), 0.0))


def as_metered(p: Problem, figures: Mapping[str, float], log: int) -> Problem:
    """Return a log with what its meters tell as it was, power and torque.

    By the offsets, and the share of a torque, that one of the logs was found to have.
    """
    true = p.by_true_torque(figures.get(scale_key(log, TORQUE), 0.0))
    return replace(true, log=without_offsets(p.log, offsets_of(figures, log)))


def energies(
    p: Problem, figures: dict[str, float], rows: Mask | None = None
) -> tuple[float, float] | None:
    """Energy that a log measured, and that a vehicle takes on its drive. [J]

    At the battery, or where that was not measured at the motor's shaft.
    """
    at, power = measured_power(p.log, p.vehicle)
    if power is None:
        return None
    model = power_of(at, p.driven(figures))
    ok = np.isfinite(power) & np.isfinite(model)
    weights = row_times(p, ok)
    if rows is not None:
        weights = weights * rows
    return energy_of(power, weights), energy_of(model, weights)


def row_times(p: Problem, ok: Mask) -> Array:
    """Return the time that each row of a log stands for, if it is ``ok``. [s]"""
    if p.charge is not None:
        return np.diff(p.charge.time[p.charge.edges]) * ok
    return row_weights(p.log["time_s"], ok)
