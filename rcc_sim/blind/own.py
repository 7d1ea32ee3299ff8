"""A base to draw around, from a user's own vehicle file."""

from __future__ import annotations

from math import inf, isfinite, sqrt
from typing import TYPE_CHECKING

from rcc_sim.blind.bases import AIR, KEPT, Base
from rcc_sim.blind.plant import GRAVITY
from rcc_sim.errors import InputError

if TYPE_CHECKING:
    from rcc_sim.definitions.vehicle import Vehicle

WHY = "for drawing cases around this vehicle"
CAR_SPEED = 27.0  # m/s; top speed of a car's drives
TOP = 0.95  # 1; share of its motor's top speed
SAG = {"rc": (12.0, 3.78), "ev": (400.0, 2500.0)}  # V, kg; where resistances are usual
SCALED_SPEED = 5.3  # m/s; of a scaled car's, at SCALED_BASE
SCALED_BASE = 0.324  # m; wheelbase
PLAIN = {
    "drivetrain_damping.damping_nms_per_rad": "visc",
    "rotor_inertia.inertia_kgm2": "J",
    "copper_loss.phase_resistance_ohm": "R_phase",
    "rolling_resistance.coefficient": "C_rr",
    "aerodynamic_drag.drag_area_m2": "drag_area",
    "auxiliary_load.power_w": "P_aux",
    "battery_resistance.resistance_ohm": "R_i",
    "speed_dead_zone.threshold_radps": "dead_zone",
}
HANDLED = ("regeneration_limit", "reference_sampling", "road_load", "motor_efficiency")


def base_of(name: str) -> Base:
    """Return the base that a vehicle file describes.

    A road load is taken apart into damping, rolling resistance and drag; of a map of
    efficiency the median counts. Figures of ``KEPT`` are taken as exact.

    Raises
    ------
    InputError
        If a figure that the plant needs is missing, or an effect is not one that its
        nominal vehicles have.
    """
    from rcc_sim.definitions.vehicle import load_vehicle

    vehicle = load_vehicle(name)
    mode = vehicle.controller.mode if vehicle.controller else "none"
    if mode not in ("speed", "torque"):
        raise InputError(
            f"{vehicle.where}: controller.mode: should be speed or torque {WHY}: {mode}"
        )
    known = {key.partition(".")[0] for key in (*PLAIN, *KEPT)} | set(HANDLED)
    for effect in vehicle.effects:
        if effect not in known:
            raise InputError(
                f"{vehicle.where}: effects.{effect}: not one that `blind make` can "
                "draw around",
                f"it knows {', '.join(sorted(known))}",
            )
    return _base(vehicle, "rc" if mode == "speed" else "ev")


def _base(vehicle: Vehicle, family: str) -> Base:
    figures = vehicle.figures()

    def need(key: str) -> float:
        return vehicle.figure(key, WHY).value

    def maybe(key: str, otherwise: float) -> float:
        return figures[key].value if key in figures else otherwise

    m, r_w, N_d = (
        need("body.mass_kg"),
        need("tyres.radius_m"),
        need("drivetrain.gear_ratio"),
    )
    extra = {n: maybe(f"effects.{k}", 0.0) for k, n in PLAIN.items()}
    keeps = {
        key: figures[f"effects.{key}"].value
        for key in KEPT
        if f"effects.{key}" in figures
    }
    amps = maybe("effects.regeneration_limit.max_current_a", inf)
    limits = isfinite(amps) or "current_limit.max_current_a" in keeps
    poles, flux, K_t = 0, 0.0, 1.0
    if family == "rc" or extra["R_phase"] > 0 or limits:  # its current matters
        if vehicle.motor.poles is None:
            raise InputError(f"{vehicle.where}: motor.poles: missing ({WHY})")
        poles, flux = vehicle.motor.poles, need("motor.flux_linkage_wb")
        K_t = 1.5 * poles / 2 * flux
    if "motor_efficiency" in vehicle.effects:
        extra["loss"] = 1 - _efficiency(vehicle)
    if "road_load" in vehicle.effects:
        extra |= _road_load(figures_of(vehicle, "road_load"), m, N_d / r_w)
    torque = maybe("effects.regeneration_limit.max_torque_nm", inf)
    wheelbase = vehicle.wheelbase
    scaled = family == "rc"
    if scaled:
        loop = {
            "K_p": need("controller.proportional_gain_as_per_rad"),
            "K_i": need("controller.integral_gain_a_per_rad"),
            "i_max": need("controller.max_current_a"),
        }
    else:
        loop = {"tau_max": need("controller.max_torque_nm")}
    volts = maybe("battery.nominal_voltage_v", 0.0)
    u_0 = maybe("battery.open_circuit_voltage_v", volts)
    u_0 = u_0 or need("battery.open_circuit_voltage_v")
    volts_there, mass_there = SAG[family]
    fastest = min(CAR_SPEED, TOP * maybe("motor.max_speed_radps", inf) * r_w / N_d)
    return Base(
        name=vehicle.name,
        family=family,
        m=m,
        I_z=need("body.yaw_inertia_kgm2"),
        l_F=need("body.cg_to_front_axle_m"),
        l_R=need("body.cg_to_rear_axle_m"),
        C_F=need("tyres.front_cornering_stiffness_n_per_rad"),
        C_R=need("tyres.rear_cornering_stiffness_n_per_rad"),
        r_w=r_w,
        N_d=N_d,
        poles=poles,
        flux=flux,
        u_0=u_0,
        capacity=need("battery.capacity_ah"),
        v_max=SCALED_SPEED * sqrt(wheelbase / SCALED_BASE) if scaled else fastest,
        regen=min(amps * K_t, torque),
        sag=(u_0 / volts_there) ** 2 * mass_there / m,
        keeps=tuple(keeps.items()),
        **extra,
        **loop,
    )


def figures_of(vehicle: Vehicle, effect: str) -> dict[str, float]:
    """Return the values of an effect's figures."""
    start = f"effects.{effect}."
    return {
        key.removeprefix(start): figure.value
        for key, figure in vehicle.figures().items()
        if key.startswith(start)
    }


def _efficiency(vehicle: Vehicle) -> float:
    """Return what a motor makes of its power, as one figure. [1]"""
    import numpy as np

    from rcc_sim.definitions.kernel import efficiency_map

    scale = figures_of(vehicle, "motor_efficiency").get("scale", 1.0)
    return scale * float(np.median(efficiency_map(vehicle)[2]))


def _road_load(road: dict[str, float], m: float, n: float) -> dict[str, float]:
    """A + B v + C v² as rolling resistance, damping at the shaft, and drag."""
    return {
        "C_rr": max(road.get("a_n", 0.0), 0.0) / (m * GRAVITY),
        "visc": max(road.get("b_n_s_per_m", 0.0), 0.0) / n**2,
        "drag_area": max(road.get("c_n_s2_per_m2", 0.0), 0.0) / (0.5 * AIR),
    }
