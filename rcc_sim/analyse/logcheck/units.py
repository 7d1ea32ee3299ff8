"""Units and signs by physics: which one channel's mistake explains the relations."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from math import inf

import numpy as np

from rcc_sim.analyse.logcheck.finding import DROPPED, Array, Columns, Finding, sampled
from rcc_sim.analyse.logcheck.mistakes import (
    DEG,
    DRIVING,
    RPM,
    Mistake,
    mistakes,
    size_of,
    words_of,
)
from rcc_sim.analyse.logcheck.relation import Means, Relation, slope
from rcc_sim.definitions.vehicle import Vehicle
from rcc_sim.units import G

GEARED = 0.03
"""Share by which a speed may differ from the motor's: what a tyre slips, and wears."""

UNSIGNED, BRAKED, LIKE = 0.02, 0.1, 0.7
"""Shares of its largest value: how far below zero a channel without a sign may reach,
and how far what it should be must, to count as braking. Correlation that is asked for.
"""


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
        rivals = [m for m in ties if m.channel not in best.factors]
        units = {
            m.words for m in ties if m.channel == best.channel and m.kind == "unit"
        }
        or_in = "".join(f", or in {unit}" for unit in sorted(units - {best.words}))
        first = _finding(best, best.words + or_in, found, factors, rivals)
        findings.append(first)
        for channel in best.also:
            words = words_of(channel, best.factor) + or_in
            what = f"is in {words}, as {best.channel} is"
            findings.append(replace(first, channel=channel, what=what))
        factors |= best.factors
        known = [m for m in known if best.factors.keys().isdisjoint(m.factors)]


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
    trial = factors | mistake.factors
    mended = sum(r.allows(_expected(r, trial)) for r in broken)
    spoilt = sum(
        not r.allows(_expected(r, trial)) and r.allows(_expected(r, factors))
        for r in found
    )
    tight = sum(
        max(0.0, 1 - abs(np.log(abs(r.middle / _expected(r, trial)))) / 0.3)
        for r in broken
        if r.loose < inf and not mistake.factors.keys().isdisjoint(r.powers)
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
    words: str,
    found: Sequence[Relation],
    factors: dict[str, float],
    rivals: Sequence[Mistake],
) -> Finding:
    trial = factors | mistake.factors
    witness = [
        r
        for r in found
        if not mistake.factors.keys().isdisjoint(r.powers)
        and r.allows(_expected(r, trial))
        and not r.allows(_expected(r, factors))
    ]
    verb = {"sign": "has", "unit": "is in"}.get(mistake.kind, "is")
    what = f"{verb} {words}"
    seen = "; ".join(f"{r.what}: {_factor(r)}" for r in witness[:2])
    what += f" ({seen})"
    if rivals:
        others = {f"{r.channel} ({r.words})" for r in rivals}
        what += f"; or it is {', '.join(sorted(others))}"
    strength = max(abs(r.correlation) for r in witness)
    sure = (0.98 if len(witness) > 1 else 0.9) * min(1.0, 0.6 + 0.4 * strength)
    mend = 1 / mistake.factor
    of = " of motor_speed_erpm" if mistake.kind == "poles" else ""
    action = f"{DROPPED}; {by_map(mend, of)}"
    if mistake.kind == "unit" and any("motor_speed_radps" in r.powers for r in witness):
        action += ", unless the vehicle file's gear, tyre or poles are another car's"
    return Finding(
        mistake.kind,
        mistake.channel,
        what,
        sure=round(sure / (1 + len({r.channel for r in rivals}) * 0.5), 2),
        action=action,
        severity="error",
        factor=mend,
    )


def by_map(factor: float, of: str = "") -> str:
    """Return how a column map mends a channel: by its sign, by its unit or a factor.

    ``of`` names another channel, by whose factor it is mended.
    """
    draft = "rccsim convert LOG --suggest-map"
    if of:
        entry = f"factor = {factor:.6g}{of}"
        return f"to mend it, give a --map; write {entry} in what {draft} drafts"
    entry = "sign = -1" if factor == -1 else f"its unit (a factor of {factor:.6g})"
    return f"to mend it, give a --map; {draft} --vehicle CAR drafts one with {entry}"


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
        size = size_of(columns[name])
        if size > most:
            out.append(
                Finding(
                    "unit",
                    name,
                    f"reaches {size:.4g}: in {words}",
                    sure=0.9,
                    action=f"{DROPPED}; {by_map(1 / factor)}",
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
                    action=f"{DROPPED}; {by_map(-1)}",
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
