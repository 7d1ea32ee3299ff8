"""Units and signs by physics: which one channel's mistake explains the relations."""

from __future__ import annotations

from collections.abc import Sequence
from math import degrees, inf, pi
from typing import NamedTuple

import numpy as np

from rcc_sim.analyse.logcheck.finding import DROPPED, Array, Columns, Finding, sampled
from rcc_sim.analyse.logcheck.relations import Means, Relation, slope
from rcc_sim.definitions.vehicle import Vehicle
from rcc_sim.units import G


class Mistake(NamedTuple):
    """A factor that a channel is often wrong by, and what people call it."""

    channel: str
    kind: str  # unit, sign or poles
    factor: float
    words: str
    prior: float  # the smaller, the less usual


DEG = degrees(1.0)
RPM = 30 / pi

UNITS: dict[str, tuple[tuple[float, str], ...]] = {
    "speed_mps": ((3.6, "km/h"), (2.2369, "mph"), (1000.0, "mm/s"), (100.0, "cm/s")),
    "speed_ref_mps": ((3.6, "km/h"), (2.2369, "mph"), (1000.0, "mm/s")),
    "steer_cmd_rad": ((DEG, "degrees"),),
    "yaw_rate_radps": ((DEG, "deg/s"),),
    "yaw_rad": ((DEG, "degrees"),),
    "accel_x_mps2": ((1 / G, "g"), (1000 / G, "mg"), (100.0, "cm/s²")),
    "accel_y_mps2": ((1 / G, "g"), (1000 / G, "mg"), (100.0, "cm/s²")),
    "motor_speed_radps": ((RPM, "rpm"),),
    "battery_voltage_v": ((1000.0, "mV"),),
    "battery_current_a": ((1000.0, "mA"),),
    "battery_power_w": ((0.001, "kW"), (1000.0, "mW")),
    "x_m": ((1000.0, "mm"), (100.0, "cm")),
    "distance_m": ((1000.0, "mm"), (0.001, "km")),
    "time_s": ((1e3, "ms"), (1e6, "µs"), (1e9, "ns")),
}

DRIVING = ("battery_current_a", "battery_power_w", "motor_current_a", "motor_torque_nm")
"""What drives the car, and is negative where it brakes it."""

SIGNED = (
    *DRIVING,
    *("accel_x_mps2", "accel_y_mps2", "steer_cmd_rad", "yaw_rate_radps", "yaw_rad"),
    *("motor_speed_radps", "speed_ref_mps", "speed_mps"),
)
"""What may have the other sign, the likelier first."""


UNSIGNED, BRAKED, LIKE = 0.02, 0.1, 0.7
"""Shares of its largest value: how far below zero a channel without a sign may reach,
and how far what it should be must, to count as braking. Correlation that is asked for.
"""


def mistakes(columns: Columns, vehicle: Vehicle | None) -> list[Mistake]:
    """Return what the channels of this log may be wrong by."""
    out = []
    by_poles = follows_erpm("speed_mps", columns)
    if by_poles:
        out += _counted(vehicle.motor.poles if vehicle else None)
    for name, units in UNITS.items():
        if name not in columns or _size(columns[name]) < LARGE.get(name, 0.0):
            continue
        if name == "speed_mps" and by_poles:
            continue
        for rank, (factor, words) in enumerate(units):
            out.append(Mistake(name, "unit", factor, words, 1.0 - 0.2 * rank))
    if vehicle is not None and "motor_speed_radps" in columns:
        out += _electrical(vehicle.motor.poles)
    mean = float(np.nanmean(sampled(columns["speed_mps"]))) if _has(columns) else 1.0
    for rank, name in enumerate(SIGNED):
        if name not in columns or (name == "speed_mps" and mean > 0):
            continue
        words = "the other sign"
        prior = 1.5 if name == "speed_mps" else 0.9 - 0.02 * rank
        out.append(Mistake(name, "sign", -1.0, words, prior))
    both = [m for m in out if m.kind == "unit" and m.channel in SIGNED]
    for m in both:
        if m.channel != "speed_mps" or mean < 0:
            words = f"{m.words} and the other sign"
            out.append(Mistake(m.channel, "unit", -m.factor, words, 0.3))
    return out


