"""Where the blind plant and the model part on drives that withhold nothing.

    python -m benchmarks.plant_against_model [--aligned]

Each base vehicle drives on a smooth road, read by perfect sensors, its file exact; the
model replays the log, its current loop as slow as the plant's. Rows come every 10 ms,
as a mean lasts, so that no speed has to be guessed between them. Figures are in units
of the sensor's noise: the root mean square of the difference, and its mean, over the
rows that diagnosis judges. ``free`` is a run on its own, ``held`` one drawn to the log
as the diagnosis draws it. Rows lag the controller's clock; with ``--aligned`` they do
not, and commands need no interpolation: what is then left is the integrators' own.
"""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from rcc_sim.blind import case, drives, nominal, sensors, worth
from rcc_sim.blind.bases import BASES, Base, truth
from rcc_sim.blind.plant import CLOCK, CURRENT_LAG
from rcc_sim.definitions.vehicle import Vehicle, load_vehicle
from rcc_sim.diagnose.residuals.problem import Problem
from rcc_sim.simulate.drive import drive_of
from rcc_sim.simulate.replay import FREE, RECALLS, replay
from rcc_sim.trace import Trace

Array = NDArray[np.float64]
SEEDS = (1, 2, 3)
LAG = "effects.motor_lag.time_constant_s"


def clean_log(car: Base, seed: int, aligned: bool = False) -> Trace:
    """Return the log of one drive on a smooth road, by sensors without fault."""
    rng = np.random.default_rng(seed)
    road = drives.Road(np.zeros(2), np.zeros(1), np.zeros(1), 0.0, 0.5)
    styles = list(drives.STYLES[car.family])
    d = drives.drive(car, road, styles[seed % len(styles)], rng)[0]
    how = drives.TIMING[car.family]
    dt = how.tick / how.substeps
    at = np.asarray(d.rows)
    per = round(CLOCK / dt)
    d = d._replace(rows=np.arange(per if aligned else at[0], at[-1], per))
    rows, _ = worth.fine(truth(car, car.r_w), d, car.family)
    time = np.asarray(d.rows) * dt
    read = {k: rows[:, s.place] for k, s in sensors.SENSORS[car.family].items()}
    keep = np.ones(len(rows), dtype=bool)
    columns = case.logged_columns(car.family, time, read, keep, d, surveyed=False)
    return Trace(columns, name=f"{car.name} {seed}")


def vehicle_of(car: Base) -> Vehicle:
    """Return the vehicle whose file states the car as it is."""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / f"{car.name}.toml"
        file.write_text(nominal.vehicle_text(car.name, car, ()), encoding="utf-8")
        vehicle = load_vehicle(file)
    if car.family == "rc":
        vehicle = vehicle.changed(settings={LAG: CURRENT_LAG})
    return vehicle


def apart(car: Base, seed: int, aligned: bool) -> dict[str, dict[str, Array]]:
    """Return plant less model in units of noise, by way of running and channel."""
    log, vehicle = clean_log(car, seed, aligned), vehicle_of(car)
    problem = Problem(vehicle, log, drive_of(log, vehicle))
    judged = dict(zip(problem.channels, problem.judged, strict=True))
    found: dict[str, dict[str, Array]] = {}
    for how, recalls in (("free", FREE), ("held", RECALLS)):
        out = replay(vehicle, problem.drive, recalls)
        found[how] = {
            c: ((log[c] - out[c]) / sensors.SENSORS[car.family][c].noise)[ok]
            for c, ok in judged.items()
            if c in sensors.SENSORS[car.family]
        }
    return found


def main() -> None:
    """Print a line for each vehicle and channel."""
    print("plant less model over noise: rms (mean), drives pooled")
    print(f"{'car':8}{'channel':22}{'free':>18}{'held':>18}")
    for car in BASES:
        runs = [apart(car, seed, "--aligned" in sys.argv) for seed in SEEDS]
        for channel in runs[0]["free"]:
            cells = []
            for how in ("free", "held"):
                x = np.concatenate([run[how][channel] for run in runs])
                cells.append(f"{np.sqrt(np.mean(x * x)):8.3f} ({x.mean():+.3f})")
            print(f"{car.name:8}{channel:22}{cells[0]:>18}{cells[1]:>18}")


if __name__ == "__main__":
    main()
