"""Units and signs that a channel gives away: by its size, its sign, or the vehicle."""

from __future__ import annotations

from collections.abc import Sequence
from math import inf

import numpy as np

from rcc_sim.analyse.logcheck.finding import (
    DROPPED,
    Columns,
    Finding,
    by_map,
    sampled,
)
from rcc_sim.analyse.logcheck.mistakes import DEG, DRIVING, RPM, UNITS, size_of
from rcc_sim.analyse.logcheck.relation import Means, Relation, slope
from rcc_sim.definitions.kernel import top_motor_speed
from rcc_sim.definitions.vehicle import Vehicle
from rcc_sim.units import G

GEARED = 0.03
"""Share by which a speed may differ from the motor's: what a tyre slips, and wears."""

CREEP, REACH = 0.05, 1.3
"""Times the motor's top speed that a drive reaches: at least, and at most, downhill or
where the stated limit is a little low."""

UNSIGNED, BRAKED, LIKE = 0.02, 0.1, 0.7
"""Shares of its largest value: how far below zero a channel without a sign may reach,
and how far what it should be must, to count as braking. Correlation that is asked for.
"""


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
    margin = max(GEARED, 3 * radius.tolerance / radius.value)
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
        "motor_current_a": (3000.0, 1000.0, "mA"),
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


def beyond_reach(
    columns: Columns, vehicle: Vehicle | None, suspects: Sequence[str]
) -> list[Finding]:
    """Return speeds that the vehicle's motor cannot turn to, with their likely unit."""
    if vehicle is None or "speed_mps" not in columns or "speed_mps" in suspects:
        return []
    lever = vehicle.lever
    most = top_motor_speed(vehicle) * lever
    size = size_of(columns["speed_mps"])
    fits = [
        (factor, unit)
        for factor, unit in UNITS["speed_mps"]
        if CREEP * most <= size / factor < REACH * most
    ]
    if size < REACH * most or not fits:
        return []
    factor, units = fits[0][0], " or in ".join(unit for _, unit in fits)
    what = f"reaches {size:.4g}, the motor {most:.3g} m/s: in {units}"
    both = ("speed_mps", "speed_ref_mps")
    over = [c for c in both if c in columns and size_of(columns[c]) > REACH * most]
    return [
        Finding(
            "unit",
            name,
            what if name == "speed_mps" else f"is in {units}, as speed_mps is",
            sure=0.8,
            action=f"{DROPPED}; {by_map(1 / factor)}, unless another vehicle drove",
            severity="error",
            factor=1 / factor,
        )
        for name in over
    ]


def net_sign(columns: Columns, suspects: Sequence[str]) -> list[Finding]:
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
