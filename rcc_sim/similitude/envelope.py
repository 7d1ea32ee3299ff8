"""What a vehicle's motor can give: torque, power and speed, and what sets each."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rcc_sim.definitions.kernel import motor_torque_constant, open_circuit_voltage
from rcc_sim.definitions.vehicle import Vehicle

RADPS_PER_RPM = 2 * math.pi / 60
"""One turn a minute. [rad/s]"""

UNLIMITED = "nothing stated"


class Bound(NamedTuple):
    """A limit, and which of the vehicle's figures sets it."""

    value: float
    by: str


class Envelope(NamedTuple):
    """The torque-speed region of a motor.

    Attributes
    ----------
    vehicle : str
        Whose.
    torque, power, speed : Bound
        At the shaft, inf where nothing is stated. [N m], [W], [rad/s]
    voltage_speed : float
        Speed at which the battery's voltage leaves nothing for torque. [rad/s]
    voltage_slope : float
        Torque that a rad/s below it allows; inf if the resistance is not stated.
        [N m s/rad]
    """

    vehicle: str
    torque: Bound
    power: Bound
    speed: Bound
    voltage_speed: float
    voltage_slope: float

    def torque_at(self, omega: ArrayLike) -> NDArray[np.float64]:
        r"""Return the most torque at shaft speeds [N m]; 0 beyond the top speed.

        .. math:: \tau \le \tau_{max},\quad P_{max}/\omega,\quad
            K_t K_e (\omega_0 - \omega) / R

        the last from V_q = R I_q + K_e ω; the inductance is left out, which at full
        current and speed flatters the motor a little.
        """
        w = np.asarray(omega, dtype=np.float64)
        most = np.full(w.shape, self.torque.value)
        if math.isfinite(self.power.value):
            most = np.minimum(most, self.power.value / np.maximum(w, 1e-12))
        if math.isfinite(self.voltage_speed) and math.isfinite(self.voltage_slope):
            headroom = np.maximum(self.voltage_speed - w, 0.0)
            most = np.minimum(most, self.voltage_slope * headroom)
        return np.where(w > self.speed.value, 0.0, most)

    def scaled(self, torque: float, speed: float) -> Envelope:
        """Return the envelope with shaft torque and speed multiplied."""
        return Envelope(
            self.vehicle,
            Bound(self.torque.value * torque, self.torque.by),
            Bound(self.power.value * torque * speed, self.power.by),
            Bound(self.speed.value * speed, self.speed.by),
            self.voltage_speed * speed,
            self.voltage_slope * torque / speed,
        )


def envelope_of(vehicle: Vehicle, *, peak: bool = False) -> Envelope:
    """Return the envelope of a vehicle's motor, controller and battery.

    Parameters
    ----------
    vehicle : Vehicle
        What it does not state does not limit it; rated torque stands in where no
        torque limit is stated.
    peak : bool
        Whether the controller's peak current counts in place of its steady one.
    """
    zero_torque = _voltage_speed(vehicle)
    speed = _least(speed_limits(vehicle))
    K_t = motor_torque_constant(vehicle)
    resistance = vehicle.figures().get("effects.copper_loss.phase_resistance_ohm")
    slope = math.inf
    if K_t and resistance and resistance.value > 0:
        K_e = K_t / 1.5  # V s/rad; N_p/2 λ
        slope = K_t * K_e / resistance.value
    return Envelope(
        vehicle=vehicle.name,
        torque=_least(torque_limits(vehicle, peak=peak)),
        power=_least(_stated(vehicle, {"motor.max_power_w": 1.0})),
        speed=speed,
        voltage_speed=zero_torque,
        voltage_slope=slope,
    )


def torque_limits(vehicle: Vehicle, *, peak: bool = False) -> dict[str, float]:
    """Return what limits the motor's torque, by the key that says so, in N m."""
    K_t = motor_torque_constant(vehicle)
    limits = _stated(
        vehicle, {"controller.max_torque_nm": 1.0, "motor.max_torque_nm": 1.0}
    )
    if K_t:
        current = "peak_current_a" if peak else "max_current_a"
        keys = (f"controller.{current}", "effects.current_limit.max_current_a")
        limits |= _stated(vehicle, dict.fromkeys(keys, K_t))
    return limits or _stated(vehicle, {"motor.rated_torque_nm": 1.0})


def speed_limits(vehicle: Vehicle) -> dict[str, float]:
    """Return what limits the shaft's speed, by the key that says so, in rad/s."""
    limits = _stated(vehicle, {"motor.max_speed_radps": 1.0})
    if vehicle.motor.poles:
        electrical = {"controller.max_electrical_speed_radps": 2 / vehicle.motor.poles}
        limits |= _stated(vehicle, electrical)
    voltage = _voltage_speed(vehicle)
    return limits | ({"battery voltage": voltage} if math.isfinite(voltage) else {})


def battery_power_limit(vehicle: Vehicle) -> float:
    """Return voltage × capacity × discharge rate [W]; inf where one is not stated."""
    battery, voltage = vehicle.battery, open_circuit_voltage(vehicle)
    rate, capacity = battery.max_discharge_rate_per_h, battery.capacity_ah
    if voltage is None or rate is None or capacity is None:
        return math.inf
    return voltage * capacity.value * rate.value


def _voltage_speed(vehicle: Vehicle) -> float:
    """Return the no-load speed of the battery's voltage [rad/s]; inf if unknown.

    From the flux linkage, as a run has it; without it from the motor's KV.
    """
    by_linkage = speed_by_linkage(vehicle)
    return by_linkage if math.isfinite(by_linkage) else speed_by_constant(vehicle)


def speed_by_constant(vehicle: Vehicle) -> float:
    """Return the no-load speed by the motor's KV [rad/s]; inf if unknown."""
    voltage, motor = open_circuit_voltage(vehicle), vehicle.motor
    if voltage is None or motor.velocity_constant_rpm_per_v is None:
        return math.inf
    return voltage * motor.velocity_constant_rpm_per_v.value * RADPS_PER_RPM


def speed_by_linkage(vehicle: Vehicle) -> float:
    r"""Return the no-load speed by the flux linkage [rad/s]; inf if unknown.

    .. math:: V/\sqrt 3 = N_p/2 \lambda \omega
    """
    voltage, motor = open_circuit_voltage(vehicle), vehicle.motor
    if voltage is None or motor.poles is None or motor.flux_linkage_wb is None:
        return math.inf
    return voltage / math.sqrt(3) / (motor.poles / 2 * motor.flux_linkage_wb.value)


def _stated(vehicle: Vehicle, keys: Mapping[str, float]) -> dict[str, float]:
    figures = vehicle.figures()
    return {k: figures[k].value * factor for k, factor in keys.items() if k in figures}


def _least(limits: Mapping[str, float]) -> Bound:
    if not limits:
        return Bound(math.inf, UNLIMITED)
    by = min(limits, key=limits.__getitem__)
    return Bound(limits[by], by)
