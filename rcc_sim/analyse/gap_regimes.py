"""Kinds of driving, told apart by the vehicle's own scale of time and speed."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rcc_sim.channel import moving_mean, rows_in
from rcc_sim.definitions.kernel import answering_time
from rcc_sim.definitions.vehicle import Vehicle
from rcc_sim.physics.step import SLIP_BLEND
from rcc_sim.units import J_PER_WH

Array = NDArray[np.float64]
Labels = NDArray[np.intp]

REGIMES = (
    *("standstill", "launch", "acceleration", "cruise", "coast", "braking"),
    *("corner_entry", "corner_mid", "corner_exit"),
)

STANDS = 0.02
"""Speed, of the vehicle's own, below which it stands. [1]"""

HELD = ("motor_torque_nm", "motor_current_a")
"""Columns that a motion tells nothing of while the vehicle stands: a motor that creeps
against the brakes or holds the car on a hill is not seen to do so."""

LAUNCHES = 0.3
"""Speed, of the vehicle's own, up to which an acceleration is a launch. [1]"""

STEADY = 0.02
"""Acceleration, of the vehicle's own, below which it cruises. [1]"""

SLOW = 5.0
"""Speed below which cornering is not judged, in times that at which slip blends: there
the model's slip angles are 2 % too small, 1 - 1 / sqrt(1 + 1 / 5^2). [1]"""

CORNERS = 0.04
"""Lateral acceleration, of the vehicle's own, above which it corners. [1]"""

TURNS_IN = 0.01
"""Change of the lateral acceleration, of the vehicle's own, of entry and exit. [1]"""

IDLE = 0.05
"""Share of the drive's largest torque below which the motor neither drives nor
brakes. [1]"""


@dataclass(frozen=True)
class Scale:
    r"""A vehicle's own units, from its mass, wheelbase and front tyres.

    .. math:: t = \sqrt{m l / C_F}, \quad v = l / t, \quad a = l / t^2
    """

    time: float
    speed: float
    accel: float

    @classmethod
    def of(cls, vehicle: Vehicle) -> Scale:
        """Return the scale of a vehicle. [s], [m/s], [m/s²]"""
        l, t = vehicle.wheelbase, answering_time(vehicle)
        return cls(t, l / t, l / t**2)

    @property
    def slow(self) -> float:
        """Speed below which cornering is not judged. [m/s]"""
        return SLOW * SLIP_BLEND * self.speed


@dataclass(frozen=True)
class RegimeGap:
    """What one kind of driving has of the gap, and its standard uncertainty."""

    regime: str
    time_s: float
    gap_wh: float | None
    share: float | None
    u_val_wh: float | None = None


def stands(speed: Array, scale: Scale) -> NDArray[np.bool_]:
    """Return the rows at which the vehicle stands."""
    return np.asarray(speed < STANDS * scale.speed)


def labels(
    time: Array, speed: Array, yaw_rate: Array, torque: Array, scale: Scale
) -> Labels:
    """Return the place in :data:`REGIMES` of what the vehicle does at each row.

    Parameters
    ----------
    time, speed, yaw_rate, torque : ndarray, shape (n,)
        Of the drive, measured or simulated; the motor's torque tells coasting from
        braking. [s], [m/s], [rad/s], [N m]
    scale : Scale
        The vehicle's own time, speed and acceleration.
    """
    rows = rows_in(time, scale.time)
    v = moving_mean(speed, rows)
    a = moving_mean(np.gradient(v, time), rows)
    sideways = moving_mean(v * moving_mean(yaw_rate, rows), rows)
    turning = moving_mean(np.gradient(np.abs(sideways), time), rows)
    tau = moving_mean(torque, rows)
    slow = STEADY * scale.accel
    gentle = TURNS_IN * scale.accel / scale.time
    corners = (np.abs(sideways) > CORNERS * scale.accel) & (
        np.abs(sideways) > np.abs(a)
    )
    idle = np.abs(tau) <= IDLE * max(float(np.max(np.abs(tau))), 1e-12)
    kinds = (
        stands(v, scale) & (np.abs(a) < slow),
        corners & (turning > gentle),
        corners & (turning < -gentle),
        corners,
        (a > slow) & (v < LAUNCHES * scale.speed),
        a > slow,
        (a < 0) & idle,
        a < -slow,
    )
    names = (
        *("standstill", "corner_entry", "corner_exit", "corner_mid"),
        *("launch", "acceleration", "coast", "braking"),
    )
    places = [REGIMES.index(name) for name in names]
    return np.select(kinds, places, REGIMES.index("cruise")).astype(np.intp)


def regime_gaps(
    kinds: Labels, time: Array, gap: Array | None, weights: Array, doubts: Array
) -> list[RegimeGap]:
    """Return time and energy gap of each kind of driving that occurs.

    ``share`` is of the sum of all sizes, so that kinds that cancel do not hide;
    ``doubts`` holds the standard uncertainty of each kind. [Wh]
    """
    spans = np.gradient(time)
    lasts = np.bincount(kinds, spans, len(REGIMES))
    if gap is None:
        return [
            RegimeGap(name, float(lasts[k]), None, None)
            for k, name in enumerate(REGIMES)
            if lasts[k] > 0
        ]
    joules = np.bincount(kinds, np.where(weights > 0, gap, 0) * weights, len(REGIMES))
    total = float(np.abs(joules).sum()) or 1.0
    return [
        RegimeGap(
            name,
            float(lasts[k]),
            float(joules[k]) / J_PER_WH,
            float(joules[k]) / total,
            float(doubts[k]),
        )
        for k, name in enumerate(REGIMES)
        if lasts[k] > 0
    ]
