"""Many runs: runs a second, beside single runs; two processes and Dask beside one.

    python -m benchmarks.sweep

Ratios are of one run of this program: each pair is timed in turn, several times. Dask
needs `pip install "rccsim[dask]"`; it is left out where it is not installed.
"""

from __future__ import annotations

import contextlib
import importlib.util
import os
import resource
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

from rcc_sim.batch.batch import Progress, run_batch
from rcc_sim.batch.engine import Engine
from rcc_sim.batch.plan import make_plan
from rcc_sim.batch.runs import Manoeuvre, Sweep
from rcc_sim.definitions.cycle import Cycle, parse_cycle
from rcc_sim.definitions.vehicle import load_vehicle
from rcc_sim.simulate.run import LaneChanges, simulate

ROUNDS = 3
MANY = 200_000
DRAWS = 100_000


def main() -> None:
    """Print every line."""
    print(f"load before: {os.getloadavg()[0]:.2f} on {os.cpu_count()} cores")
    single_core()
    commanded()
    compared("one and two processes", Engine(), Engine(jobs=2))
    if importlib.util.find_spec("distributed") is None:
        print("Dask: left out, not installed")
    else:
        dask()
    memory()


def imposed(runs: int) -> Sweep:
    """Return a sweep of imposed UDDS at 1 Hz over masses and auxiliary powers."""
    settings = [
        f"body.mass_kg=3000:{3000 + 0.1 * (runs // 100 - 1):.1f}:0.1",
        "effects.auxiliary_load.power_w=0:990:10",
    ]
    udds, truck = parse_cycle("udds"), load_vehicle("r1t_epa")
    return Sweep(truck, udds, make_plan(settings), Manoeuvre(imposed=True))


def seconds(sweep: Sweep, engine: Engine) -> float:
    """Return the time of a whole sweep, written to a folder."""
    with tempfile.TemporaryDirectory() as folder:
        start = time.perf_counter()
        run_batch(sweep, Path(folder, "out"), engine)
        return time.perf_counter() - start


@dataclass(frozen=True)
class Pace:
    """Time of a whole sweep, runs a second once under way, and CPU time of it all."""

    whole: float
    steady: float
    cpu: float


def pace(sweep: Sweep, engine: Engine) -> Pace:
    """Return how fast a sweep is, written to a folder."""
    seen: list[tuple[float, int]] = []

    def tell(progress: Progress) -> None:
        seen.append((time.perf_counter(), progress.done))

    before = os.times()
    with tempfile.TemporaryDirectory() as folder:
        start = time.perf_counter()
        run_batch(sweep, Path(folder, "out"), engine, tell)
        whole = time.perf_counter() - start
    after = os.times()
    quarter = len(seen) // 4  # by then every process is under way
    (t_0, n_0), (t_1, n_1) = seen[quarter], seen[-1]
    cpu = sum(after[:4]) - sum(before[:4])
    return Pace(whole, (n_1 - n_0) / (t_1 - t_0), cpu)


def in_turn(*calls: Callable[[], float]) -> list[float]:
    """Return the median of each call, done in turn."""
    took = [[call() for call in calls] for _ in range(ROUNDS)]
    return [statistics.median(column) for column in zip(*took, strict=True)]


def single_core() -> None:
    """Imposed UDDS at 1 Hz, one process: everything, files included."""
    seconds(imposed(1000), Engine())  # compiles
    took, one = in_turn(
        lambda: seconds(imposed(20_000), Engine()), lambda: single(100, imposed=True)
    )
    rate = 20_000 / took
    print(
        f"imposed UDDS, 1 Hz, one core: {rate:,.0f} runs/s, rows written; a single run "
        f"{1e3 * one:.2f} ms in process: {one * rate:.1f} times as fast"
    )


def single(times: int, *, imposed: bool) -> float:
    """Return the time of one simulate() call."""
    name = "r1t_epa" if imposed else "rcc"
    vehicle, cycle = load_vehicle(name), parse_cycle("udds")
    lanes = None if imposed else LaneChanges(20.0)
    if not imposed:
        cycle = small()
    start = time.perf_counter()
    for _ in range(times):
        simulate(vehicle, cycle, imposed=imposed, lanes=lanes, engine="compiled")
    return (time.perf_counter() - start) / times


def small() -> Cycle:
    """Return UDDS at a speed of the small car."""
    udds = parse_cycle("udds")
    return Cycle("udds at 0.416", udds.time_s, 0.416 * udds.speed_mps)


def commanded() -> None:
    """Commanded UDDS at 1 kHz with lane changes: a run of many, and a single one."""
    plan = make_plan(["body.mass_kg=3.6:3.95:0.05"])
    sweep = Sweep(
        load_vehicle("rcc"), small(), plan, Manoeuvre(lanes=LaneChanges(20.0))
    )
    seconds(sweep, Engine())
    many, one = in_turn(
        lambda: seconds(sweep, Engine()) / plan.size, lambda: single(4, imposed=False)
    )
    print(
        f"commanded UDDS, 1 kHz, lane changes: {1e3 * many:.0f} ms a run of a sweep, "
        f"{1e3 * one:.0f} ms a single run in process: ratio {many / one:.2f}"
    )


def compared(label: str, one: Engine, two: Engine) -> None:
    """Print how much faster the second engine is than the first."""
    sweep = imposed(MANY)
    took = [(pace(sweep, one), pace(sweep, two)) for _ in range(ROUNDS)]
    a, b = ([pair[k] for pair in took] for k in (0, 1))
    whole = [statistics.median(p.whole for p in side) for side in (a, b)]
    steady = [statistics.median(p.steady for p in side) for side in (a, b)]
    print(
        f"{MANY:,} imposed runs, {label}: {whole[0]:.1f} s and {whole[1]:.1f} s, "
        f"{whole[0] / whole[1]:.2f} times as fast; once under way {steady[0]:,.0f} and "
        f"{steady[1]:,.0f} runs/s, {steady[1] / steady[0]:.2f} times",
        end="",
    )
    if two.jobs > 1:
        cpu = [statistics.median(p.cpu for p in side) for side in (a, b)]
        print(f" (CPU {cpu[0]:.1f} s and {cpu[1]:.1f} s)", end="")
    print()


@contextlib.contextmanager
def cluster(workers: int) -> Iterator[str]:
    """Start a Dask cluster of processes with one thread each."""
    from distributed import LocalCluster

    options = {"threads_per_worker": 1, "dashboard_address": ":0"}
    with LocalCluster(n_workers=workers, processes=True, **options) as found:
        yield found.scheduler_address


def dask() -> None:
    """Two Dask workers against one."""
    with cluster(1) as first, cluster(2) as second:
        one, two = Engine(dask=first), Engine(dask=second)
        for engine in (one, two):
            seconds(imposed(4000), engine)  # loads the kernel
        compared("one and two Dask workers", one, two)


def memory() -> None:
    """The most memory of a sweep of 100 000 draws, from the shell."""
    with tempfile.TemporaryDirectory() as folder:
        command = [
            *(sys.executable, "-m", "rcc_sim", "sweep", "r1t_epa", "--cycle", "udds"),
            *("--imposed", "--draw", str(DRAWS), "-o", f"{folder}/out.parquet"),
        ]
        subprocess.run(command, check=True, capture_output=True)
        size = Path(folder, "out.parquet").stat().st_size
    most = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss / 1024
    print(f"{DRAWS:,} draws, from the shell: {most:.0f} MB at most, a file of", end=" ")
    print(f"{size / 1e6:.0f} MB")


if __name__ == "__main__":
    main()
