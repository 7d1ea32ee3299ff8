"""How long `rccsim diagnose` takes from the shell, one drive after the other.

    python -m benchmarks.diagnosis_time [--cases 24] [--seed 4711]

The drives are of the blind plant: 75 s at 100 Hz of a scaled car, 600 s at 10 Hz of a
car, each without a cause, with one, with two, or with something of no library. Beside
the seconds stands how often the model could have been run along the drive meanwhile.
"""

from __future__ import annotations

import argparse
import subprocess
import sys
import tempfile
import time
from collections import defaultdict
from pathlib import Path

import numpy as np

from rcc_sim.analyse.logged import open_log
from rcc_sim.blind.make import labels_beside, make
from rcc_sim.blind.seal import opened
from rcc_sim.definitions.vehicle import load_vehicle
from rcc_sim.diagnose.residuals.posed import problem_of

RUNS = 5


def seconds_of(folder: Path) -> float:
    """Diagnose a drive from the shell."""
    words = "diagnose", folder / "log.csv.gz", "--vehicle", folder / "vehicle.toml"
    begun = time.perf_counter()
    done = subprocess.run(
        [sys.executable, "-m", "rcc_sim", *map(str, words), "--json"],
        capture_output=True,
        check=False,
    )
    if done.returncode not in (0, 1):
        raise RuntimeError(done.stderr.decode())
    return time.perf_counter() - begun


def run_of(folder: Path) -> float:
    """Run the model along a drive, in a process that has done so before."""
    car = load_vehicle(folder / "vehicle.toml")
    problem = problem_of(open_log(folder / "log.csv.gz", car).log, car)
    times = []
    for _ in range(RUNS):
        begun = time.perf_counter()
        problem.predict({})
        times.append(time.perf_counter() - begun)
    return min(times)


def main() -> None:
    """Make drives, diagnose each, and print a line for each sort."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--cases", type=int, default=24)
    parser.add_argument("--seed", type=int, default=4711)
    asked = parser.parse_args()
    took: dict[tuple[str, str], list[tuple[float, float]]] = defaultdict(list)
    with tempfile.TemporaryDirectory() as place:
        drives = Path(place) / "drives"
        make(drives, cases=asked.cases, seed=asked.seed)
        labels = opened(drives, labels_beside(drives))["cases"]
        folders = sorted(p for p in drives.iterdir() if p.is_dir())
        seconds_of(folders[0])  # compiles
        for folder in folders:
            label = labels[folder.name]
            sort = label["family"], label["kind"]
            took[sort].append((seconds_of(folder), run_of(folder)))
            print(f"{folder.name} {sort}: {took[sort][-1][0]:.1f} s", flush=True)
    for family in sorted({f for f, _ in took}):
        mine = {kind: rows for (f, kind), rows in took.items() if f == family}
        every = [row for rows in mine.values() for row in rows]
        for kind, rows in [*sorted(mine.items()), ("all", every)]:
            whole, one = np.transpose(rows)
            print(
                f"{family} {kind:8} {len(rows):3} drives: {np.median(whole):5.1f} s in "
                f"the median, {whole.max():5.1f} at most; as long as "
                f"{np.median(whole / one):5.0f} runs of the model"
            )


if __name__ == "__main__":
    main()
