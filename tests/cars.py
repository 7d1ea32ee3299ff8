"""Vehicles for tests, small and large, and what the tests ask of their runs."""

from __future__ import annotations

import copy

from rcc_sim.definitions.vehicle import Vehicle, build

CAR = {
    "vehicle": {"name": "car"},
    "body": {
        "mass_kg": 3.78,
        "yaw_inertia_kgm2": 0.0382,
        "cg_to_front_axle_m": 0.15876,
        "cg_to_rear_axle_m": 0.16523,
    },
    "tyres": {
        "radius_m": 0.049,
        "front_cornering_stiffness_n_per_rad": 90.0,
        "rear_cornering_stiffness_n_per_rad": 110.0,
    },
    "drivetrain": {"gear_ratio": 11.82},
    "motor": {"poles": 4, "flux_linkage_wb": 0.887e-3},
    "battery": {"open_circuit_voltage_v": 12.0, "capacity_ah": 5.2},
    "controller": {
        "mode": "speed",
        "proportional_gain_as_per_rad": 0.25,
        "integral_gain_a_per_rad": 0.5,
        "max_current_a": 50.0,
        "loop_rate_hz": 1000.0,
    },
}
TRUCK = {
    "vehicle": {"name": "truck"},
    "body": {
        "mass_kg": 3152.0,
        "yaw_inertia_kgm2": 5000.0,
        "cg_to_front_axle_m": 1.6915,
        "cg_to_rear_axle_m": 1.7605,
    },
    "tyres": {
        "radius_m": 0.4191,
        "front_cornering_stiffness_n_per_rad": 40700.0,
        "rear_cornering_stiffness_n_per_rad": 45000.0,
    },
    "drivetrain": {"gear_ratio": 12.0},
    "motor": {"poles": 8, "flux_linkage_wb": 0.098, "max_power_w": 623e3},
    "battery": {"open_circuit_voltage_v": 400.0, "capacity_ah": 330.0},
    "controller": {"mode": "torque", "max_torque_nm": 1231.0, "loop_rate_hz": 100.0},
}


def car(effects: dict | None = None, **settings: object) -> Vehicle:
    """The small car with effects, and settings as table__key=value."""
    return _made(CAR, effects, settings)


def truck(effects: dict | None = None, **settings: object) -> Vehicle:
    """The pick-up with effects, and settings as table__key=value."""
    return _made(TRUCK, effects, settings)


def _made(raw: dict, effects: dict | None, settings: dict[str, object]) -> Vehicle:
    raw = copy.deepcopy(raw) | {"effects": effects or {}}
    for key, value in settings.items():
        table, _, name = key.partition("__")
        raw[table][name] = value
    return build(raw, path=None)
