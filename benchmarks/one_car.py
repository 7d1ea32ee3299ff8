"""Many drives of one car of the blind plant, an effect of a chosen strength withheld.

    python -m benchmarks.one_car FOLDER --logs 24 --effect rolling_resistance --of 0.002

`rccsim blind make` draws effects that a single drive shows; here the same plant, drives
and sensors make logs that are each too weak, so that they must be read together.
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from rcc_sim.blind import sensors
from rcc_sim.blind.bases import BASES, moved, stated, truth
from rcc_sim.blind.case import HIDES, logged_columns, sound
from rcc_sim.blind.drives import STYLES, TIMING, Road, drive
from rcc_sim.blind.make import packed
from rcc_sim.blind.nominal import vehicle_text
from rcc_sim.blind.plant import CLOCK
from rcc_sim.blind.worth import fine

PLANT = {
    "rolling_resistance": "C_rr",
    "headwind": "wind",
    "drivetrain_friction": "dry",
    "auxiliary_load": "P_aux",
    "battery_resistance": "R_i",
    "road_grade": "slope",
    "steering_offset": "steer_offset",
}
"""Effect -> its figure in the plant, added to what the car has."""


def main() -> None:
    """Write a folder of logs and the vehicle file that misses the effect."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--logs", type=int, default=24)
    parser.add_argument("--effect", default="", choices=["", *PLANT])
    parser.add_argument("--of", type=float, default=0.0)
    parser.add_argument("--spread", type=float, default=0.0)
    parser.add_argument("--base", default="slash", choices=[b.name for b in BASES])
    parser.add_argument("--seconds", type=float, default=30.0)
    parser.add_argument("--seed", type=int, default=0)
    known = vars(parser.parse_args())
    write(known.pop("folder"), known.pop("logs"), **known)


def write(
    folder: Path,
    logs: int,
    *,
    effect: str = "",
    of: float = 0.0,
    spread: float = 0.0,
    base: str = "slash",
    seconds: float = 30.0,
    seed: int = 0,
) -> None:
    """Write vehicle.toml and logs/NNNN.csv.gz; ``spread`` is the strength's own sd."""
    (folder / "logs").mkdir(parents=True, exist_ok=True)
    rng = np.random.default_rng([seed, 1])
    start = next(b for b in BASES if b.name == base)
    car = moved(start, rng)
    file = stated(car, rng)[0]
    hidden = {HIDES[effect]} if effect in HIDES else set()
    text = vehicle_text(folder.name, file, hidden)
    (folder / "vehicle.toml").write_text(text, encoding="utf-8")
    bias = sensors.constants(car.family, rng)
    for k in range(logs):
        one = np.random.default_rng([seed, 2, k])
        strength = of + spread * one.standard_normal()
        data = next(_driven(car, file, bias, effect, strength, seconds, one))
        (folder / "logs" / f"{k:04d}.csv.gz").write_bytes(packed(data))


def _driven(
    car: Any,
    file: Any,
    bias: dict[str, float],
    effect: str,
    strength: float,
    seconds: float,
    rng: np.random.Generator,
) -> Iterator[dict[str, Any]]:
    how = TIMING[car.family]
    while True:
        road = Road(
            slope=np.zeros(2),
            aux=np.zeros(1),
            wind=np.zeros(1),
            rough=float(rng.uniform(*how.rough)),
            rough_s=float(rng.uniform(*how.rough_s)),
        )
        p = truth(car, file.r_w)
        if effect in HIDES:
            p = p._replace(**{PLANT[effect]: strength})
        elif effect:
            name = PLANT[effect]
            p = p._replace(**{name: getattr(p, name) + strength})
        style = str(rng.choice(list(STYLES[car.family])))
        d = drive(car, road, style, rng)[0]
        last = math.ceil(seconds / CLOCK) + 2
        rows = np.asarray(d.rows)
        keep = rows * (how.tick / how.substeps) < seconds
        d = d._replace(ref=d.ref[:last], steer=d.steer[:last], rows=rows[keep])
        found, _ = fine(p, d, car.family)
        scaled = found.copy()
        scaled[-1, 8] *= how.seconds / seconds
        if not sound(scaled, car, p.mu) or np.abs(found[:, 0]).max() <= 0:
            continue
        time = np.asarray(d.rows) * (how.tick / how.substeps)
        read = sensors.sensed(car.family, found, bias, rng)
        there = sensors.arrived(len(found), rng)
        yield logged_columns(car.family, time, read, there, d, surveyed=False)


if __name__ == "__main__":
    main()
