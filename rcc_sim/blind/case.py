"""One case: a true vehicle, its nominal file, two drives, and what is written."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rcc_sim.blind import sensors
from rcc_sim.blind.answers import SAME
from rcc_sim.blind.bases import (
    BASES,
    KEPT,
    TOLERANCES,
    WEIGHTS,
    Base,
    moved,
    stated,
    truth,
)
from rcc_sim.blind.drives import (
    STYLES,
    TIMING,
    Road,
    again,
    drive,
    hills,
    smooth,
)
from rcc_sim.blind.label import acting, by_chance, over_file, profiles
from rcc_sim.blind.nominal import vehicle_text
from rcc_sim.blind.plant import CLOCK, GRAVITY, Drive, Truth
from rcc_sim.blind.strengths import HILLS_LENGTH, Scene, Withheld, draws
from rcc_sim.blind.unknowns import UNKNOWNS
from rcc_sim.blind.worth import Yardstick, coarse, fine

Array = NDArray[np.float64]
OFTEN = dict.fromkeys(
    (
        "drivetrain_damping",
        "drivetrain_friction",
        "copper_loss",
        "iron_loss",
        "auxiliary_load",
        "battery_resistance",
        "regeneration_limit",
        "payload",
        "rolling_resistance",
        "aerodynamic_drag",
        "road_grade",
        "headwind",
    ),
    2.5,
) | {"road_grade": 6.0, "auxiliary_load": 4.0, "slippery_patch": 6.0}
"""Effects drawn more often than the others: those that cost energy, or vary."""
LEAST_NATS = 30.0  # what an effect must be worth beyond the tolerances
TRIES = 40  # draws of an effect before another car is drawn
SURVEYED = 0.45  # 1; share of cases whose road was surveyed
HILLY = 0.2  # 1; share of surveyed roads that are not level
NO_SLIDE = 0.93  # 1; most lateral acceleration, of what the tyres can hold

# which stated figure an effect hides, where the file would have it
HIDES = {
    "drivetrain_damping": "visc",
    "rotor_inertia": "J",
    "copper_loss": "R_phase",
    "rolling_resistance": "C_rr",
    "aerodynamic_drag": "drag_area",
    "speed_dead_zone": "dead_zone",
    "regeneration_limit": "regen",
    "battery_resistance": "R_i",
}


@dataclass(frozen=True)
class Case:
    """What is written of one case."""

    vehicle: str
    logs: dict[str, dict[str, Array]]
    label: dict[str, Any]


@dataclass(frozen=True)
class Setting:
    """A car on its road, before an effect is chosen."""

    car: Base
    file: Base
    pulls: dict[str, float]
    p: Truth
    road: Road
    drive: Drive
    surveyed: bool


class Unfit(Exception):
    """A draw that will not do; another is made."""


def make_case(
    name: str,
    kind: str,
    rng: np.random.Generator,
    families: Sequence[str],
    base: Base | None = None,
    asked: Sequence[str] = (),
    repeats: int = 0,
) -> Case:
    """Draw one case of a kind: ``single``, ``pair``, ``null`` or ``unknown``.

    If effects are ``asked`` for, one of them acts; in a pair, beside any other. The
    drive is repeated so many times.
    """
    while True:
        family = base.family if base else str(rng.choice(list(families)))
        try:
            setting = _setting(family, kind, rng, base)
            effects, nats = _effects(setting, kind, rng, asked)
            return _recorded(name, kind, setting, effects, nats, rng, repeats)
        except Unfit:
            continue


def _setting(
    family: str, kind: str, rng: np.random.Generator, base: Base | None
) -> Setting:
    if base is None:
        choice = [b for b in BASES if b.family == family]
        weights = np.array([WEIGHTS[b.name] for b in choice])
        base = choice[int(rng.choice(len(choice), p=weights / weights.sum()))]
    car = moved(base, rng)
    file, _, pulls = stated(car, rng)
    how = TIMING[family]
    surveyed = kind == "unknown" or rng.random() < SURVEYED
    slope = np.zeros(2)
    if surveyed and family == "ev" and rng.random() < HILLY:
        slope = hills(HILLS_LENGTH, float(rng.uniform(0.004, 0.012)), rng)
    road = Road(
        slope=slope,
        aux=np.zeros(1),
        wind=np.zeros(1),
        rough=float(rng.uniform(*how.rough)),
        rough_s=float(rng.uniform(*how.rough_s)),
    )
    style = str(rng.choice(list(STYLES[family])))
    return Setting(
        car, file, pulls, truth(car, file.r_w), road, drive(car, road, style, rng)[0],
        bool(surveyed),
    )  # fmt: skip


def replaced(p: Truth, changes: Mapping[str, Any]) -> Truth:
    """Return the truth with some figures replaced."""
    return p._replace(**changes)


def with_effects(
    p: Truth, road: Road, d: Drive, effects: Sequence[Withheld], off: Sequence[Withheld]
) -> tuple[Truth, Drive]:
    """Return the truth and the drive with some effects on and others off."""
    slope, aux, wind = road.slope, road.aux, road.wind
    for w in off:
        p = replaced(p, w.off)
    for w in effects:
        changes = {
            k: v / w.off[k] * getattr(p, k)
            if k in ("m", "I_z", "C_F", "C_R") and w.off.get(k)
            else v
            for k, v in w.on.items()
        }
        p = replaced(p, changes)
        slope = w.slope if w.slope is not None else slope
        aux = w.aux if w.aux is not None else aux
        wind = w.wind if w.wind is not None else wind
    return p, d._replace(slope=slope, aux=aux, wind=wind)


def _read(rows: Array, family: str, effects: Sequence[Withheld]) -> Array:
    """Return the rows with what effects of a sensor do to them."""
    rows = rows.copy()
    for w in effects:
        for channel, (scale, bias) in w.sensor.items():
            place = sensors.SENSORS[family][channel].place
            rows[:, place] = rows[:, place] * scale + bias
    return rows


def _effects(
    at: Setting, kind: str, rng: np.random.Generator, asked: Sequence[str] = ()
) -> tuple[list[Withheld], dict[str, float]]:
    """Draw what acts, strong enough to be seen; and what it is worth. [nats]"""
    family = at.car.family
    if kind == "null":
        return [], {}
    level = smooth(at.drive)
    most = coarse(at.p, level, family)[:, 4]
    scene = Scene(
        at.car, at.p, float(most.max()), float(max(-most.min(), 0.0) * at.p.K_t)
    )
    lossy = at.car.loss > 0
    pool = UNKNOWNS if kind == "unknown" else draws(family, lossy, asked)
    names = [n for n in pool if not (n == "road_grade" and at.surveyed)]
    weights = np.array([OFTEN.get(n, 1.0) for n in names])
    weights /= weights.sum()
    count = 2 if kind == "pair" else 1
    for _ in range(TRIES):
        chosen = [str(n) for n in rng.choice(names, count, replace=False, p=weights)]
        if any(len(tied & set(chosen)) > 1 for tied in SAME):
            continue
        if len({"cg_shift", "payload", "wheel_radius"} & set(chosen)) > 1:
            continue
        if asked and kind != "unknown" and not set(asked) & set(chosen):
            continue
        effects = [pool[n](scene, rng) for n in chosen]
        nats = _worth(at, level, effects)
        if all(v >= LEAST_NATS for v in nats.values()):
            return effects, nats
    raise Unfit


def _worth(at: Setting, level: Drive, effects: list[Withheld]) -> dict[str, float]:
    """Return what each effect is worth beyond tolerances and the other one. [nats]"""
    family = at.car.family
    p, d = with_effects(at.p, at.road, level, effects, [])
    whole = _read(coarse(p, d, family), family, effects)
    if not sound(whole, at.car, p.mu):
        return {w.effect: 0.0 for w in effects}
    hidden = {HIDES.get(w.effect) for w in effects}
    known = [n for n in TOLERANCES if n not in hidden and getattr(at.car, n) > 0]
    p, d = with_effects(at.p, at.road, level, [], effects)
    rough = at.drive._replace(slope=d.slope, aux=d.aux, wind=d.wind)
    residual = coarse(p, rough, family) - coarse(p, d, family)
    rule = Yardstick(family, p, d, known, residual)
    changes = []
    for w in effects:
        rest = [o for o in effects if o is not w]
        p, d = with_effects(at.p, at.road, level, rest, [w])
        changes.append(whole - _read(coarse(p, d, family), family, rest))
    return {
        w.effect: rule.nats(changes[k], [c for j, c in enumerate(changes) if j != k])
        for k, w in enumerate(effects)
    }


def sound(rows: Array, car: Base, mu: float) -> bool:
    """Tell whether a drive stayed on the road: finite, no spin, no slide, no stall."""
    if not np.isfinite(rows).all():
        return False
    if np.abs(rows[:, 3]).max() > NO_SLIDE * mu * GRAVITY:
        return False
    still_turning = np.abs(rows[:, 1]).max() < (3.0 if car.family == "rc" else 0.8)
    a_y = np.abs(rows[:, 3]).max() < (9.0 if car.family == "rc" else 6.0)
    moved_on = rows[-1, 8] > 8.0 * TIMING[car.family].seconds / 75.0
    return bool(still_turning and a_y and moved_on)


def _recorded(
    name: str,
    kind: str,
    at: Setting,
    effects: list[Withheld],
    nats: dict[str, float],
    rng: np.random.Generator,
    repeats: int,
) -> Case:
    """Drive twice, and repeat the first; read the sensors, write file and label."""
    family = at.car.family
    other = drive(at.car, at.road, str(rng.choice(list(STYLES[family]))), rng)[0]
    bias = sensors.constants(family, rng)
    logs, windows, energy, distance = {}, {}, {}, {}
    for part, programme in _parts(at, other, repeats, rng):
        p, d = with_effects(at.p, at.road, programme, effects, [])
        rows, books = fine(p, d, family)
        if not sound(rows, at.car, p.mu):
            raise Unfit
        how = TIMING[family]
        time = np.asarray(d.rows) * (how.tick / how.substeps)
        read = sensors.sensed(family, _read(rows, family, effects), bias, rng)
        keep = sensors.arrived(len(rows), rng)
        logs[part] = logged_columns(family, time, read, keep, d, at.surveyed)
        if part not in ("log", "fresh"):
            continue
        windows[part] = acting(time, rows[:, 9]) if kind == "unknown" else []
        energy[part] = books["battery"] / 3600.0
        distance[part] = float(rows[-1, 8])
        if part == "fresh":
            level = _read(fine(p, smooth(d), family)[0], family, effects)
            chance = by_chance(time, level, read)
    hidden = {HIDES[w.effect] for w in effects if w.effect in HIDES}
    hidden |= {name for w in effects for name in w.off if name in KEPT.values()}
    if kind == "unknown" and not windows["log"]:
        raise Unfit
    label = {
        "family": family,
        "kind": kind,
        "effects": [] if kind == "unknown" else [w.effect for w in effects],
        "magnitudes": {w.effect: w.magnitudes for w in effects},
        "over_file": over_file(at.car, at.file, effects),
        "nats_beyond_tolerances": {k: round(v, 1) for k, v in nats.items()},
        "energy_wh": energy["log"],
        "distance_m": distance["log"],
        "fresh": {
            "energy_wh": energy["fresh"],
            "distance_m": distance["fresh"],
            "gap_by_chance_percent": chance,
        },
        "base": at.car.name,
        "surveyed": at.surveyed,
        "hilly": bool(np.any(at.road.slope)),
        "windows": windows,
        "profiles": profiles(effects, at.p, distance["log"]),
        "pulls_in_sds": {k: round(v, 2) for k, v in at.pulls.items()},
    }
    return Case(vehicle_text(name, at.file, hidden), logs, label)


def _parts(
    at: Setting, other: Drive, repeats: int, rng: np.random.Generator
) -> Iterator[tuple[str, Drive]]:
    """Yield the drive, another and, last of all, repeats of the first."""
    yield "log", at.drive
    yield "fresh", other
    for k in range(repeats):
        yield f"repeat{k + 1}", again(at.drive, at.car.family, at.road, rng)


def logged_columns(
    family: str,
    time: Array,
    read: dict[str, Array],
    keep: NDArray[np.bool_],
    d: Drive,
    surveyed: bool,
) -> dict[str, Array]:
    """Return a log's columns in their order, rows that arrived alone.

    Commands are those of the row's own time, straight between entries of the clock.
    """
    clock = CLOCK * np.arange(len(np.asarray(d.ref)))
    ref = np.interp(time, clock, np.asarray(d.ref))
    steer = np.interp(time, clock, np.asarray(d.steer))
    speed = {"speed_mps": read.pop("speed_mps")}
    columns = {"time_s": np.round(time, 6)}
    if family == "rc":
        columns["speed_ref_mps"] = np.round(ref, 6)
    columns |= speed | {"steer_cmd_rad": np.round(steer, 6)} | read
    if not surveyed:
        del columns["elevation_m"]
    return {k: np.round(v[keep], 6) for k, v in columns.items()}
