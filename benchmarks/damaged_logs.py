"""How often a diagnosis stays right on logs as they come: lost rows, holes, spikes.

    rccsim blind make cases --cases 24 --seed 1 --labels cases.json
    python -m benchmarks.damaged_logs cases --labels cases.json --jobs 2

Each log is damaged in one way after the other, diagnosed with its vehicle as ever, and
scored against the sealed labels; the fresh drive stays whole. What a damage hides may
be missed; what it brings about must not be named.
"""

from __future__ import annotations

import argparse
import shutil
import tempfile
import time
import zlib
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pandas as pd

from rcc_sim.analyse.logcheck.finding import COMMANDS
from rcc_sim.blind.run import RESULTS, run
from rcc_sim.blind.score import score
from rcc_sim.blind.seal import read_seal

TIME = "time_s"
STRETCHES = 3
LASTS = 0.4, 4.0  # s; of a stretch, least and most
EPOCH = 1.76e9  # s; a clock that counts from 1970

Damage = Callable[[pd.DataFrame, np.random.Generator], pd.DataFrame]


def stretches(log: pd.DataFrame, rng: np.random.Generator) -> Iterator[np.ndarray]:
    """Yield the rows of some stretches of a log, as masks."""
    t = log[TIME].to_numpy()
    for _ in range(STRETCHES):
        start = rng.uniform(t[0], t[-1])
        yield (t >= start) & (t < start + rng.uniform(*LASTS))


def channels(log: pd.DataFrame) -> list[str]:
    """Return the columns that a sensor wrote: all but time and commands."""
    return [c for c in log.columns if c != TIME and c not in COMMANDS]


def fifth(log: pd.DataFrame, rng: np.random.Generator) -> pd.DataFrame:
    """Keep every fifth row."""
    return log.iloc[int(rng.integers(5)) :: 5]


def lost(log: pd.DataFrame, rng: np.random.Generator) -> pd.DataFrame:
    """Lose a tenth of the rows."""
    return log[rng.random(len(log)) > 0.1]


def holes(log: pd.DataFrame, rng: np.random.Generator) -> pd.DataFrame:
    """Lose stretches of rows."""
    return log[~np.any(list(stretches(log, rng)), axis=0)]


def _nothing(log: pd.DataFrame, names: list[str], rng: np.random.Generator) -> None:
    for name in names:
        for rows in stretches(log, rng):
            log.loc[rows, name] = np.nan


def silent(log: pd.DataFrame, rng: np.random.Generator) -> pd.DataFrame:
    """Each sensor is silent for stretches of its own."""
    _nothing(log, channels(log), rng)
    return log


def untold(log: pd.DataFrame, rng: np.random.Generator) -> pd.DataFrame:
    """Each command misses for stretches of its own."""
    _nothing(log, [c for c in COMMANDS if c in log], rng)
    return log


def frozen(log: pd.DataFrame, rng: np.random.Generator) -> pd.DataFrame:
    """Each sensor repeats a reading for stretches of its own."""
    for name in channels(log):
        for rows in stretches(log, rng):
            if rows.any():
                log.loc[rows, name] = log.loc[rows, name].iloc[0]
    return log


def spikes(log: pd.DataFrame, rng: np.random.Generator) -> pd.DataFrame:
    """Three readings of a thousand are far out."""
    for name in channels(log):
        x = log[name].to_numpy(copy=True)
        out = rng.random(len(x)) < 0.003
        x[out] += rng.choice((-3.0, 3.0), out.sum()) * (np.ptp(x) + 1.0)
        log[name] = x
    return log


def jitter(log: pd.DataFrame, rng: np.random.Generator) -> pd.DataFrame:
    """Rows are stamped late or early by a fifth of their interval."""
    t = log[TIME].to_numpy()
    off = 0.2 * np.median(np.diff(t)) * rng.standard_normal(len(t))
    log[TIME] = np.sort(np.round(t + off, 6))
    return log


def twice(log: pd.DataFrame, rng: np.random.Generator) -> pd.DataFrame:
    """One row in twenty is written twice."""
    rows = np.repeat(np.arange(len(log)), 1 + (rng.random(len(log)) < 0.05))
    return log.iloc[rows]


