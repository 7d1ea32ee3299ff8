"""Effects withheld from measured cars: what the diagnosis makes of them.

A BMW i3 whose heater and air conditioning are hidden, a Twizy whose altitude is, the
DART car without its friction, its throttle's dead zone or its steering's lag, and
Nigel, whose wheels point straight ahead at a steering command of 0.2.

    python -m benchmarks.real_cars [FOLDER] [bmw] [twizy] [dart] [nigel] [--jobs N]

FOLDER holds real_ev/ and real_rc/ as their SOURCES.md describe.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter1d, median_filter

from rcc_sim.analyse.heading import seen_heading, turn_at
from rcc_sim.analyse.logged import open_log
from rcc_sim.definitions.vehicle import Vehicle, load_vehicle
from rcc_sim.diagnose.deliver import acting
from rcc_sim.diagnose.diagnosis import Diagnosis
from rcc_sim.diagnose.fitting import descent
from rcc_sim.diagnose.fitting.engine import Engine
from rcc_sim.diagnose.fitting.knobs import nuisance_knobs
from rcc_sim.diagnose.residuals.posed import problem_of
from rcc_sim.diagnose.residuals.problem import Problem
from rcc_sim.diagnose.run import diagnose
from rcc_sim.physics.effects.road_load import road_load_force
from rcc_sim.trace import Trace

Array = NDArray[np.float64]

DATA = Path(__file__).resolve().parents[2] / "shared/data"
CARS = ("bmw", "twizy", "dart", "nigel")
LOAD = "auxiliary_load"
MINUTE = 600  # rows of a BMW's log
STRETCH = 2000.0  # m over which climbs are compared
GLITCH = 80.0  # m; a climb of a stretch beyond it is the altimeter's fault
STEEP = 0.2  # a slope beyond it is, too
STEP, EVEN = 50.0, 1000.0  # m; distance over which heights are evened out, at its steps
SPEEDS = (0.5, 1.0, 1.5, 2.0)  # m/s at which a coast friction is judged, if reached
STRAIGHT = ("road_load", "throttle_dead_zone", "accelerometer_bias", "motor_lag")
TURNING = ("steering_lag", "sensor_delay")
NIGEL, FULL = Path(__file__).with_name("nigel.toml"), 0.5236  # rad at a command of 1
FRICTION = (1.266, 0.7393, -0.1123)  # N, N s/m, N s²/m²; as published


def told(found: Diagnosis) -> str:
    """The causes, the first with what ties with it."""
    words = [a.cause.effect + "~" * len(a.cause.tied) for a in found.asserted]
    return "+".join(words) or found.status


def bmw(path: Path) -> str:
    """A trip with heater and air conditioning hidden."""
    car = load_vehicle("bmw_i3")
    found = diagnose([open_log(path, car, hide=["aux_power_w"])], car)
    log = open_log(path, car).log
    heater, time = log["aux_power_w"], log["time_s"]
    row = f"{path.name[:7]}  {np.nanmean(heater):5.0f} W  {told(found):40}"
    load = next((a.cause for a in found.asserted if a.cause.effect == LOAD), None)
    if load is not None and load.profiles:
        known = np.isfinite(heater)
        stated = car.figures()[load.keys[0]].value
        at = found.found.engine.problems[0].log["time_s"]
        estimate = np.interp(time, at, acting(found, load)[0] - stated)[known]
        alike, slowly = (
            np.corrcoef(means(estimate, n), means(heater[known], n))[0, 1]
            for n in (1, MINUTE)
        )
        bias = float(np.mean(estimate - heater[known]))
        row += f"correlation {alike:5.3f}, by minutes {slowly:5.3f}  "
        row += f"bias {bias:+5.0f} W  "
    before, after = found.proof.before or 0.0, found.proof.after or 0.0
    return row + f"energy {before:+5.1f} -> {after:+5.2f} %"


def means(x: Array, rows: int) -> Array:
    """Means over so many rows at a time."""
    return x[: len(x) // rows * rows].reshape(-1, rows).mean(axis=1)


def twizy(path: Path) -> str:
    """A trip with its altitude hidden, and known."""
    car = load_vehicle("twizy")
    hidden = open_log(path, car, hide=["elevation_m"])
    found = diagnose([hidden], car)
    row = f"{path.name[:15]:15}  hidden: {told(found):16}"
    log = open_log(path, car).log
    row += f"known: {told(diagnose([open_log(path, car)], car)):10}"
    plain = problem_of(hidden.log, car)
    s = np.interp(log["time_s"], plain.log["time_s"], plain.distance)
    s = np.maximum.accumulate(s + 1e-9 * np.arange(len(s)))
    at = np.arange(s[0], s[-1], STEP)
    rough = gaussian_filter1d(median_filter(log["elevation_m"], 31), 5)
    rough = np.interp(at, s, rough)
    even = gaussian_filter1d(rough, EVEN / STEP)
    row += f"altimeter suits best at {suits(plain, at, rough):4.2f}, "
    row += f"evened out over 1 km at {suits(plain, at, even):4.2f}  "
    profile = next((a.cause.profiles.get(0) for a in found.asserted), None)
    if profile is not None and profile.along == "distance_m":
        mine = np.cumsum(profile.at(at)) * STEP
        row += f"climbs of 2 km: {against(mine, rough)}, evened {against(mine, even)}  "
        row += f"ends {mine[-1]:+.0f} m up, altimeter {rough[-1] - rough[0]:+.0f}"
    return row


def suits(plain: Problem, at: Array, height: Array) -> float:
    """Scale at which a road of measured heights explains a log best."""
    slope = np.gradient(height, at)
    slope[np.abs(slope) > STEEP] = 0.0

    def score(scale: float) -> float:
        one = plain.on_road(at, scale * slope)
        return descent.fit(Engine([one]), {}, nuisance_knobs([one])).score

    return max(np.arange(0.2, 1.5, 0.2), key=score)


def against(mine: Array, height: Array) -> str:
    """Climbs of estimated heights, held against those of measured ones."""
    every = round(STRETCH / STEP)
    true, found = np.diff(height[::every]), np.diff(mine[::every])
    sound = np.abs(true) < GLITCH
    cov = np.cov(true[sound], found[sound])
    alike = cov[0, 1] / np.sqrt(cov[0, 0] * cov[1, 1])
    return f"slope {cov[0, 1] / cov[0, 0]:4.2f}, correlation {alike:4.2f}"


def dart(paths: Sequence[Path], withheld: str) -> str:
    """One run, or several at once, with one effect withheld."""
    car = load_vehicle("dart_jetracer").changed(without=(withheld,))
    logs = [open_log(path, car) for path in paths]
    found = diagnose(logs, car, withheld=[withheld])
    first_one = paths[0]
    name = f"{len(paths)} of {first_one.parent.name}" if paths[1:] else first_one.name
    row = f"{name[:44]:44}  {withheld:18}  {told(found):32}"
    if withheld == "sensor_delay" and not paths[1:] and "yaw_rad" in logs[0].log:
        row += f"gyro against motion capture {gyro_shift(logs[0].log):.3f} s  "
    first = next((a for a in found.asserted), None)
    if first is None or first.cause.effect != withheld:
        if withheld in found.not_identifiable:
            return row + "called not identifiable"
        tied = first is not None and withheld in first.cause.tied
        return row + ("in the tie" if tied else "")
    values = {k: e.value for k, e in first.figures.items()}
    if withheld != "road_load":
        return row + ", ".join(f"{k} {x:.3f}" for k, x in values.items())
    mine = [values.get(k, 0.0) for k in ("a_n", "b_n_s_per_m", "c_n_s2_per_m2")]
    fastest = max(float(np.nanmax(one.log["speed_mps"])) for one in logs)
    reached = [v for v in SPEEDS if v < fastest]
    forces = [
        [road_load_force(v, v, *abc) for abc in (mine, FRICTION)] for v in reached
    ]
    ratios = [a / b for a, b in forces]
    return row + "of the published force " + " ".join(f"{x:.2f}" for x in ratios)


def nigel(paths: Sequence[Path]) -> str:
    """One run, or all at once: the trim and the gain of a steering by its command."""
    car = load_vehicle(str(NIGEL))
    found = diagnose([open_log(path, car) for path in paths], car)
    row = f"{', '.join(p.name.split('.')[0] for p in paths)[:24]:24}  {told(found):40}"
    for one in found.asserted:
        for key, x in one.figures.items():
            row += f"{key} {x.value:.3f} ({x.low:.3f} to {x.high:.3f})  "
    command, angle = np.transpose([kinematic(path, car) for path in paths])
    if not paths[1:]:
        return row + f"by its circle {angle[0] - FULL * command[0]:.3f} rad"
    slope, trim = np.polyfit(command, angle, 1)
    return row + f"by their circles {trim:.3f} rad, {slope / FULL:.2f}"


def kinematic(path: Path, car: Vehicle) -> tuple[float, float]:
    """Steering command that a run drove by, and the angle of its circle: r l / v."""
    log = open_log(path, car).log
    v, r = log["speed_mps"], log["yaw_rate_radps"]
    moves = v > 0.5 * np.nanmax(v)
    curvature = float(np.nansum(r[moves]) / np.nansum(v[moves]))
    asked = log["steering"][np.isfinite(log["steering"])]
    command = asked[np.argmax(np.abs(asked))]
    return float(command), float(np.arctan(curvature * car.wheelbase))


def gyro_shift(log: Trace) -> float:
    """Shift [s] at which a gyro and the turn of a measured heading differ least."""
    time, gyro = log["time_s"], log["yaw_rate_radps"]
    turn, rows = turn_at(time, seen_heading(log)), np.isfinite(gyro)
    sound = np.isfinite(turn)

    def differ(shift: float) -> float:
        there = np.interp(time[rows] - shift, time[sound], turn[sound])
        return float(np.median(np.abs(gyro[rows] - there)))

    return min(np.arange(0.0, 0.2, 0.005), key=differ)


def runs(folder: Path, which: list[str]) -> list[tuple[Callable[..., str], tuple]]:
    """Every log with what is to be done with it."""
    ev, rc = folder / "real_ev", folder / "real_rc/dart_jetracer"
    out: list[tuple[Callable[..., str], tuple]] = []
    if "bmw" in which:
        out += [(bmw, (p,)) for p in sorted((ev / "bmw_i3_tum").glob("Trip*.csv.gz"))]
    if "twizy" in which:
        out += [(twizy, (p,)) for p in sorted((ev / "twizy_rsk").glob("T*.csv.gz"))]
    if "nigel" in which:
        bags = tuple(sorted((folder / "real_rc").glob("nigel*/*.bag.gz")))
        out += [(nigel, (some,)) for some in [*((p,) for p in bags), bags]]
    if "dart" in which:
        folders = [tuple(sorted(rc.glob(f"{d}/*.csv"))) for d in ("10_*", "19_*")]
        for effect in STRAIGHT:
            out += [(dart, ((p,), effect)) for steps in folders for p in steps]
            out += [(dart, (steps, effect)) for steps in folders]
        turns = [p for d in ("30_*", "40_*") for p in sorted(rc.glob(f"{d}/*.csv"))]
        cameras = ("50_*", "70_*", "81_*", "battery_pair", "rosbag1")
        seen = [p for d in cameras for p in rc.glob(f"{d}/*.gz")]
        for effect in TURNING:
            out += [(dart, ((p,), effect)) for p in [*turns, *sorted(seen)]]
    return out


def main() -> None:
    """Diagnose every log and print a line each."""
    words = sys.argv[1:]
    jobs = int(words[words.index("--jobs") + 1]) if "--jobs" in words else 2
    which = [w for w in words if w in CARS]
    folders = [Path(w) for w in words if Path(w).is_dir()]
    todo = runs(folders[0] if folders else DATA, which or list(CARS))
    os.environ["OPENBLAS_NUM_THREADS"] = "1"
    with ProcessPoolExecutor(jobs) as pool:
        for row in [pool.submit(do, *args) for do, args in todo]:
            print(row.result(), flush=True)


if __name__ == "__main__":
    main()
