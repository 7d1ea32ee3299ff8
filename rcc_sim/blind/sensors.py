"""What the sensors make of a drive: noise, steps, small biases, lost rows."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
LOST = 0.002  # 1; share of rows that never arrive


@dataclass(frozen=True)
class Sensor:
    """One channel: its place in the plant's rows, and how it errs (SI)."""

    place: int
    noise: float
    step: float
    bias: float  # sd of a constant that no file states


SENSORS = {
    "rc": {
        "speed_mps": Sensor(0, 0.0026, 2.1e-4, 0.0),
        "yaw_rate_radps": Sensor(1, 0.0148, 1e-6, 0.003),
        "accel_x_mps2": Sensor(2, 0.25, 1e-6, 0.025),
        "accel_y_mps2": Sensor(3, 0.25, 1e-6, 0.025),
        "motor_current_a": Sensor(4, 0.26, 0.01, 0.01),
        "battery_voltage_v": Sensor(5, 0.015, 0.01, 0.001),
        "battery_current_a": Sensor(6, 0.06, 0.01, 0.004),
        "elevation_m": Sensor(7, 0.01, 0.001, 0.0),
    },
    "ev": {
        "speed_mps": Sensor(0, 0.0048, 9e-4, 0.0),
        "yaw_rate_radps": Sensor(1, 0.003, 1e-6, 0.001),
        "accel_x_mps2": Sensor(2, 0.083, 1e-6, 0.02),
        "accel_y_mps2": Sensor(3, 0.082, 1e-6, 0.02),
        "battery_voltage_v": Sensor(5, 0.3, 0.1, 0.02),
        "battery_current_a": Sensor(6, 0.5, 0.01, 0.05),
        "elevation_m": Sensor(7, 0.3, 0.001, 0.0),
    },
}


def constants(family: str, rng: np.random.Generator) -> dict[str, float]:
    """Return the constant bias of each channel of one car, in the channel's unit."""
    return {
        name: sensor.bias * float(rng.standard_normal())
        for name, sensor in SENSORS[family].items()
    }


def sensed(
    family: str, rows: Array, bias: dict[str, float], rng: np.random.Generator
) -> dict[str, Array]:
    """Return each channel as its sensor gives it: true value, bias, noise, in steps."""
    columns = {}
    for name, sensor in SENSORS[family].items():
        noise = sensor.noise * rng.standard_normal(len(rows))
        value = rows[:, sensor.place] + bias[name] + noise
        columns[name] = np.round(value / sensor.step) * sensor.step
    return columns


def arrived(n: int, rng: np.random.Generator) -> NDArray[np.bool_]:
    """Tell which of n rows arrived."""
    return rng.random(n) >= LOST
