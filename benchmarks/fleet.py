"""Many logs: time a log, how it grows with logs and workers, what a million trips take.

    python -m benchmarks.fleet --logs 1000 --diagnosed 40

Logs are of 75 s at 100 Hz. Ratios are of one run of this program, and of the rate once
every process is under way: the start of a process costs some seconds, once.
"""

from __future__ import annotations

import argparse
import importlib.util
import os
import tempfile
import time
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from benchmarks.sweep import cluster, small
from rcc_sim.batch.batch import Progress, run_batch
from rcc_sim.batch.engine import Engine
from rcc_sim.batch.fleet import Fleet, RowOf
from rcc_sim.batch.fleet_logs import Entry
from rcc_sim.batch.fleet_rows import (
    CHECK,
    DIAGNOSE,
    GAP,
    check_row,
    diagnose_row,
    gap_row,
)
from rcc_sim.definitions.vehicle import load_vehicle
from rcc_sim.processes import ONE_THREAD
from rcc_sim.simulate.run import LaneChanges, simulate
from rcc_sim.trace import Trace, write_trace

CAR = "rcc"
HOURS = 3600.0
NOISE = {
    "speed_mps": 0.0026,
    "yaw_rate_radps": 0.0148,
    "accel_x_mps2": 0.25,
    "accel_y_mps2": 0.25,
    "motor_current_a": 0.26,
    "battery_voltage_v": 0.015,
    "battery_current_a": 0.06,
}
"""Standard deviation of each channel that is logged, as of a VESC and an IMU."""

COMMANDS: Mapping[str, tuple[RowOf, Mapping[str, str]]] = {
    "check": (check_row, CHECK),
    "gap": (gap_row, GAP),
    "diagnose": (diagnose_row, DIAGNOSE),
}


@dataclass(frozen=True)
class Took:
    """Time of a fleet, CPU time, logs a second once under way, bytes of a row."""

    whole: float
    cpu: float
    rate: float
    row: float
    failed: int


def main() -> None:
    """Print every line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--logs", type=int, default=200)
    parser.add_argument("--diagnosed", type=int, default=16)
    parser.add_argument("--commands", default="check,gap,diagnose")
    known = parser.parse_args()
    os.environ |= ONE_THREAD
    print(f"load before: {os.getloadavg()[0]:.2f} on {os.cpu_count()} cores")
    with tempfile.TemporaryDirectory() as folder:
        logs = tuple(written(Path(folder), known.logs))
        size = sum(Path(log).stat().st_size for log in logs) / len(logs)
        print(f"{len(logs)} logs of 75 s at 100 Hz, {size / 1e6:.2f} MB each")
        for command in known.commands.split(","):
            count = known.diagnosed if command == "diagnose" else len(logs)
            told(command, logs[:count], size)


def told(command: str, logs: tuple[str, ...], size: float) -> None:
    """Print what a command takes, a log and a million."""
    took(command, logs[:2], Engine())  # compiles
    half = took(command, logs[: len(logs) // 2], Engine())
    one = took(command, logs, Engine())
    two = took(command, logs, Engine(jobs=2))
    print(
        f"{command}, {len(logs)} logs: {1e3 / one.rate:.0f} ms a log, CPU "
        f"{1e3 * one.cpu / len(logs):.0f} ms (two processes "
        f"{1e3 * two.cpu / len(logs):.0f}, start included); twice the logs "
        f"{one.whole / half.whole:.2f} times the time; two processes "
        f"{two.rate / one.rate:.2f} times the logs a second, "
        f"{one.whole / two.whole:.2f} start included; {one.failed} failed"
    )
    if importlib.util.find_spec("distributed") is not None:
        rates = []
        for workers in (1, 2):
            with cluster(workers) as address:
                took(command, logs[: 2 * workers], Engine(dask=address))
                rates.append(took(command, logs, Engine(dask=address)).rate)
        print(f"  Dask: two workers {rates[1] / rates[0]:.2f} times one")
    print(
        f"  10^6 such trips: {1e6 * one.cpu / len(logs) / HOURS:,.0f} core hours, "
        f"{1e6 * size / 1e9:,.0f} GB to read, {1e6 * one.row / 1e9:.1f} GB of "
        "rows"
    )


def took(command: str, logs: tuple[str, ...], engine: Engine) -> Took:
    """Return what a fleet took."""
    row, columns = COMMANDS[command]
    entries = tuple(Entry(log) for log in logs)
    batch = Fleet(command, row, entries, columns, {"vehicle": CAR}, (CAR,))
    seen: list[tuple[float, int]] = []

    def tell(progress: Progress) -> None:
        seen.append((time.perf_counter(), progress.done))

    before = os.times()
    with tempfile.TemporaryDirectory() as out:
        start = time.perf_counter()
        progress = run_batch(batch, Path(out, "rows"), engine, tell)
        whole = time.perf_counter() - start
        parts = Path(out, "rows").glob("part-*")
        size = sum(path.stat().st_size for path in parts) / len(logs)
    cpu = sum(os.times()[:4]) - sum(before[:4])
    (t_0, n_0), (t_1, n_1) = seen[len(seen) // 4], seen[-1]
    rate = (n_1 - n_0) / (t_1 - t_0) if t_1 > t_0 else len(logs) / whole
    return Took(whole, cpu, rate, size, progress.failed)


def written(folder: Path, count: int) -> Iterator[str]:
    """Write logs of 75 s, each with noise of its own."""
    trace = simulate(
        load_vehicle(CAR), small().slice(20, 95), lanes=LaneChanges(20.0)
    ).trace
    kept = ("time_s", "speed_ref_mps", "steer_cmd_rad", *NOISE)
    rng = np.random.default_rng(1)
    for k in range(count):
        noisy = {
            name: trace[name] + NOISE.get(name, 0.0) * rng.normal(size=len(trace))
            for name in kept
        }
        path = folder / f"log{k:06d}.csv"
        with path.open("wb") as file:
            write_trace(Trace(noisy, name=path.name), file)
        yield str(path)


if __name__ == "__main__":
    main()
