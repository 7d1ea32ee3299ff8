"""What a vehicle cannot drive of a cycle, told before anyone simulates or drives it."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from rcc_sim.definitions.cycle import Cycle
from rcc_sim.definitions.figure import Figure
from rcc_sim.definitions.kernel import motor_torque_constant
from rcc_sim.definitions.vehicle import Vehicle
from rcc_sim.physics.effects.regeneration_limit import braking_limit
from rcc_sim.similitude.demand import Demand, demand
from rcc_sim.similitude.envelope import (
    Envelope,
    battery_power_limit,
    envelope_of,
    torque_limits,
)
from rcc_sim.similitude.quantities import KEYS
from rcc_sim.units import G

SLACK = 1e-9
"""Share by which a limit may be passed before it counts: rounding. [1]"""


class Limit(NamedTuple):
    """One limit of a vehicle against what a cycle asks.

    Attributes
    ----------
    what, unit : str
        What is limited, and the unit of ``limit`` and ``asked``.
    limit, asked : float or None
        Where the cycle goes furthest beyond it, or comes nearest.
    seconds : float
        How long the cycle asks for more. [s]
    note : str
        What sets the limit, or why it could not be checked.
    """

    what: str
    unit: str
    limit: float | None
    asked: float | None
    seconds: float
    note: str

    @property
    def exceeded(self) -> bool:
        """Whether the cycle asks for more than the vehicle has."""
        return self.seconds > 0

    def document(self) -> dict[str, Any]:
        """Return it as a row."""
        return self._asdict() | {"exceeded": self.exceeded}

    def line(self) -> str:
        """Return it in words."""
        return (
            f"{self.what}: the cycle asks {self.asked:.4g} {self.unit}, the limit is "
            f"{self.limit:.4g} {self.unit}, for {self.seconds:.3g} s ({self.note})"
        )


def drive_limits(vehicle: Vehicle, cycle: Cycle) -> list[Limit]:
    """Return every limit of a vehicle that a cycle, at its own size, may meet."""
    asked = demand(vehicle, cycle)
    envelope = envelope_of(vehicle)
    limits = [
        _top_speed(vehicle, cycle, asked, envelope),
        _torque(vehicle, asked, envelope),
        _battery(vehicle, asked),
        _grip(vehicle, asked),
        _braking(vehicle, asked),
        _dead_zone(vehicle, asked),
        *_sampling(vehicle, asked),
    ]
    return [limit for limit in limits if limit is not None]


def _top_speed(
    vehicle: Vehicle, cycle: Cycle, asked: Demand, envelope: Envelope
) -> Limit:
    if not math.isfinite(envelope.speed.value):
        return _unchecked("top speed", "m/s", "no motor speed, ERPM or voltage limit")
    top = np.maximum(cycle.speed_mps[1:], cycle.speed_mps[:-1])
    lever = vehicle.lever
    limit = np.full(top.shape, envelope.speed.value * lever)
    return _worst("top speed", "m/s", limit, top, asked.dt, envelope.speed.by)


def _torque(vehicle: Vehicle, asked: Demand, envelope: Envelope) -> Limit:
    if not math.isfinite(envelope.torque.value) and not math.isfinite(
        envelope.power.value
    ):
        return _unchecked("motor torque", "N m", "no torque, current or power limit")
    within = asked.omega <= envelope.speed.value  # beyond it: top speed says so
    most = envelope.torque_at(np.minimum(asked.omega, envelope.speed.value))
    tau = np.where(within, asked.tau, 0.0)
    note = envelope.torque.by
    K_t = motor_torque_constant(vehicle)
    if K_t:
        note += f"; {float(tau.max()) / K_t:.3g} A asked at most"
    peak = torque_limits(vehicle, peak=True)
    if "controller.peak_current_a" in peak:
        most_peak = envelope_of(vehicle, peak=True).torque_at(asked.omega)
        beyond = float(asked.dt[within & (tau > most_peak * (1 + SLACK))].sum())
        note += f"; beyond the peak current too for {beyond:.3g} s"
    return _worst("motor torque", "N m", most, tau, asked.dt, note)


def _battery(vehicle: Vehicle, asked: Demand) -> Limit:
    limit = battery_power_limit(vehicle)
    if not math.isfinite(limit):
        return _unchecked(
            "battery power", "W", "voltage, capacity or discharge rate not stated"
        )
    shaft = asked.tau * asked.omega
    most = np.full(shaft.shape, limit)
    return _worst("battery power", "W", most, shaft, asked.dt, "shaft power, no losses")


def _grip(vehicle: Vehicle, asked: Demand) -> Limit:
    figures = vehicle.figures()
    key = next((key for key in KEYS["mu"] if key in figures), None)
    if key is None:
        return _unchecked("grip", "m/s²", "friction coefficient not stated")
    body, axle = vehicle.body, vehicle.drivetrain.driven_axle
    share = 1.0
    if axle != "all":
        lever = body.cg_to_rear_axle_m if axle == "front" else body.cg_to_front_axle_m
        share = lever.value / vehicle.wheelbase
    used = np.abs(asked.F_x) / asked.m
    most = np.full(used.shape, figures[key].value * G * share)
    note = f"{key}, {axle} wheels driven, static load, straight on"
    return _worst("grip", "m/s²", most, used, asked.dt, note)


def _braking(vehicle: Vehicle, asked: Demand) -> Limit | None:
    if vehicle.mode != "speed":
        return None  # friction brakes do the rest
    if "regeneration_limit" not in vehicle.effects:
        return None
    stated = {
        key: figure.value
        for key, figure in vehicle.effects["regeneration_limit"].items()
        if isinstance(figure, Figure)
    }
    brake = braking_limit(
        stated.get("max_current_a", math.inf),
        stated.get("max_torque_nm", math.inf),
        motor_torque_constant(vehicle) or 0.0,
    )
    n = vehicle.rad_per_m
    most = asked.coast + brake * n / asked.m_eff
    slows = np.where(asked.a < 0, -asked.a, 0.0)
    note = (
        "coasting alone" if brake == 0 else f"coasting and {brake:.3g} N m of the motor"
    )
    return _worst(
        "braking", "m/s²", most, slows, asked.dt, f"{note}; it will overshoot"
    )


def _dead_zone(vehicle: Vehicle, asked: Demand) -> Limit:
    figure = vehicle.effects.get("speed_dead_zone", {}).get("threshold_radps")
    if not isinstance(figure, Figure):
        return _unchecked("dead zone", "m/s", "effects.speed_dead_zone not stated")
    lever = vehicle.lever
    limit = figure.value * lever
    creeping = (asked.v > 0) & (asked.v < limit)
    slowest = float(asked.v[creeping].min()) if creeping.any() else limit
    note = "speeds above 0 and below the limit command nothing"
    seconds = float(asked.dt[creeping].sum())
    return Limit("dead zone", "m/s", limit, slowest, seconds, note)


def _sampling(vehicle: Vehicle, asked: Demand) -> list[Limit]:
    rows = 1 / asked.dt
    found = []
    period = vehicle.effects.get("reference_sampling", {}).get("period_s")
    if isinstance(period, Figure) and period.value > 0:
        most = np.full(rows.shape, 1 / period.value)
        note = "rows that come faster than the reference is sampled are lost"
        found.append(_worst("reference rate", "Hz", most, rows, asked.dt, note))
    if vehicle.controller is not None and vehicle.controller.loop_rate_hz is not None:
        most = np.full(rows.shape, vehicle.controller.loop_rate_hz.value)
        note = "rows that come faster than the control loop runs are lost"
        found.append(_worst("loop rate", "Hz", most, rows, asked.dt, note))
    return found


def _worst(
    what: str,
    unit: str,
    limit: NDArray[np.float64],
    asked: NDArray[np.float64],
    dt: NDArray[np.float64],
    note: str,
) -> Limit:
    at = int(np.argmax(asked - limit))
    beyond = asked > limit * (1 + SLACK)
    seconds = float(dt[beyond].sum())
    return Limit(what, unit, float(limit[at]), float(asked[at]), seconds, note)


def _unchecked(what: str, unit: str, why: str) -> Limit:
    return Limit(what, unit, None, None, 0.0, f"not checked: {why}")
