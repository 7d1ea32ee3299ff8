"""The vehicle file that a user would have: figures off, effects missing."""

from __future__ import annotations

from collections.abc import Collection
from math import isfinite

from rcc_sim.blind.bases import KEPT, TOLERANCES, Base


def _figure(key: str, value: float, name: str = "") -> str:
    if not name:
        return f"{key} = {value:.6g}"
    sd = TOLERANCES[name] * value
    return f"{key} = {{ value = {value:.6g}, sd = {sd:.6g} }}"


def vehicle_text(name: str, file: Base, hidden: Collection[str]) -> str:
    """Return the TOML of a nominal vehicle; ``hidden`` figures are left out."""
    tables = {
        "vehicle": [f'name = "{name}"', f'title = "nominal model of case {name}"'],
        "body": [
            _figure("mass_kg", file.m, "m"),
            _figure("yaw_inertia_kgm2", file.I_z, "I_z"),
            _figure("cg_to_front_axle_m", file.l_F, "l_F"),
            _figure("cg_to_rear_axle_m", file.l_R, "l_R"),
        ],
        "tyres": [
            _figure("radius_m", file.r_w, "r_w"),
            _figure("front_cornering_stiffness_n_per_rad", file.C_F, "C_F"),
            _figure("rear_cornering_stiffness_n_per_rad", file.C_R, "C_R"),
        ],
        "drivetrain": [_figure("gear_ratio", file.N_d)],
        "motor": [
            f"poles = {file.poles}",
            _figure("flux_linkage_wb", file.flux, "flux"),
        ],
        "battery": [
            _figure("open_circuit_voltage_v", file.u_0),
            _figure("capacity_ah", file.capacity),
        ],
        "controller": _controller(file),
    }
    if not file.poles:
        del tables["motor"]
    for effect, lines in _effects(file, hidden).items():
        tables[f"effects.{effect}"] = lines
    return "\n\n".join("\n".join([f"[{k}]", *v]) for k, v in tables.items()) + "\n"


def _controller(file: Base) -> list[str]:
    if file.family == "ev":
        return ['mode = "torque"', _figure("max_torque_nm", file.tau_max)]
    return [
        'mode = "speed"',
        _figure("proportional_gain_as_per_rad", file.K_p),
        _figure("integral_gain_a_per_rad", file.K_i),
        _figure("max_current_a", file.i_max),
        "loop_rate_hz = 1000",
    ]


def _effects(file: Base, hidden: Collection[str]) -> dict[str, list[str]]:
    """Return the lines of each effect that the car has and the file states."""
    known = {
        "drivetrain_damping": ("damping_nms_per_rad", "visc"),
        "rotor_inertia": ("inertia_kgm2", "J"),
        "copper_loss": ("phase_resistance_ohm", "R_phase"),
        "rolling_resistance": ("coefficient", "C_rr"),
        "aerodynamic_drag": ("drag_area_m2", "drag_area"),
        "auxiliary_load": ("power_w", "P_aux"),
        "battery_resistance": ("resistance_ohm", "R_i"),
    }
    tables = {
        effect: [_figure(key, getattr(file, name), name)]
        for effect, (key, name) in known.items()
        if name not in hidden and getattr(file, name) > 0
    }
    if file.dead_zone > 0 and "dead_zone" not in hidden:
        tables["speed_dead_zone"] = [_figure("threshold_radps", file.dead_zone)]
    if file.loss > 0:
        scale, sd = 1 - file.loss, TOLERANCES["loss"] * file.loss
        figure = f"{{ value = {scale:.6g}, sd = {sd:.6g} }}"
        tables["motor_efficiency"] = [f"scale = {figure}"]
    if file.family == "rc":
        tables["reference_sampling"] = ["period_s = 0.01"]
    if "regen" not in hidden and isfinite(file.regen):
        key = "max_current_a" if file.regen == 0 else "max_torque_nm"
        tables["regeneration_limit"] = [_figure(key, file.regen)]
    for name, value in file.keeps:
        if KEPT[name] not in hidden:
            effect, _, key = name.partition(".")
            tables.setdefault(effect, []).append(_figure(key, value))
    return tables
