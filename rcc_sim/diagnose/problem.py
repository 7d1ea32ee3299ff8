"""One log and one vehicle: what the model says of each channel, for any parameters."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rcc_sim.definitions.vehicle import Vehicle
from rcc_sim.simulate.replay import Drive, drive_of, replay
from rcc_sim.trace import Trace

Array = NDArray[np.float64]

CHANNELS = (
    "speed_mps",
    "yaw_rate_radps",
    "accel_x_mps2",
    "accel_y_mps2",
    "motor_current_a",
    "motor_torque_nm",
    "battery_voltage_v",
    "battery_current_a",
    "battery_power_w",
)
RECALLS = (0.2, 1.0)


@dataclass(frozen=True)
class Problem:
    vehicle: Vehicle
    log: Trace
    drive: Drive

    @cached_property
    def channels(self) -> tuple[str, ...]:
        first = self.predict({})
        found = [c for c in CHANNELS if c in self.log and c in first]
        if self.drive.imposed and "speed_mps" in found:
            found.remove("speed_mps")
        if "battery_current_a" in found and "battery_power_w" in found:
            found.remove("battery_power_w")
        return tuple(found)

    def predict(self, values: dict[str, float]) -> dict[str, Array]:
        vehicle = (
            self.vehicle.changed(settings=dict(values)) if values else self.vehicle
        )
        return replay(vehicle, self.drive, RECALLS)

    def residual(self, values: dict[str, float]) -> Array:
        """(channels, n)."""
        out = self.predict(values)
        return np.stack([self.log[c] - out[c] for c in self.channels])

    @property
    def slow(self) -> float:
        """Speed below which the lateral model is not judged. [m/s]"""
        body, tyres = self.vehicle.body, self.vehicle.tyres
        C = tyres.front_cornering_stiffness_n_per_rad.value
        return (
            20 * 0.02 * float(np.sqrt(C * self.vehicle.wheelbase / body.mass_kg.value))
        )

    @cached_property
    def nominal(self) -> dict[str, Array]:
        """What the nominal model predicts."""
        return self.predict({})
