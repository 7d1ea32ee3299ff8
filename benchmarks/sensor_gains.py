"""Sensors that read a per cent or two too much in drives without a cause.

    python -m benchmarks.sensor_gains --drives 10

The drives are of the blind plant, which shares no code with the model. Each is
diagnosed as it is, then with one column after the other scaled: who is blamed?
"""

from __future__ import annotations

import argparse
import tempfile
from collections import Counter
from dataclasses import replace
from pathlib import Path

from rcc_sim.analyse.logged import Logged, open_log
from rcc_sim.blind.make import make
from rcc_sim.definitions.vehicle import load_vehicle
from rcc_sim.diagnose.run import diagnose

GAINS = {
    "yaw_rate_radps": (0.98, 1.02, 1.03),
    "accel_x_mps2": (1.02,),
    "accel_y_mps2": (1.02,),
    "motor_current_a": (1.01,),
    "battery_voltage_v": (1.005,),
    "battery_current_a": (1.01,),
}
"""Column -> times the true value that it reads."""


def scaled(log: Logged, column: str, times: float) -> Logged:
    """Return a log one of whose columns reads some times as much."""
    columns = log.log.columns | {column: times * log.log[column]}
    return replace(log, log=replace(log.log, columns=columns))


def main() -> None:
    """Print a line a gain: in how many drives a cause is named, and which."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--drives", type=int, default=10)
    parser.add_argument("--seed", type=int, default=5)
    known = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name) / "drives"
        make(folder, cases=known.drives, kinds=("null",), seed=known.seed)
        cars = [load_vehicle(p) for p in sorted(folder.glob("*/vehicle.toml"))]
        paths = sorted(folder.glob("*/log.csv.gz"))
        logs = [open_log(p, car) for p, car in zip(paths, cars, strict=True)]
    tried = [("time_s", 1.0), *((c, x) for c, xs in GAINS.items() for x in xs)]
    for column, times in tried:
        drives = named = 0
        blamed: Counter[str] = Counter()
        for log, car in zip(logs, cars, strict=True):
            if column not in log.log:
                continue
            found = diagnose([scaled(log, column, times)], car).asserted
            drives += 1
            named += bool(found)
            blamed.update(one.cause.effect for one in found)
        what = f"{column} × {times:g}" if times != 1 else "as they are"
        print(
            f"{what}: {named} of {drives} drives name a cause {dict(blamed)}",
            flush=True,
        )


if __name__ == "__main__":
    main()
