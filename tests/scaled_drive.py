"""A scaled car's drive over a scaled cycle, as its sensors log it."""

import numpy as np

from rcc_sim.analyse.logged import open_log
from rcc_sim.definitions.cycle import parse_cycle
from rcc_sim.definitions.vehicle import load_vehicle
from rcc_sim.similitude.cycles import scale_cycle
from rcc_sim.simulate.run import simulate

NOISE = {
    "time_s": 0.0,
    "speed_ref_mps": 0.0,
    "steer_cmd_rad": 0.0,
    "speed_mps": 0.02,
    "yaw_rate_radps": 0.01,
    "accel_x_mps2": 0.1,
    "accel_y_mps2": 0.1,
    "motor_current_a": 0.3,
    "battery_voltage_v": 0.02,
    "battery_current_a": 0.05,
}
"""Columns of a log, and the standard deviation of their noise."""


def drive(true, lanes):
    """Return the trace of a car over a part of the pick-up's town cycle, scaled."""
    cycle = scale_cycle(parse_cycle("udds[20:125]"), of=load_vehicle("r1t"), to=true)
    return simulate(true, cycle.cycle, lanes=lanes).trace


def logged(run, car, seed, folder, late=None, noise=NOISE):
    """Return a trace as a log, some columns read ``late`` by so many seconds."""
    rng = np.random.default_rng(seed)
    t, late = run["time_s"], late or {}
    log = {
        c: np.interp(t - late.get(c, 0.0), t, run[c]) + sd * rng.standard_normal(len(t))
        for c, sd in noise.items()
    }
    return written(log, car, folder)


def written(columns, car, folder):
    """Return columns as a log that was written and read."""
    path = folder / "log.csv"
    head = {"delimiter": ",", "header": ",".join(columns), "comments": ""}
    np.savetxt(path, np.column_stack(list(columns.values())), **head)
    return open_log(path, car)
