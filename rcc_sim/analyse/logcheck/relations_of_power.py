"""What physics asks of voltage, current and power, of each other and of the motion."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from rcc_sim.analyse.logcheck.finding import Array
from rcc_sim.analyse.logcheck.relation import Means, Relation, slope
from rcc_sim.definitions.vehicle import Vehicle

ELECTRIC = "battery_voltage_v", "battery_current_a"
"""Columns whose product is the battery's power."""

WORK = 3.0
"""Factor either way by which a battery's power may differ from what moves the mass, and
a motor's torque: losses, friction brakes, hills and a load that the file does not know.
Speeds in mph make it five times too little, in km/h thirteen times."""

LOSSES = 1.5
"""Battery's power by what speeds the mass up: 1.2 of a road car's, 1.7 to 2.4 of a
scaled car's."""

STILL = 0.01
"""Share of the largest speed below which a car stands."""

AUXILIARY, FEW = 30.0, 2e-3
"""Times more than what a log calls its auxiliaries that a standing car may draw without
doubt; and share of what it draws, above which they may be a fan alone that is logged:
a factor of a thousand is less than that."""


def power_relations(m: Means, vehicle: Vehicle | None) -> list[Relation | None]:
    """Return what voltage, current, power and motion say of each other."""
    c, d = m.columns, m.rates
    out: list[Relation | None] = []
    if {"battery_power_w", *ELECTRIC} <= set(c):
        out.append(
            slope(
                "battery power against voltage times current",
                {"battery_power_w": 1, **dict.fromkeys(ELECTRIC, -1)},
                c["battery_power_w"],
                _product(c),
                loose=1.4,
                least=0.9,
            )
        )
    if "speed_mps" not in c:
        return out
    inertial = c["speed_mps"] * d["speed_mps"]
    out += [
        slope(
            f"{name} against speed times its change",
            {name: 1},
            c[name],
            inertial,
            loose=np.inf,
            least=0.35,
        )
        for name in ("battery_current_a", "battery_power_w")
        if name in c
    ]
    return out + _stated(c, inertial, vehicle)


def _watts(c: dict[str, Array]) -> tuple[tuple[str, ...], Array | None]:
    """Return the battery's power, and the columns that it is the product of."""
    if "battery_power_w" in c:
        return ("battery_power_w",), c["battery_power_w"]
    if set(ELECTRIC) <= set(c):
        return ELECTRIC, _product(c)
    return (), None


def _product(c: dict[str, Array]) -> Array:
    """Return voltage times current. [W]"""
    voltage, current = (c[name] for name in ELECTRIC)
    return voltage * current


def _stated(
    c: dict[str, Array], inertial: Array, vehicle: Vehicle | None
) -> list[Relation | None]:
    """Return what the vehicle's own figures say of volts, amperes and watts."""
    if vehicle is None:
        return []
    out: list[Relation | None] = []
    battery = vehicle.battery
    stated = battery.open_circuit_voltage_v or battery.nominal_voltage_v
    if stated is not None and "battery_voltage_v" in c:
        volts = c["battery_voltage_v"][np.isfinite(c["battery_voltage_v"])]
        ratio = float(np.median(volts)) / stated.value if len(volts) else 0.0
        if ratio != 0:
            out.append(
                Relation(
                    "battery voltage against the vehicle file's",
                    {"battery_voltage_v": 1},
                    ratio,
                    ratio,
                    1.0,
                    2.5,
                    by_vehicle=True,
                )
            )
    kinetic = LOSSES * vehicle.body.mass_kg.value * inertial
    watts, power = _watts(c)
    if power is not None and not off_the_ground(c):
        out.append(
            slope(
                "battery power against mass times speed times its change, and losses",
                {**dict.fromkeys(watts, 1), "speed_mps": -2, "time_s": 1},
                power,
                kinetic,
                loose=WORK,
                least=0.5,
                by_vehicle=True,
            )
        )
    return out


def off_the_ground(c: Mapping[str, Array]) -> bool:
    """Tell whether wheels turned off the ground, where the mass says nothing."""
    return bool(np.any(c.get("on_stand", np.zeros(1)) == 1))


def resting_relations(m: Means, vehicle: Vehicle | None) -> list[Relation | None]:
    """Return whether a standing car draws far more than what its auxiliaries are."""
    c = m.columns
    watts, power = _watts(c)
    if power is None or not {"speed_mps", "aux_power_w"} <= set(c):
        return []
    speed = np.abs(c["speed_mps"])
    still = speed < STILL * np.nanmax(speed, initial=0.0)
    seen = slope(
        "auxiliary power against the battery's at rest",
        {"aux_power_w": 1, **dict.fromkeys(watts, -1)},
        c["aux_power_w"][still],
        power[still],
        loose=AUXILIARY,
        least=0.5,
        through_zero=True,
    )
    return [seen] if seen is not None and 0 < seen.middle < FEW else []
