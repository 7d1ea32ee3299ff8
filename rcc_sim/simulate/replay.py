"""A logged drive, run again: the vehicle under the log's own inputs."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rcc_sim.definitions.kernel import efficiency_map, force_table, kernel_params
from rcc_sim.definitions.vehicle import Vehicle
from rcc_sim.physics import params as schema
from rcc_sim.physics import record
from rcc_sim.physics.replay import run_replayed
from rcc_sim.simulate.own import own_terms
from rcc_sim.simulate.columns import trace_columns
from rcc_sim.simulate.sensors import sensed_columns
from rcc_sim.trace import Trace

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Drive:
    """What drove the vehicle of a log, row by row."""

    time: Array
    imposed: bool
    steered: bool
    commands: tuple[Array, Array, Array, Array]
    road: tuple[Array, Array]
    measured: tuple[Array, Array, Array, Array, Array]
    window: float


def replay(
    vehicle: Vehicle, drive: Drive, recalls: tuple[float, float] = (inf, inf)
) -> dict[str, Array]:
    values = kernel_params(vehicle, commanded=not drive.imposed)
    if drive.steered:
        values["lanes"]["steer"] = schema.LOGGED
    if drive.imposed:
        values["control"]["T_loop"] = 0.01
        values["control"]["delta_max"] = values["control"].get("delta_max", inf)
    n = len(drive.time)
    own = own_terms(vehicle)
    P = record.array(own.params)
    work = tuple(record.array(s) for s in own.work)
    table = record.array(schema.ROW, n)
    sinks = record.array(record.floats(*own.sinks), 1)
    record.fill(P[0], values)
    maps = (efficiency_map(vehicle), force_table(vehicle))
    own.call(
        run_replayed,
        True,
        P,
        work,
        (drive.time, *drive.commands),
        drive.road,
        drive.measured,
        maps,
        delay_lines(values),
        table,
        sinks,
        drive.imposed,
        drive.window,
        recalls,
    )
    c = work[0][0]
    columns = trace_columns(
        vehicle,
        table,
        np.broadcast_to(sinks, n),
        own.sinks,
        n=float(c["n"]),
        n_file=float(c["n_file"]),
        K_t=float(c["K_t"]),
    )
    return sensed_columns(vehicle, columns)


def delay_lines(values: Any) -> tuple[Array, Array]:
    import math

    delays = (values[n]["delay_s"] for n in ("actuation_delay", "steering_delay"))
    size = math.ceil(max(delays) / values["control"]["T_loop"]) + 3
    return np.zeros(size), np.zeros(size)


def drive_of(
    log: Trace, vehicle: Vehicle, window: float = 0.01, jerk: float = 0.05
) -> Drive:
    t = log["time_s"]
    n = len(t)
    mode = vehicle.controller.mode if vehicle.controller else "torque"
    zeros = np.zeros(n)
    nan = np.full(n, np.nan)
    get = lambda name, default: (
        np.ascontiguousarray(log[name]) if name in log else default
    )
    imposed = not (
        mode == "speed"
        and "speed_ref_mps" in log
        or mode == "throttle"
        and "throttle" in log
    )
    speed = get("speed_mps", nan)
    accel = zeros
    if imposed:
        from rcc_sim.simulate.smooth import sensor_noise, smooth_speed

        ax = log["accel_x_mps2"] if "accel_x_mps2" in log else None
        speed, accel = smooth_speed(t, speed, noise=sensor_noise(speed), jerk=jerk, accel=ax)
    road = (np.zeros(1), np.zeros(1))
    if "elevation_m" in log:
        from rcc_sim.simulate.road import surveyed_slope

        v = np.where(np.isfinite(speed), speed, 0.0)
        s = np.concatenate([[0.0], np.cumsum(0.5 * (v[1:] + v[:-1]) * np.diff(t))])
        road = surveyed_slope(np.maximum.accumulate(s), log["elevation_m"])
    return Drive(
        t,
        imposed,
        "steer_cmd_rad" in log,
        (
            get("speed_ref_mps", zeros),
            get("steer_cmd_rad", zeros),
            get("throttle", zeros),
            get("aux_power_w", zeros),
        ),
        road,
        (
            speed,
            get("motor_current_a", nan),
            get("yaw_rate_radps", zeros),
            get("motor_torque_nm", nan),
            accel,
        ),
        window,
    )