def _electrical(poles: int | None) -> list[Mistake]:
    """Return a motor speed in electrical turns: of the poles, or of a likely number."""
    name = "motor_speed_radps"
    if poles is None:
        pairs: tuple[int, ...] = tuple(range(2, 11))
        words = "ERPM, if the motor has {} poles"
    else:
        pairs, words = (poles // 2,), "ERPM (electrical rpm; {} poles)"
    out = [
        Mistake(name, "unit", RPM * p, words.format(2 * p), 1.0 if poles else 0.7)
        for p in pairs
    ]
    if poles is not None and poles > 2:
        out.append(Mistake(name, "unit", poles / 2, "electrical rad/s", 0.8))
    return out


def _counted(poles: int | None) -> list[Mistake]:
    """Return what a speed from ERPM is wrong by where poles are taken for pairs."""
    told = {2.0: "twice", 0.5: "half"}
    pairs = (poles or 2) // 2
    factors = {2.0: 1.0, 0.5: 0.9} | ({1 / pairs: 0.8} if pairs > 2 else {})
    return [
        Mistake(
            "speed_mps",
            "poles",
            factor,
            f"{told.get(factor, f'1/{pairs} of')} what it should be: poles taken for "
            "pole pairs, or for none, in motor_speed_erpm or in the file's motor.poles",
            prior,
        )
        for factor, prior in factors.items()
    ]


def follows_erpm(name: str, columns: Columns) -> bool:
    """Tell whether a channel is the log's ERPM times a constant."""
    if name not in columns or "motor_speed_erpm" not in columns:
        return False
    x, erpm = (sampled(columns[c]) for c in (name, "motor_speed_erpm"))
    known = np.isfinite(x) & np.isfinite(erpm)
    x, erpm = x[known], erpm[known]
    times = float(x @ erpm) / (float(erpm @ erpm) or 1.0)
    return bool(len(x)) and bool(np.allclose(x, times * erpm, rtol=1e-6, atol=0.0))


GEARED = 0.03
"""Share by which a speed may differ from the motor's: what a tyre slips, and wears."""

LARGE = {"battery_voltage_v": 1500.0, "battery_current_a": 1500.0}
"""What a channel must reach before thousandths are believed. [V], [A]"""


def _size(values: Array) -> float:
    some = np.abs(sampled(values))
    some = some[np.isfinite(some)]
    return float(np.quantile(some, 0.999)) if len(some) else 0.0


def _has(columns: Columns) -> bool:
    return "speed_mps" in columns and bool(np.isfinite(columns["speed_mps"]).any())


def blame(
    found: Sequence[Relation], columns: Columns, vehicle: Vehicle | None
) -> list[Finding]:
    """Return the mistakes that explain the relations, one channel after the other.

    A mistake must mend a relation that is broken and break none that holds. Where
    several would do, the one that mends most counts, and the doubt is said.
    """
    known = mistakes(columns, vehicle)
    factors: dict[str, float] = {}
    findings: list[Finding] = []
    while True:
        broken = [r for r in found if not r.allows(_expected(r, factors))]
        if not broken:
            return findings
        ranked = sorted(
            ((_mended(m, found, broken, factors), m.prior, m) for m in known),
            key=lambda t: (t[0], t[1]),
            reverse=True,
        )
        mended, _, best = ranked[0] if ranked else (0.0, 0.0, None)
        if best is None or mended <= 0:
            return findings + [_odd(r) for r in broken[:3]]
        ties = [m for score, _, m in ranked if mended - score < 0.1 and m.prior > 0.3]
        rivals = [m for m in ties if m.channel != best.channel]
        findings.append(_finding(best, found, factors, rivals, mended))
        factors[best.channel] = best.factor
        known = [m for m in known if m.channel != best.channel]


def _expected(relation: Relation, factors: dict[str, float]) -> float:
    """Return the factor that known mistakes give a relation; 1 where there are none."""
    out = 1.0
    for channel, power in relation.powers.items():
        out *= factors.get(channel, 1.0) ** power
    return out


def _mended(
    mistake: Mistake,
    found: Sequence[Relation],
    broken: Sequence[Relation],
    factors: dict[str, float],
) -> float:
    """Return how many broken relations a mistake mends; 0 if it breaks one."""
    trial = factors | {mistake.channel: mistake.factor}
    mended = sum(r.allows(_expected(r, trial)) for r in broken)
    spoilt = sum(
        not r.allows(_expected(r, trial)) and r.allows(_expected(r, factors))
        for r in found
    )
    tight = sum(
        max(0.0, 1 - abs(np.log(abs(r.middle / _expected(r, trial)))) / 0.3)
        for r in broken
        if r.loose < inf and mistake.channel in r.powers
    )
    if not mended:
        return 0.0
    return (
        max(0.0, mended - spoilt + 0.1 * tight + 0.05 * mistake.prior)
        if spoilt < mended
        else 0.0
    )


def _finding(
    mistake: Mistake,
    found: Sequence[Relation],
    factors: dict[str, float],
    rivals: Sequence[Mistake],
    mended: float,
) -> Finding:
    trial = factors | {mistake.channel: mistake.factor}
    witness = [
        r
        for r in found
        if mistake.channel in r.powers
        and r.allows(_expected(r, trial))
        and not r.allows(_expected(r, factors))
    ]
    verb = {"sign": "has", "unit": "is in"}.get(mistake.kind, "is")
    what = f"{verb} {mistake.words}"
    seen = "; ".join(f"{r.what}: {_factor(r)}" for r in witness[:2])
    what += f" ({seen})"
    if rivals:
        others = {f"{r.channel} ({r.words})" for r in rivals}
        what += f"; or it is {', '.join(sorted(others))}"
    strength = max(abs(r.correlation) for r in witness)
    sure = (0.98 if len(witness) > 1 else 0.9) * min(1.0, 0.6 + 0.4 * strength)
    mend = 1 / mistake.factor
    action = f"{DROPPED}; to mend it, convert with --map, factor {mend:.6g}"
    if mistake.kind == "unit" and any("motor_speed_radps" in r.powers for r in witness):
        action += ", unless the vehicle file's gear, tyre or poles are another car's"
    if mistake.kind == "poles":
        action += " of motor_speed_erpm"
    return Finding(
        mistake.kind,
        mistake.channel,
        what,
        sure=round(sure / (1 + len({r.channel for r in rivals}) * 0.5), 2),
        action=action,
        severity="error",
        factor=mend,
    )


def _factor(relation: Relation) -> str:
    if np.isinf(relation.loose):
        return "opposite" if relation.low < 0 else "alike"
    return f"{relation.middle:.3g} times what it should be"


def _odd(relation: Relation) -> Finding:
    channel = next(iter(relation.powers))
    alone = relation.powers.keys() == {"battery_voltage_v"}
    return Finding(
        "other_battery" if alone else "inconsistent",
        channel,
        f"{relation.what}: {_factor(relation)}, and no usual unit or sign explains it",
        sure=round(0.8 * abs(relation.correlation), 2),
        action="used as it is; was it this vehicle that drove?"
        if alone
        else "used as it is; look at " + " and ".join(relation.powers),
        severity="warning",
    )


def geared(
    found: Sequence[Relation], vehicle: Vehicle | None, suspects: Sequence[str]
) -> list[Finding]:
    """Return a speed that is not the motor's by the file's gear and tyre radius.

    No unit is wrong by so little: a sensor's scale is, or one of those figures.
    """
    pair = {"motor_speed_radps", "speed_mps"}
    if vehicle is None or not pair.isdisjoint(suspects):
        return []
    radius = vehicle.tyres.radius_m
    margin = max(GEARED, 3 * radius.sd / radius.value)
    return [
        Finding(
            "inconsistent",
            "speed_mps",
            f"motor_speed_radps is {r.middle:.3g} times what speed_mps makes of "
            "drivetrain.gear_ratio and tyres.radius_m: one of the four is off",
            sure=0.9,
            action="used as it is; measure one of them another way",
            severity="warning",
        )
        for r in found
        if pair == r.powers.keys()
        and r.allows(1.0)
        and (r.low > 1 + margin or r.high < 1 - margin)
    ]


def by_size(columns: Columns, suspects: Sequence[str]) -> list[Finding]:
    """Return units that size alone gives away, of channels not yet blamed."""
    out = []
    limits: dict[str, tuple[float, float, str]] = {
        "steer_cmd_rad": (1.3, DEG, "degrees: no wheel turns that far"),
        "yaw_rate_radps": (25.0, DEG, "deg/s"),
        "battery_voltage_v": (2000.0, 1000.0, "mV"),
        "battery_current_a": (3000.0, 1000.0, "mA"),
        "speed_mps": (75.0, 3.6, "km/h: 270 km/h is no drive cycle's"),
        "motor_speed_radps": (7000.0, RPM, "rpm or ERPM: no motor turns that fast"),
        "accel_x_mps2": (150.0, 1000 / G, "mg"),
        "accel_y_mps2": (150.0, 1000 / G, "mg"),
        "throttle": (1.5, 100.0, "percent"),
        "slope": (1.0, 100.0, "percent"),
    }
    for name, (most, factor, words) in limits.items():
        if name not in columns or name in suspects:
            continue
        size = _size(columns[name])
        if size > most:
            out.append(
                Finding(
                    "unit",
                    name,
                    f"reaches {size:.4g}: in {words}",
                    sure=0.9,
                    action=f"{DROPPED}; to mend it, convert with --map, factor "
                    f"{1 / factor:.6g}",
                    severity="error",
                    factor=1 / factor,
                )
            )
    return out


def net_sign(time: Array, columns: Columns, suspects: Sequence[str]) -> list[Finding]:
    """Return the current or power that flows into the battery over a whole drive."""
    out: list[Finding] = []
    speed = columns.get("speed_mps")
    for name in ("battery_current_a", "battery_power_w"):
        if name in suspects or name not in columns or speed is None:
            continue
        moving = np.abs(speed) > 0.1 * np.nanmax(np.abs(sampled(speed)))
        part = columns[name][moving]
        part = part[np.isfinite(part)]
        if len(part) < 50:
            continue
        against = float(np.mean(part)), float(np.quantile(np.abs(part), 0.9))
        if against[0] < -0.3 * against[1]:
            out.append(
                Finding(
                    "sign",
                    name,
                    f"is {against[0]:.3g} on average while driving: it charges the "
                    "battery (a long descent, or the other sign)",
                    sure=0.8,
                    action=f"{DROPPED}; to mend it, convert with --map, factor -1",
                    severity="error",
                    factor=-1.0,
                )
            )
    return out


def unsigned(m: Means, suspects: Sequence[str]) -> list[Finding]:
    """Return currents, powers and torques that are positive while they brake.

    What they are while the car speeds up, by its drag and inertia, says what they
    should be while it slows. One that only stops at zero, as where friction brakes,
    does not grow with that.
    """
    out: list[Finding] = []
    speed, rate = m.columns.get("speed_mps"), m.rates.get("speed_mps")
    if speed is None or rate is None:
        return out
    force = np.stack([np.ones_like(speed), rate, speed, speed * np.abs(speed)], axis=1)
    for name in DRIVING:
        x = m.columns.get(name)
        if x is None or name in suspects:
            continue
        known = np.isfinite(x) & np.isfinite(force).all(axis=1)
        if known.sum() < 40 or x[known].min() < -UNSIGNED * x[known].max():
            continue
        law = force if name.startswith("motor") else force * speed[:, None]
        driven = known & (rate > 0)
        by = np.linalg.lstsq(law[driven], x[driven], rcond=None)[0]
        due = law @ by
        braked = known & (due < -BRAKED * x[known].max())
        seen = slope(name, {}, x[braked], -due[braked], loose=inf, least=LIKE)
        if seen is not None and seen.correlation > 0:
            out.append(
                Finding(
                    "sign",
                    name,
                    "is never negative, and grows with braking as with driving off: "
                    "it has lost its sign",
                    sure=0.9,
                    action=f"{DROPPED}; log it with its sign",
                    severity="error",
                )
            )
    return out
