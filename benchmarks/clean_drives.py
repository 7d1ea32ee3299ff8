"""Drives without a cause, logged in many ways: is one named where there is none?

    python -m benchmarks.clean_drives --jobs 2

A car's speed is imposed by an EPA schedule, by a drive that bends everywhere, or by one
of ramps whose corners are anywhere, with noise of usual sensors on every channel. The
log holds means since the row before, at 1 to 10 Hz; or samples, 30 ms off the
schedule's clock; or samples of a drive whose corners are its rows; or means in steps,
as a CAN bus gives them, of 0.1 km/h, 0.5 V and 0.1 A; or samples a second apart, as a
diagnostic socket gives them when asked, of the speed first and 0.2 s later of all else.
It is diagnosed with all channels, without the motor's torque or the accelerometer, and
with speed and battery alone. Nothing is withheld, so that every cause named is a false
alarm.
"""

from __future__ import annotations

import argparse
import tempfile
import time
import zlib
from collections import Counter
from concurrent.futures import ProcessPoolExecutor
from itertools import product
from pathlib import Path

import numpy as np
import pandas as pd
from scipy.interpolate import PchipInterpolator

from rcc_sim.analyse.logged import open_log
from rcc_sim.definitions.cycle import Cycle, parse_cycle
from rcc_sim.definitions.vehicle import load_vehicle
from rcc_sim.diagnose.run import diagnose
from rcc_sim.simulate.run import simulate

CARS = ("r1t_epa", "bmw_i3", "tesla_model_3")
TRAFFIC, RAMPS = "traffic", "ramps"
CYCLES = ("udds[0:600]", "hwfet", "us06", "nycc", TRAFFIC, RAMPS)
FINE = 200.0  # Hz; of the run of which samples are taken
PHASE = 0.03  # s; of the logger's clock beside the schedule's
LOGGERS = (
    *(("means", rate) for rate in (1.0, 2.0, 5.0, 10.0)),
    *(("samples", rate) for rate in (5.0, 10.0)),
    ("corners", 10.0),
    *(("steps", rate) for rate in (5.0, 10.0)),
    ("polled", 1.0),
)
NOISE = {
    "speed_mps": 0.03,
    "accel_x_mps2": 0.05,
    "motor_torque_nm": 1.0,
    "battery_voltage_v": 0.2,
    "battery_current_a": 0.5,
}
"""Column -> standard deviation of its noise, in its unit; others are not logged."""

STEPS = {
    "speed_mps": 0.1 / 3.6,
    "accel_x_mps2": 0.01,
    "motor_torque_nm": 0.5,
    "battery_voltage_v": 0.5,
    "battery_current_a": 0.1,
}
"""Column -> what a bus rounds it to, in its unit."""

QUIET = {"steps": 0.1, "polled": 0.3}
"""Share of such noise that a speed holds before it is rounded, or asked for."""

ASKED = 0.2
"""Time after the speed at which a socket is asked for all else. [s]"""

LACKS: dict[str, tuple[str, ...]] = {
    "all": (),
    "no torque": ("motor_torque_nm",),
    "no accel": ("accel_x_mps2",),
    "battery alone": ("motor_torque_nm", "accel_x_mps2"),
}
"""Set of channels -> those that it lacks."""


def schedule_of(name: str) -> Cycle:
    """Return a schedule; 15 minutes of speeds that a foot changes all the time; or 25.

    These of ramps at 0.4 to 1.4 m/s², with 5 to 40 s of an even speed between them.
    """
    if name == RAMPS:
        return ramps()
    if name != TRAFFIC:
        return parse_cycle(name)
    rng = np.random.default_rng(7)
    time, knots = np.arange(0.0, 900.0, 1 / FINE), np.arange(0.0, 930.0, 6.0)
    speed = PchipInterpolator(knots, 12.0 + 6.0 * rng.standard_normal(len(knots)))
    return Cycle(name, time, np.maximum(speed(time), 0.0))


