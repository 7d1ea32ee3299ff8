"""Two small vehicles for the tests of similitude; nothing here is a fixture file."""

from __future__ import annotations

from typing import Any

from rcc_sim.definitions.vehicle import Vehicle, build


def car(**tables: Any) -> Vehicle:
    """Return the RC car of the paper, with tables laid over it."""
    raw: dict[str, Any] = {
        "vehicle": {"name": "car"},
        "body": {
            "mass_kg": 3.78,
            "yaw_inertia_kgm2": 0.0382,
            "cg_to_front_axle_m": 0.15876,
            "cg_to_rear_axle_m": 0.16523,
        },
        "tyres": {
            "radius_m": 0.049,
            "front_cornering_stiffness_n_per_rad": 90,
            "rear_cornering_stiffness_n_per_rad": 90,
        },
        "drivetrain": {"gear_ratio": 11.82},
        "motor": {
            "poles": 4,
            "flux_linkage_wb": 0.887e-3,
            "velocity_constant_rpm_per_v": 3300,
        },
        "battery": {"open_circuit_voltage_v": 12.0},
        "controller": {
            "mode": "speed",
            "proportional_gain_as_per_rad": 0.25,
            "integral_gain_a_per_rad": 0.5,
            "max_current_a": 50,
            "max_electrical_speed_radps": 6283.2,
        },
        "effects": {
            "drivetrain_damping": {"damping_nms_per_rad": 1.17e-5},
            "rotor_inertia": {"inertia_kgm2": 2.2e-6},
            "copper_loss": {"phase_resistance_ohm": 0.0195},
        },
    }
    return build(_laid_over(raw, tables), path=None)


def truck(**tables: Any) -> Vehicle:
    """Return the pick-up of the paper, with tables laid over it."""
    raw: dict[str, Any] = {
        "vehicle": {"name": "truck"},
        "body": {
            "mass_kg": 3152,
            "yaw_inertia_kgm2": [4000, 6000],
            "cg_to_front_axle_m": 1.6915,
            "cg_to_rear_axle_m": 1.7605,
        },
        "tyres": {
            "radius_m": 0.4191,
            "front_cornering_stiffness_n_per_rad": 40700,
            "rear_cornering_stiffness_n_per_rad": 40700,
        },
        "drivetrain": {"gear_ratio": 12},
        "motor": {"max_torque_nm": 1231, "max_power_w": 623000},
        "controller": {"mode": "torque", "max_torque_nm": 1231},
        "effects": {
            "drivetrain_damping": {"damping_nms_per_rad": 0.1},
            "rotor_inertia": {"inertia_kgm2": 0.2},
        },
    }
    return build(_laid_over(raw, tables), path=None)


def _laid_over(raw: dict[str, Any], tables: dict[str, Any]) -> dict[str, Any]:
    for name, table in tables.items():
        raw.setdefault(name, {}).update(table)
    return raw
