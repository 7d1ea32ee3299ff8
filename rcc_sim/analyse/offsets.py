"""How far a sound sensor may be off throughout a log: an offset, a share."""

from __future__ import annotations

from math import inf

import numpy as np
from numpy.typing import NDArray

from rcc_sim.analyse.logcheck.rest import standing
from rcc_sim.definitions.sensors import SCALES
from rcc_sim.definitions.vehicle import Vehicle
from rcc_sim.physics.effects import EFFECTS
from rcc_sim.trace import Trace

Array = NDArray[np.float64]

OFFSETS = {
    name: EFFECTS[name].channels for name in ("accelerometer_bias", "yaw_rate_bias")
}
"""Effects that are the offset of a sensor, and its columns."""

ZEROED = 0.2
"""Offset of a sensor that is zeroed at rest, in times its noise. In 48 drives of cars
whose sensors have some, it is 0.03 of a current's noise, 0.1 of an acceleration's."""

AT_REST = ("battery", "motor_current", "motor_torque", "yaw_rate", "accel")
"""What the names of their columns begin with: meters of voltage and current, a torque
that is worked out from currents, gyros and accelerometers."""

OTHERS = 0.5
"""The same for any other sensor."""

WANDERS = {"yaw_rate_radps": 2e-3, "accel_x_mps2": 0.02, "accel_y_mps2": 0.02}
"""What warmth moves the zero of a zeroed sensor by, however little it is noisy: a tenth
of a degree per second, two thousandths of g. [unit of the column]"""

CREEPS = {"battery_current_a": 5e-4, "battery_power_w": 5e-4}
"""Share of its largest reading by which the zero of a meter of current is off, but for
no more than its noise; a guess, a quarter of an ampere of 500."""

METERS = "battery"
"""What the names of meters begin with, which read nothing but their noise while the car
stands: on the way they follow the drive from row to row."""

FEWEST_STILL = 20
"""Fewest rows at a standstill that show a meter's noise."""

CALM_PARTS = 30
"""Parts of a log of which the calmest tenth shows a sensor's noise."""


def offset_sd(log: Trace, vehicle: Vehicle, column: str) -> float:
    """Return the standard deviation of a sensor's offset. [unit of the column]

    As the vehicle's file states it, or else by the sensor's noise, stated or as the log
    shows it; 0 where it has none.
    """
    stated = vehicle.bias_sd(column)
    if stated is not None:
        return stated
    x = log[column]
    noise = vehicle.noise_sd(column)
    if noise is None:
        noise = min(calm_noise(x), noise_at_rest(log, column))
    if not noise:
        return 0.0
    share = ZEROED if column.startswith(AT_REST) else OTHERS
    creeps = CREEPS.get(column, 0.0) * float(np.nanmax(np.abs(x)))
    return max(share * noise, WANDERS.get(column, 0.0), min(creeps, noise))


def scale_sd(vehicle: Vehicle, column: str) -> float:
    """Return the share that a sensor may read too much, one standard deviation.

    As the vehicle's file states it, or else as is usual; 0 for one that has none.
    """
    sensor = vehicle.sensors.get(column)
    if sensor is not None and sensor.scale_sd is not None:
        return sensor.scale_sd.value
    return SCALES.get(column, 0.0)


def calm_noise(x: Array) -> float:
    """Return a sensor's noise, from its differences in the calmest tenth of a log."""
    d = np.diff(x[np.isfinite(x)])
    if len(d) < CALM_PARTS:
        return float(np.std(d) / np.sqrt(2)) if len(d) else 0.0
    parts = np.array_split(d, CALM_PARTS)
    sizes = [float(np.sqrt(np.mean((part - part.mean()) ** 2))) for part in parts]
    return float(np.quantile(sizes, 0.1) / np.sqrt(2))


def noise_of(steps: Array) -> float:
    """Return the noise of which some steps from row to row are, by their median."""
    return 1.4826 * float(np.nanmedian(np.abs(steps))) / 2**0.5


def noise_at_rest(log: Trace, column: str) -> float:
    """Return a meter's noise while the car stands; infinite if it hardly ever does.

    Of other sensors rest tells nothing: a torque is nil, and nothing shakes. From
    differences of neighbouring rows, by their median, which what switches in between
    leaves alone; a third of the resolution of a quantised signal at least.
    """
    if not column.startswith(METERS):
        return inf
    still = standing(log["time_s"], log.columns)
    steps = np.abs(np.diff(log[column]))
    steps = steps[still[1:] & still[:-1] & np.isfinite(steps)]
    if len(steps) < FEWEST_STILL:
        return inf
    noise = noise_of(steps)
    moved = steps[steps > 0]
    return max(noise, float(moved.min()) / 3) if len(moved) else noise
