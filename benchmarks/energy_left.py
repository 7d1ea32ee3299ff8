"""What a fresh drive leaves of its energy gap, beside what nobody could know.

    rccsim blind make cases --cases 60 --seed 1 --labels cases.json
    python -m benchmarks.energy_left cases --labels cases.json --family rc

Each drive with a cause is diagnosed, and its mended file judged on the fresh drive: how
much of the energy is then missing; how much by what the fit itself does not know, to
first order sqrt(g' C g) with g the slope of the gap over the fit's figures and C their
covariance; and how much had the true figures been known, which is rough road and noise.
"""

from __future__ import annotations

import argparse
import json
import tempfile
from pathlib import Path

import numpy as np

from rcc_sim.analyse.gap import gap
from rcc_sim.analyse.logged import open_log
from rcc_sim.definitions.vehicle import Vehicle, load_vehicle
from rcc_sim.diagnose.deliver import write_mended
from rcc_sim.diagnose.fitting.fit import Fit
from rcc_sim.diagnose.run import diagnose
from rcc_sim.errors import InputError

STEP = 0.5
"""Of a figure's standard deviation, by which it is moved for a slope."""

DRAWS = 2000


def gap_of(fresh: Path, car: Vehicle) -> float:
    """Return the gap of a drive's energy. [%]"""
    return gap(open_log(fresh, car), car).energy.gap_percent or 0.0


def unsure(fresh: Path, car: Vehicle, fit: Fit) -> float:
    """Return the standard deviation of a gap by what a fit does not know. [%]"""
    at, stated = gap_of(fresh, car), car.figures()
    spread = np.linalg.pinv(fit.information)
    slopes = np.zeros(len(fit.knobs))
    for j, knob in enumerate(fit.knobs):
        if knob.key not in stated:  # an offset or a gain of a sensor
            continue
        for way in (STEP, -STEP):
            h = way * spread[j, j] ** 0.5
            try:
                moved = car.changed(settings={knob.key: stated[knob.key].value + h})
                slopes[j] = (gap_of(fresh, moved) - at) / h
                break
            except InputError:  # no vehicle has that figure
                continue
    return float(np.sqrt(slopes @ spread @ slopes))


def main() -> None:
    """Print a line a drive, and the medians."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("cases", type=Path)
    parser.add_argument("--labels", type=Path, required=True)
    parser.add_argument("--family", default="rc")
    parser.add_argument("--most", type=int, default=30)
    known = parser.parse_args()
    labels = json.loads(known.labels.read_text())["cases"]
    rows = []
    for name, label in labels.items():
        if len(rows) == known.most:
            break
        chance = (label.get("fresh") or {}).get("gap_by_chance_percent")
        if label["family"] != known.family or not label["effects"] or chance is None:
            continue
        folder = known.cases / name
        car = load_vehicle(folder / "vehicle.toml")
        found = diagnose([open_log(folder / "log.csv.gz", car)], car)
        if not found.asserted:
            continue
        with tempfile.TemporaryDirectory() as where:
            write_mended(found, Path(where) / "mended.toml")
            mended = load_vehicle(Path(where) / "mended.toml")
        fresh = folder / "fresh.csv.gz"
        row = gap_of(fresh, mended), unsure(fresh, mended, found.fit), chance
        rows.append(row)
        causes = ", ".join(a.cause.effect for a in found.asserted)
        print(
            f"{name}  {row[0]:+6.2f} %  unsure by {row[1]:.2f} %, "
            f"by chance {row[2]:+.2f} %  {causes}",
            flush=True,
        )
    left, sd, chance = np.array(rows).T
    drawn = np.random.default_rng(0).normal(size=(DRAWS, len(sd))) * sd + chance
    print(f"{len(rows)} drives: median size left {np.median(np.abs(left)):.2f} %")
    print(f"by chance {np.median(np.abs(chance)):.2f} %, unsure {np.median(sd):.2f} %")
    print(f"both together would leave {np.median(np.abs(drawn)):.2f} %")


if __name__ == "__main__":
    main()
