"""A motor's efficiency over torque and speed, and another vehicle's drive on it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rcc_sim.definitions.cycle import Cycle
from rcc_sim.definitions.figure import Figure
from rcc_sim.definitions.kernel import efficiency_map, motor_torque_constant
from rcc_sim.definitions.vehicle import Vehicle
from rcc_sim.errors import InputError
from rcc_sim.physics.effects.copper_loss import copper_power
from rcc_sim.physics.effects.motor_efficiency import map_efficiency
from rcc_sim.physics.powertrain import q_current
from rcc_sim.similitude.demand import demand, shaft_drag
from rcc_sim.similitude.envelope import Envelope, envelope_of
from rcc_sim.similitude.overlay import Overlay, overlay
from rcc_sim.similitude.scale import Scales

Array = NDArray[np.float64]

POINTS = 41
"""Torques and speeds of the grid unless said. [1]"""


@dataclass(frozen=True)
class MotorMap:
    """Efficiency over torque and speed.

    Parameters
    ----------
    vehicle : str
        Whose motor.
    made_of : str
        "loss terms", "measured map" or "constant efficiency".
    torque, speed : ndarray, shape (n,), (k,)
        Torque of the motor, its own drag in it, as ``motor_torque_nm`` of a run and
        as its limits hold [N m], and its speed [rad/s].
    efficiency : ndarray, shape (n, k)
        Power handed on over electrical power; NaN outside the envelope, and nil where
        the drag takes it all. [1]
    envelope : Envelope
        The motor's own.
    against : Overlay or None
        Another vehicle's envelope or drive, scaled onto it.
    """

    vehicle: str
    made_of: str
    torque: Array
    speed: Array
    efficiency: Array
    envelope: Envelope
    against: Overlay | None

    def rows(self) -> list[dict[str, float | None]]:
        """Return one row a point of the grid; no efficiency outside the envelope."""
        return [
            {
                "torque_nm": float(tau),
                "speed_radps": float(omega),
                "efficiency": float(eta) if math.isfinite(eta) else None,
            }
            for tau, line in zip(self.torque, self.efficiency, strict=True)
            for omega, eta in zip(self.speed, line, strict=True)
        ]

    def document(self) -> dict[str, Any]:
        """Return what ``--json`` prints."""
        limits = {
            "torque_nm": self.envelope.torque,
            "power_w": self.envelope.power,
            "speed_radps": self.envelope.speed,
        }
        return {
            "vehicle": self.vehicle,
            "made_of": self.made_of,
            "torque_nm": self.torque.tolist(),
            "speed_radps": self.speed.tolist(),
            "efficiency": self.efficiency.tolist(),
            "best_efficiency": float(np.nanmax(self.efficiency)),
            "envelope": {
                "torque_nm": self.envelope.torque_at(self.speed).tolist(),
                "limits": {
                    k: {"value": b.value, "by": b.by} for k, b in limits.items()
                },
            },
            "against": self.against.document() if self.against else None,
        }

    def lines(self) -> list[str]:
        """Return what a person should read beside the grid."""
        torque, speed = self.envelope.torque, self.envelope.speed
        best = float(np.nanmax(self.efficiency))
        lines = [
            f"{self.vehicle}: {self.made_of}; at best {best:.3g} within "
            f"{torque.value:.3g} N m ({torque.by}) and {speed.value:.4g} rad/s "
            f"({speed.by})"
        ]
        return lines + (self.against.lines() if self.against else [])


def motor_map(
    vehicle: Vehicle,
    against: Vehicle | None = None,
    *,
    cycle: Cycle | None = None,
    top_speed: float | None = None,
    points: int = POINTS,
) -> MotorMap:
    r"""Return a motor's efficiency map, with another vehicle's drive scaled onto it.

    .. math:: \eta = \frac{(\tau - \tau_{drag})\omega}{\tau\omega
        + \frac{3}{2} R (\tau/K_t)^2}

    with the drag of damping, friction and iron at the shaft; or the vehicle's measured
    map, or its constant efficiency.

    Parameters
    ----------
    vehicle : Vehicle
        Whose motor is mapped.
    against : Vehicle, optional
        Whose envelope is scaled onto it: torque as force × r_w/N_d of each vehicle,
        speed as speed × N_d/r_w.
    cycle : Cycle, optional
        As ``against`` drives it: its torque and speed are scaled on too.
    top_speed : float, optional
        Of ``against``, where its file states no motor speed. [m/s]
    points : int
        Torques, and speeds, of the grid.

    Raises
    ------
    InputError
        If the vehicle states no losses, or nothing bounds its torque or speed.
    """
    envelope = envelope_of(vehicle)
    for bound, what in ((envelope.torque, "torque"), (envelope.speed, "speed")):
        if not math.isfinite(bound.value):
            key = f"motor.max_{what}_{'nm' if what == 'torque' else 'radps'}"
            raise InputError(
                f"{vehicle.where}: {key}: missing (the map needs its {what} limit)",
                "state it; KV and battery voltage, or an ERPM limit, serve for speed",
            )
    torque = np.linspace(0.0, envelope.torque.value, points)
    speed = np.linspace(0.0, envelope.speed.value, points)
    eta, made_of = _efficiency(vehicle, torque, speed)
    outside = torque[:, None] > envelope.torque_at(speed)[None, :] * (1 + 1e-9)
    other = None
    if against is not None:
        asked = demand(against, cycle) if cycle is not None else None
        other = overlay(
            envelope,
            envelope_of(against),
            Scales.between(vehicle, against),
            asked=asked,
            top_speed=None if top_speed is None else top_speed * against.rad_per_m,
        )
    return MotorMap(
        vehicle.name,
        made_of,
        torque,
        speed,
        np.where(outside, math.nan, eta),
        envelope,
        other,
    )


def _efficiency(vehicle: Vehicle, torque: Array, speed: Array) -> tuple[Array, str]:
    params = vehicle.effects.get("motor_efficiency", {})
    scale = params.get("scale")
    factor = scale.value if isinstance(scale, Figure) else 1.0
    if "map" in params:
        table = efficiency_map(vehicle)
        eta = [[map_efficiency(t, w, factor, *table) for w in speed] for t in torque]
        return np.array(eta), "measured map"
    if params:
        return np.full((len(torque), len(speed)), factor), "constant efficiency"
    return efficiency_of_losses(vehicle, torque[:, None], speed[None, :]), "loss terms"


def efficiency_of_losses(vehicle: Vehicle, tau: Array, omega: Array) -> Array:
    """Return power handed on over electrical power of a motor, from its loss terms.

    Parameters
    ----------
    vehicle : Vehicle
        Must state poles, flux linkage and phase resistance.
    tau, omega : ndarray
        Torque of the motor, drag and all [N m], and its speed [rad/s]; broadcast.

    Returns
    -------
    efficiency : ndarray
        Nil where the drag takes it all. [1]

    Raises
    ------
    InputError
        If one of these figures is missing.
    """
    why = "the efficiency map needs it, or effects.motor_efficiency"
    R = vehicle.figure("effects.copper_loss.phase_resistance_ohm", why).value
    vehicle.figure("motor.flux_linkage_wb", why)
    K_t = motor_torque_constant(vehicle)
    if K_t is None:
        raise InputError(f"{vehicle.where}: motor.poles: missing ({why})")
    P_in = tau * omega + copper_power(q_current(tau, K_t), R)
    P_out = (tau - shaft_drag(vehicle, omega)) * omega
    some = (P_in > 0) & (P_out > 0)
    eta: Array = np.divide(P_out, P_in, out=np.zeros(P_in.shape), where=some)
    return eta
