"""One vehicle's torque-speed envelope scaled onto another's motor."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from rcc_sim.errors import InputError, require_positive
from rcc_sim.similitude.demand import Demand
from rcc_sim.similitude.envelope import Bound, Envelope
from rcc_sim.similitude.scale import Scales

Array = NDArray[np.float64]
FINE = 2000  # 1; speeds at which two envelopes are held against each other


class Gap(NamedTuple):
    """A range of speeds where the scaled envelope reaches beyond the motor's.

    Attributes
    ----------
    from_radps, to_radps : float
        Shaft speed of the motor. [rad/s]
    asked_nm, limit_nm : float
        Where it reaches furthest beyond. [N m]
    by : str
        What sets the motor's limit there.
    """

    from_radps: float
    to_radps: float
    asked_nm: float
    limit_nm: float
    by: str


@dataclass(frozen=True)
class Overlay:
    """A scaled envelope, and how much of it the motor covers.

    Parameters
    ----------
    scaled : Envelope
        The other vehicle's, at the motor's size.
    torque_factor, speed_factor : float
        Shaft torque and speed of the motor over the other's. [1]
    share_inside : float
        Part of the scaled envelope's area that the motor covers. [1]
    leaves : tuple of Gap
        Where it does not.
    speed, asked, limit : ndarray
        Both envelopes over speed. [rad/s], [N m], [N m]
    drive : tuple of ndarray or None
        Speed [rad/s] and torque [N m] of a driven cycle, scaled.
    drive_inside : float or None
        Part of its time that the motor covers. [1]
    note : str
        What was assumed.
    """

    scaled: Envelope
    torque_factor: float
    speed_factor: float
    share_inside: float
    leaves: tuple[Gap, ...]
    speed: Array
    asked: Array
    limit: Array
    drive: tuple[Array, Array] | None
    drive_inside: float | None
    note: str

    def document(self) -> dict[str, Any]:
        """Return what ``--json`` prints of it."""
        drive = None
        if self.drive is not None:
            drive = {
                "speed_radps": self.drive[0].tolist(),
                "torque_nm": self.drive[1].tolist(),
                "share_of_time_inside": self.drive_inside,
            }
        every = slice(None, None, FINE // 100)
        return {
            "vehicle": self.scaled.vehicle,
            "torque_factor": self.torque_factor,
            "speed_factor": self.speed_factor,
            "share_inside": self.share_inside,
            "inside": not self.leaves,
            "leaves": [gap._asdict() for gap in self.leaves],
            "envelope": {
                "speed_radps": self.speed[every].tolist(),
                "asked_nm": self.asked[every].tolist(),
                "limit_nm": self.limit[every].tolist(),
            },
            "drive": drive,
            "note": self.note,
        }

    def lines(self) -> list[str]:
        """Return it in words."""
        name = self.scaled.vehicle
        lines = [
            f"{name} scaled on (torque × {self.torque_factor:.4g}, speed × "
            f"{self.speed_factor:.4g}): {100 * self.share_inside:.3g} % of its "
            "envelope is inside"
        ]
        lines += [
            f"leaves it from {g.from_radps:.4g} to {g.to_radps:.4g} rad/s: asks up to "
            f"{g.asked_nm:.3g} N m where {g.limit_nm:.3g} N m is there ({g.by})"
            for g in self.leaves
        ]
        if self.drive_inside is not None:
            share = 100 * self.drive_inside
            lines.append(f"the driven cycle is inside for {share:.3g} % of its time")
        return lines + ([f"note: {self.note}"] if self.note else [])


def overlay(
    own: Envelope,
    other: Envelope,
    scales: Scales,
    *,
    asked: Demand | None = None,
    top_speed: float | None = None,
) -> Overlay:
    """Return another vehicle's envelope on a motor's own.

    Parameters
    ----------
    own, other : Envelope
        Of the motor, and of the other vehicle at its own size.
    scales : Scales
        To the motor's vehicle from the other.
    asked : Demand, optional
        What the other vehicle's motor does over a cycle, at its own size.
    top_speed : float, optional
        Shaft speed of the other where its envelope has none. [rad/s]

    Raises
    ------
    InputError
        If nothing bounds the other's torque, or ``top_speed`` is not positive.
    """
    torque = scales.of("motor_torque").value
    speed = scales.of("motor_speed").value
    if not math.isfinite(other.torque.value):
        raise InputError(
            f"{other.vehicle}: motor.max_torque_nm: missing (its envelope needs it)"
        )
    note = ""
    if top_speed is not None:
        require_positive(top_speed=top_speed)
        other = other._replace(speed=Bound(top_speed, "--top-speed"))
    elif not math.isfinite(other.speed.value):
        same = own.speed.value / speed
        other = other._replace(speed=Bound(same, f"top speed of {own.vehicle}"))
        note = (
            f"{other.vehicle} states no motor.max_speed_radps: taken as far as "
            f"{own.vehicle} turns; --top-speed gives it"
        )
    scaled = other.scaled(torque, speed)
    grid = (np.arange(FINE) + 0.5) / FINE * scaled.speed.value
    wanted, has = scaled.torque_at(grid), own.torque_at(grid)
    drive = inside = None
    if asked is not None:
        drive = (asked.omega * speed, asked.tau * torque)
        within = drive[1] <= own.torque_at(drive[0]) * (1 + 1e-9)
        inside = float(asked.dt[within].sum() / asked.dt.sum())
    return Overlay(
        scaled=scaled,
        torque_factor=torque,
        speed_factor=speed,
        share_inside=float(np.minimum(wanted, has).sum() / wanted.sum()),
        leaves=_gaps(grid, wanted, has, own),
        speed=grid,
        asked=wanted,
        limit=has,
        drive=drive,
        drive_inside=inside,
        note=note,
    )


def _gaps(speed: Array, wanted: Array, has: Array, own: Envelope) -> tuple[Gap, ...]:
    beyond = np.concatenate(([False], wanted > has * (1 + 1e-9), [False]))
    edges = np.flatnonzero(beyond[1:] != beyond[:-1])
    gaps = []
    for start, stop in zip(edges[::2], edges[1::2], strict=True):
        at = start + int(np.argmax(wanted[start:stop] - has[start:stop]))
        by = _set_by(float(speed[at]), float(has[at]), own)
        gaps.append(
            Gap(
                from_radps=float(speed[start]),
                to_radps=float(speed[stop - 1]),
                asked_nm=float(wanted[at]),
                limit_nm=float(has[at]),
                by=by,
            )
        )
    return tuple(gaps)


def _set_by(speed: float, limit: float, own: Envelope) -> str:
    if speed > own.speed.value:
        return own.speed.by
    if limit >= own.torque.value * (1 - 1e-9):
        return own.torque.by
    if limit * speed >= own.power.value * (1 - 1e-9):
        return own.power.by
    return "battery voltage less R I"
