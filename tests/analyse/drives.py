"""Drives of known soundness: simulated, then seen by sensors with known faults."""

from __future__ import annotations

import functools

import numpy as np

from rcc_sim.definitions.cycle import Cycle, parse_cycle
from rcc_sim.definitions.vehicle import load_vehicle
from rcc_sim.simulate.run import LaneChanges, simulate
from rcc_sim.trace import Trace

NOISE = {
    "speed_mps": 0.003,
    "yaw_rate_radps": 0.01,
    "accel_x_mps2": 0.1,
    "accel_y_mps2": 0.1,
    "motor_current_a": 0.2,
    "battery_current_a": 0.1,
    "battery_voltage_v": 0.01,
    "battery_power_w": 1.0,
    "motor_speed_radps": 0.5,
    "motor_torque_nm": 1e-3,
    "x_m": 0.002,
    "y_m": 0.002,
    "yaw_rad": 0.003,
}
"""Standard deviation of a small car's sensors. [the column's unit]"""

LARGE = {"battery_power_w": 100.0} | dict.fromkeys(
    ("battery_voltage_v", "battery_current_a", "motor_current_a", "motor_torque_nm"),
    10.0,
)
"""How much noisier a full-size car's are. [1]"""

STEPPED = ("battery_voltage_v", "battery_current_a", "motor_current_a")
"""What the sensor's resolution rounds. """

SOUND = [
    ("rcc", "udds[0:200]", 100, 20),
    ("rcc", "udds[0:300]", 1000, 10),
    ("rcc", "udds", 10, 10),
    ("rcc", "hwfet[0:200]", 50, None),
    ("f1tenth", "udds[0:525]", 100, 8),
    ("r1t", "udds[0:400]", 10, 60),
    ("r1t_epa", "us06", 10, 80),
    ("bmw_i3", "wltc_3b", 10, 80),
    ("tesla_model_3", "nedc", 20, 100),
    ("twizy", "artemis_urban", 10, 50),
]
"""Vehicle, cycle, rows per second, metres between lane changes."""

CAR, ROVER, TRUCK, SEDAN = SOUND[0], SOUND[4], SOUND[5], SOUND[7]


@functools.cache
def driven(vehicle, cycle, rate, lanes, imposed=False):
    """Return the true trace of a drive, small cars at a small car's pace."""
    car, course = load_vehicle(vehicle), parse_cycle(cycle)
    if car.body.mass_kg.value < 50:
        course = Cycle(cycle, course.time_s * 0.2256, course.speed_mps * 0.416)
    run = simulate(
        car,
        course,
        lanes=LaneChanges(lanes) if lanes else None,
        imposed=imposed,
        output_rate=None if imposed else rate,
    )
    return run.trace


def logged(vehicle, cycle, rate, lanes, *, imposed=False, seed=0, noise=1.0):
    """Return a drive as sensors log it: noise, resolution, 0.2 % of rows lost."""
    rng = np.random.default_rng(seed)
    heavy = load_vehicle(vehicle).body.mass_kg.value > 50
    true = driven(vehicle, cycle, rate, lanes, imposed)
    keep = rng.random(len(true)) > 0.002
    keep[0] = True
    columns = {}
    for name, values in true.columns.items():
        if name.endswith("_j") or name == "distance_m":
            continue
        sd = NOISE.get(name, 0.0) * noise * (LARGE.get(name, 1.0) if heavy else 1.0)
        seen = values + rng.normal(0.0, sd, len(values)) if sd else values.copy()
        if sd and name in STEPPED:
            seen = np.round(seen / sd) * sd
        columns[name] = seen[keep]
    return Trace(columns, name=f"{vehicle} {cycle} {rate} Hz")


def with_fault(trace, name, change):
    """Return a log in which one column is another."""
    columns = dict(trace.columns)
    columns[name] = change(columns[name].copy())
    return Trace(columns, name=trace.name)
