"""What a cycle asks of a vehicle: force at the road, torque and speed at the shaft."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from rcc_sim.definitions.cycle import Cycle
from rcc_sim.definitions.figure import Figure
from rcc_sim.definitions.vehicle import Vehicle
from rcc_sim.physics.effects import EFFECTS
from rcc_sim.physics.effects.aerodynamic_drag import drag_force
from rcc_sim.physics.effects.drivetrain_damping import damping_torque
from rcc_sim.physics.effects.drivetrain_friction import friction_torque
from rcc_sim.physics.effects.iron_loss import iron_torque
from rcc_sim.physics.effects.payload import loaded
from rcc_sim.physics.effects.road_load import road_load_force
from rcc_sim.physics.effects.rolling_resistance import rolling_force
from rcc_sim.physics.effects.rotor_inertia import reflected_mass
from rcc_sim.units import G

Array = NDArray[np.float64]


class Demand(NamedTuple):
    """One value for each step of a cycle, at its middle, on a level road.

    Attributes
    ----------
    dt, v, a : ndarray
        Length of the step [s], speed [m/s], acceleration [m/s²].
    omega, tau : ndarray
        Speed [rad/s] and torque [N m] of the motor shaft.
    F_x : ndarray
        Force that the tyres must pass on: inertia and road load. [N]
    coast : ndarray
        Deceleration of the vehicle left alone. [m/s²]
    m, m_eff : float
        Mass as loaded, and that which the wheels feel, turning parts included. [kg]
    """

    dt: Array
    v: Array
    a: Array
    omega: Array
    tau: Array
    F_x: Array
    coast: Array
    m: float
    m_eff: float


def demand(vehicle: Vehicle, cycle: Cycle) -> Demand:
    r"""Return what a cycle asks of a vehicle, without yaw or slope.

    .. math:: \tau = (m a + F_{road}) / (n \eta) + J n a + \tau_{drag},
        \quad n = N_d / r_w

    with η on the other side when braking. Effects that the vehicle does not state are
    neutral; the motor's electrical losses are no part of the torque.
    """
    dt = np.diff(cycle.time_s)
    v = (cycle.speed_mps[1:] + cycle.speed_mps[:-1]) / 2
    a = np.diff(cycle.speed_mps) / dt
    n = vehicle.rad_per_m
    m = vehicle.body.mass_kg.value
    m = loaded(m, m, _value(vehicle, "payload", "mass_kg"))
    J = _value(vehicle, "rotor_inertia", "inertia_kgm2")
    eta = _value(vehicle, "gear_loss", "efficiency")
    m_eff = m + reflected_mass(J, n)
    omega = n * v
    road, drag = _road(vehicle, v, m), shaft_drag(vehicle, omega)
    F_x = m * a + road
    through_gear = np.where(F_x >= 0, F_x / eta, F_x * eta) / n
    return Demand(
        dt=dt,
        v=v,
        a=a,
        omega=omega,
        tau=through_gear + J * n * a + drag,
        F_x=F_x,
        coast=(road + n * drag) / m_eff,
        m=m,
        m_eff=m_eff,
    )


def _road(vehicle: Vehicle, v: Array, m: float) -> Array:
    """Return road load of a level road [N]; none at standstill."""
    v_air = v + _value(vehicle, "headwind", "speed_mps")
    area = _value(vehicle, "aerodynamic_drag", "drag_area_m2")
    rho = _value(vehicle, "aerodynamic_drag", "air_density_kg_per_m3")
    names = ("a_n", "b_n_s_per_m", "c_n_s2_per_m2")
    a, b, c = (_value(vehicle, "road_load", name) for name in names)
    force = (
        rolling_force(m * G, _value(vehicle, "rolling_resistance", "coefficient"))
        + drag_force(v_air, area, rho)
        + road_load_force(v, v_air, a, b, c)
    )
    return np.where(v > 0, force, 0.0)


def shaft_drag(vehicle: Vehicle, omega: Array) -> Array:
    """Return drag torque at the motor shaft [N m]; none at standstill."""
    B = _value(vehicle, "drivetrain_damping", "damping_nms_per_rad")
    T_h = _value(vehicle, "iron_loss", "hysteresis_torque_nm")
    k_e = _value(vehicle, "iron_loss", "eddy_nms_per_rad")
    torque = (
        damping_torque(omega, B)
        + friction_torque(_value(vehicle, "drivetrain_friction", "torque_nm"))
        + iron_torque(omega, T_h, k_e)
    )
    return np.where(omega > 0, torque, 0.0)


def _value(vehicle: Vehicle, effect: str, param: str) -> float:
    figure = vehicle.effects.get(effect, {}).get(param)
    if isinstance(figure, Figure):
        return figure.value
    return EFFECTS[effect].neutral[param]
