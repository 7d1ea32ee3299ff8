"""What a vehicle's file states of its sensors, column by column."""

from __future__ import annotations

from typing import Any

from rcc_sim.definitions.checks import checked, unknown_key
from rcc_sim.definitions.figure import Figure
from rcc_sim.definitions.tables import Sensor
from rcc_sim.errors import InputError
from rcc_sim.physics.effects import sensor_delay

DELAYED = {
    column: param.name
    for param, columns in zip(
        sensor_delay.EFFECT.params[1:], sensor_delay.CHANNELS, strict=True
    )
    for column in columns
}
"""Column -> the figure of ``sensor_delay`` that says how late its sensor is."""

POSE = ("x_m", "y_m", "yaw_rad", "elevation_m", "aux_power_w")
"""Columns that are measured as well, and whose delay is not modelled."""

ACCELEROMETERS = ("accel_x_mps2", "accel_y_mps2")
INERTIAL = ("yaw_rate_radps", *ACCELEROMETERS)
"""Columns of an inertial measurement unit: its gyro, its accelerometers."""

SCALES = {
    "motor_torque_nm": 0.03,
    "elevation_m": 0.1,
    **dict.fromkeys(INERTIAL, 0.015),
}
"""Share that a sensor may read too much, one sd: a torque that an inverter works out,
by the warm magnets and the saturation of a road car's motor; an altimeter, by the
warmth of the air under it, to which a barometer's climbs are in proportion, and by its
filter; gyro and accelerometers by their sensitivity, which data sheets of the usual
chips give to 1 to 3 %."""


def checked_sensors(raw: dict[str, Any], where: str) -> dict[str, Sensor]:
    """Return the sensors of a file, or raise with the first thing wrong in them."""
    found = {}
    for column, table in raw.items():
        at = f"sensors.{column}"
        if column not in (*DELAYED, *POSE):
            raise unknown_key(where, at, (*DELAYED, *POSE))
        sensor = found[column] = checked(Sensor, table, where, at)
        if sensor.scale_sd is not None and column not in SCALES:
            raise InputError(
                f"{where}: {at}.scale_sd: is read of {', '.join(SCALES)} alone",
                "a speed is off by tyres.radius_m, a current by current_sensor_scale",
            )
    return found


def delays_of(sensors: dict[str, Sensor], where: str) -> dict[str, Figure]:
    """Return what the sensors are late by, as figures of ``sensor_delay``.

    Raises
    ------
    InputError
        If a column's delay is not modelled or below what its sensor's may be, or two
        columns of one sensor differ.
    """
    found: dict[str, Figure] = {}
    first: dict[str, str] = {}
    for column, sensor in sensors.items():
        latency = sensor.latency_s
        if latency is None:
            continue
        at = f"{where}: sensors.{column}.latency_s"
        if column not in DELAYED:
            raise InputError(
                f"{at}: the delay of this column is not modelled",
                f"it is of {', '.join(DELAYED)}",
            )
        name = DELAYED[column]
        least = sensor_delay.EFFECT.param(name).bounds[0]
        most_early = latency.value if latency.low is None else latency.low
        if most_early < least:
            raise InputError(
                f"{at}: should be at least {least:g}: {most_early:g}",
                "a battery alone may be asked after the speed, and read less late",
            )
        if found.setdefault(name, latency).value != latency.value:
            raise InputError(
                f"{at}: {latency.value:g} s, and {found[name].value:g} s for "
                f"{first[name]}",
                "they come from one sensor; state its delay once",
            )
        first.setdefault(name, column)
    return found


def without_latencies(raw: dict[str, Any]) -> dict[str, Any]:
    """Return the tables of a file's sensors, none of them late."""
    return {
        column: {k: v for k, v in table.items() if k != "latency_s"}
        for column, table in raw.items()
    }