def ramps() -> Cycle:
    """Return speeds that change by ramps, of which one in five leads to a stop."""
    rng = np.random.default_rng(11)
    time, speed = [0.0, rng.uniform(5.0, 20.0)], [0.0, 0.0]
    while time[-1] < 1500.0:
        goal = 0.0 if rng.random() < 0.2 and speed[-1] > 0 else rng.uniform(4.0, 29.0)
        takes = abs(goal - speed[-1]) / rng.uniform(0.4, 1.4)
        time += [time[-1] + takes, time[-1] + takes + rng.uniform(5.0, 40.0)]
        speed += [goal, goal]
    rows = np.arange(0.0, 1500.0, 1 / FINE)
    return Cycle(RAMPS, rows, np.interp(rows, time, speed))


def drive(car: str, cycle: str, how: str, rate: float) -> pd.DataFrame:
    """Return a log, with noise; how it was logged, and at which rate. [Hz]"""
    schedule, many = schedule_of(cycle), round(FINE / rate)
    run = simulate(load_vehicle(car), schedule, imposed=True, output_rate=FINE)
    first = round(PHASE * FINE) if how in ("samples", "polled") else 0
    later = first + round(ASKED * FINE) * (how == "polled")
    since = {"time_s": first} | dict.fromkeys(NOISE, later) | {"speed_mps": first}
    columns = {c: run.trace[c][at::many] for c, at in since.items()}
    fewest = min(map(len, columns.values()))
    columns = {c: x[:fewest] for c, x in columns.items()}
    if how in ("means", "steps"):
        rows = np.arange(0, len(run.trace), many)
        for c in NOISE.keys() - {"speed_mps"}:
            total = np.concatenate([[0.0], np.cumsum(run.trace[c])])
            before = np.maximum(rows - many, 0)  # whose row is that of the mean before
            columns[c] = (total[rows + 1] - total[before + 1]) / many
            columns[c][0] = run.trace[c][0]
    seed = zlib.crc32(f"{car} {cycle} {how} {rate:g}".encode())
    rng = np.random.default_rng(seed)
    for name, sd in NOISE.items():
        size = sd * QUIET.get(how, 1.0) if name == "speed_mps" else sd
        columns[name] = columns[name] + rng.normal(0.0, size, len(columns["time_s"]))
    columns["speed_mps"] = np.maximum(columns["speed_mps"], 0.0)
    if how == "steps":
        columns |= {c: step * np.round(columns[c] / step) for c, step in STEPS.items()}
    return pd.DataFrame(columns)


def named(case: tuple[str, str, tuple[str, float], str]) -> tuple[str, list[str], str]:
    """Diagnose one drive: what it is, the causes named, the status."""
    car, cycle, (how, rate), channels = case
    vehicle, log = load_vehicle(car), drive(car, cycle, how, rate)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "log.csv"
        kept = log.drop(columns=list(LACKS[channels]))
        kept.to_csv(path, index=False, float_format="%.5f")
        found = diagnose([open_log(path, vehicle)], vehicle)
    what = f"{car:14} {cycle:12} {how:8} {rate:4g} Hz  {channels}"
    return what, [a.cause.effect for a in found.asserted], found.status


def main() -> None:
    """Print each drive that names a cause or is unexplained, and how many there are."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--how", help="means, samples, corners, steps or polled alone")
    asked = parser.parse_args()
    jobs = asked.jobs
    loggers = [one for one in LOGGERS if asked.how in (None, one[0])]
    cases = list(product(CARS, CYCLES, loggers, LACKS))
    start, statuses, alarms = time.time(), Counter[str](), 0
    with ProcessPoolExecutor(jobs) as pool:
        for what, causes, status in pool.map(named, cases):
            statuses[status] += 1
            alarms += bool(causes)
            if causes or status != "no_gap":
                print(f"{what:50} {status:17} {'+'.join(causes)}", flush=True)
    print(
        f"{len(cases)} drives: a cause named in {alarms}, unexplained "
        f"{statuses['unexplained']}; {time.time() - start:.0f} s"
    )


if __name__ == "__main__":
    main()