def swapped(log: pd.DataFrame, rng: np.random.Generator) -> pd.DataFrame:
    """One row in fifty comes after its successor."""
    rows = np.arange(len(log), dtype=float)
    rows[rng.random(len(log)) < 0.02] += 1.5
    return log.iloc[np.argsort(rows)]


def epoch(log: pd.DataFrame, rng: np.random.Generator) -> pd.DataFrame:
    """Let the clock count from 1970."""
    log[TIME] = np.round(log[TIME] + EPOCH + rng.uniform(0.0, 1e6), 4)
    return log


def coarse(log: pd.DataFrame, rng: np.random.Generator) -> pd.DataFrame:
    """Round each sensor to steps of four times what it scatters from row to row."""
    for name in channels(log):
        x = log[name].to_numpy()
        step = 4.0 * np.median(np.abs(np.diff(x, 2))) / 1.65
        log[name] = np.round(x / step) * step if step > 0.0 else x
    return log


def without(*names: str) -> Damage:
    """Return a damage that lacks some columns."""
    return lambda log, _: log.drop(columns=list(names), errors="ignore")


DAMAGES: dict[str, Damage] = {
    "as it is": lambda log, _: log,
    "every fifth row": fifth,
    "a tenth lost": lost,
    "holes": holes,
    "silent sensors": silent,
    "silent commands": untold,
    "frozen sensors": frozen,
    "spikes": spikes,
    "jitter": jitter,
    "rows twice": twice,
    "rows swapped": swapped,
    "clock of 1970": epoch,
    "coarse steps": coarse,
    "no accelerometers": without("accel_x_mps2", "accel_y_mps2"),
    "no gyro": without("yaw_rate_radps"),
    "no voltage": without("battery_voltage_v"),
    "no motor current": without("motor_current_a"),
}


def damaged(cases: Path, to: Path, how: str) -> None:
    """Write a folder of cases again, each log damaged."""
    shutil.copytree(cases, to, ignore=shutil.ignore_patterns(RESULTS))
    for name in read_seal(to)["cases"]:
        rng = np.random.default_rng(zlib.crc32(f"{name} {how}".encode()))
        path = to / name / "log.csv.gz"
        DAMAGES[how](pd.read_csv(path), rng).to_csv(path, index=False)


COUNTED = {
    "failed": lambda s: f"{s['ran']['of'] - s['ran']['hits']}",
    "first": lambda s: _of(s["single_first"]),
    "alone": lambda s: _of(s["single_exact"]),
    "both": lambda s: _of(s["pair_exact"]),
    "named in none": lambda s: _of(s["null_false_alarm"]),
    "named outside": lambda s: _of(s["unknown_falsely_named"]),
    "intervals hold": lambda s: _of(s["interval_coverage"]),
    "fresh mended": lambda s: _of(s["fresh_energy_shrank"]),
}


def _of(share: dict[str, float]) -> str:
    return f"{share['hits']}/{share['of']}"


def main() -> None:
    """Print a line for each damage."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("cases", type=Path)
    parser.add_argument("--labels", type=Path, required=True)
    parser.add_argument("--how", nargs="*", choices=DAMAGES, default=list(DAMAGES))
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--out", type=Path, help="Folder that keeps logs and answers.")
    asked = parser.parse_args()
    print("| log | " + " | ".join(COUNTED) + " | seconds |")
    print("|---" * (len(COUNTED) + 2) + "|")
    with tempfile.TemporaryDirectory() as scratch:
        for how in asked.how:
            folder = (asked.out or Path(scratch)) / how.replace(" ", "_")
            damaged(asked.cases, folder, how)
            start = time.perf_counter()
            lines = list(run(folder, jobs=asked.jobs))
            each = (time.perf_counter() - start) / max(len(lines), 1)
            shares = score(folder, asked.labels)["shares"]
            figures = [show(shares) for show in COUNTED.values()]
            print(f"| {how} | " + " | ".join(figures) + f" | {each:.1f} |", flush=True)


if __name__ == "__main__":
    main()
