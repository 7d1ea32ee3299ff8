"""What is judged of a battery: its voltage, its current, or the power of both."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rcc_sim.analyse.offsets import noise_at_rest
from rcc_sim.channel import (
    interval_of,
    moving_mean,
    rounded_to,
    rows_in,
    sensor_noise,
    spells,
)
from rcc_sim.definitions.vehicle import Vehicle
from rcc_sim.trace import Trace

Array = NDArray[np.float64]

VOLTAGE, CURRENT = "battery_voltage_v", "battery_current_a"
POWER = "battery_power_w"

BEYOND_SHAFT = (VOLTAGE, CURRENT, POWER)
"""Columns of what lies between the battery and the motor's shaft."""

RESISTANCE = "effects.battery_resistance.resistance_ohm"
"""What lies between a battery's terminals."""

STEADY = 1.0
"""Time over which a current's noise is evened out. [s]"""

MOMENT = 1.0
"""Time within which a voltage falls by the resistance, and recovers by little else. [s]
"""

PARTS, SHARP = 12, 0.2
"""Parts of a log of which one is left out in turn; and the largest share of the noise
in how a current changes, or of the error of what it tells, by which it tells it. [1]"""

NEAR = 3
"""Rows at either end of a stand at which a rounded voltage tells how long it is."""


def compared(found: list[str], vehicle: Vehicle, *, by_charge: bool) -> list[str]:
    """Return channels of a log without what is not judged of its battery.

    Power is judged in place of the current where the voltage is not known well enough
    to work with it, and the current in place of power where it is. A voltage that is
    not known is judged beside the current that flowed, and where a resistance could be
    found in it: what it does beside one that is stated, as the battery recovers and
    warms, no model here knows. ``by_charge``: the current is known from the charge
    alone.
    """
    known, power = knows_voltage(vehicle), POWER in found
    alone = CURRENT not in found or by_charge
    if not known and (alone or (power and RESISTANCE in vehicle.figures())):
        found = [c for c in found if c != VOLTAGE]
    if power and CURRENT in found:
        found = [c for c in found if c != (POWER if known else CURRENT)]
    return found


def knows_voltage(vehicle: Vehicle) -> bool:
    """Whether a battery's voltage is known well enough to work with it.

    An open-circuit voltage that is stated with an sd, or as a range, follows a charge
    that the model does not; power is then judged in place of the current, and the
    voltage beside its level and its fall with the charge, by the current that flowed.
    """
    stated = vehicle.battery.open_circuit_voltage_v
    return stated is not None and stated.tolerance == 0.0


def tells(voltage: Array) -> NDArray[np.bool_]:
    """Return the rows at which a rounded voltage tells something of its own.

    While it stands at a step all its readings err alike: those near either end count,
    and one between. All do where it is not rounded.
    """
    if not rounded_to(voltage):
        return np.ones(len(voltage), dtype=bool)
    first, end = spells(voltage)
    stand = np.repeat(np.arange(len(first)), end - first)
    row = np.arange(len(voltage))
    near = np.minimum(row - first[stand], end[stand] - 1 - row) < NEAR
    return np.asarray(near | (row == ((first + end) // 2)[stand]))


def flowed(beside: Array, metered: float, rows: int) -> Array:
    """Return what flowed beside the model's current, given what its meter read so. [A]

    The meter's own noise, which no voltage knows, is left out: a resistance would look
    smaller by it. What is slow, over so many ``rows``, is the model's error; of what is
    fast, the share ``metered`` is noise.
    """
    slow = moving_mean(beside, rows)
    return slow + (1 - metered) * np.nan_to_num(beside - slow)


def steady_rows(log: Trace) -> int:
    """Return the rows over which a current's mean has nothing fast left in it."""
    return rows_in(log["time_s"], STEADY)


def meter_noise(log: Trace) -> float:
    """Return the noise of the meter of a log's current. [A]

    As it scatters at rest; where the vehicle hardly ever stands, as what it reads bends
    from row to row, if that is less.
    """
    return min(noise_at_rest(log, CURRENT), sensor_noise(log[CURRENT]))


def metered(log: Trace, predicted: Array) -> float:
    r"""Share of what is fast in the current beside the model's, squared, that is noise.

    .. math:: \sigma^2 / \overline{(\Delta i - \bar{\Delta i})^2}

    with sigma the noise of its meter. (The model errs most where most flows: by how it
    usually errs the share would be several times as large.)
    """
    noise = meter_noise(log)
    beside = log[CURRENT] - predicted
    power = float(np.nanmean((beside - moving_mean(beside, steady_rows(log))) ** 2))
    return min(noise**2 / power, 1.0) if power > 0 else 0.0


def fall_per_ampere(log: Trace) -> tuple[float, float] | None:
    r"""Resistance that a battery shows within a moment, and its standard error. [Ω]

    .. math:: R = -\sum \Delta u \Delta i / (\sum \Delta i^2 - 2 n \sigma^2)

    over the ``MOMENT`` before each of n rows, sigma the noise of the current's meter;
    the error by leaving out a part of the log in turn (jackknife). None where the
    current hardly changes beside that noise, or parts of the log differ.
    """
    time, u, i = log["time_s"], log[VOLTAGE], log[CURRENT]
    lag = max(round(MOMENT / interval_of(time)), 1)
    if len(time) < PARTS * (lag + 1):
        return None
    du, di = u[lag:] - u[:-lag], i[lag:] - i[:-lag]
    whole = time[lag:] - time[:-lag] < 2 * lag * interval_of(time)
    kept = whole & np.isfinite(du) & np.isfinite(di)
    noise = 2 * meter_noise(log) ** 2
    falls, moves = (
        np.array([part.sum() for part in np.array_split(np.where(kept, x, 0.0), PARTS)])
        for x in (-du * di, di**2 - noise)
    )
    if moves.sum() <= 0 or noise * kept.sum() > SHARP * moves.sum():
        return None
    ohm = float(falls.sum() / moves.sum())
    less = (falls.sum() - falls) / (moves.sum() - moves)
    error = float(np.sqrt((PARTS - 1) * np.mean((less - less.mean()) ** 2)))
    return (ohm, error) if error < SHARP * ohm else None
