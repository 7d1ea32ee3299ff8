"""What physics asks of two channels at once: the factor between them is one.

Each relation compares a channel with what other channels say it should be, over short
means, and gives the factor between the two. A wrong unit or sign shows as the same
factor in every relation that the channel takes part in (`blame.py` puts the blame).
"""

from __future__ import annotations

from math import expm1

import numpy as np

from rcc_sim.analyse.logcheck.finding import Array, Columns
from rcc_sim.analyse.logcheck.relation import Means, Relation, slope
from rcc_sim.analyse.logcheck.relations_of_power import (
    WORK,
    off_the_ground,
    power_relations,
    resting_relations,
)
from rcc_sim.definitions.kernel import loop_stiffness, motor_torque_constant
from rcc_sim.definitions.vehicle import Vehicle
from rcc_sim.units import G

WHEELBASE = 1.3
"""Between a scaled car's and a van's: within 20 times of either, understeer too. [m]"""

AT_ONCE = 50.0
"""Times that a loop has followed a command, beyond which more says no more."""


def relations(m: Means, vehicle: Vehicle | None) -> list[Relation]:
    """Return every relation that the channels (and the vehicle) allow."""
    found: list[Relation | None] = []
    for build in (
        *(_motion, _turning, _pose, _drive),
        *(power_relations, resting_relations),
    ):
        found += build(m, vehicle)
    return [relation for relation in found if relation is not None]


def _motion(m: Means, vehicle: Vehicle | None) -> list[Relation | None]:
    c, d = m.columns, m.rates
    out: list[Relation | None] = []
    if "speed_mps" not in c:
        return out
    if "accel_x_mps2" in c:
        a = c["accel_x_mps2"]
        swing = float(np.nanmax(np.abs(a), initial=0.0))
        hill = G * c["slope"] if "slope" in c and swing > 1.0 else 0.0  # not in g
        out.append(
            slope(
                "acceleration against the change of speed",
                {"accel_x_mps2": 1, "speed_mps": -1, "time_s": 1},
                a - hill,
                d["speed_mps"],
                loose=1.6 / at_its_end(m, vehicle),
                least=0.75,
            )
        )
    return out + _follows(c, d)


def at_its_end(m: Means, vehicle: Vehicle | None) -> float:
    r"""Acceleration at a row's end over its mean, where commands hold between rows. [1]

    .. math:: \frac{x}{e^x - 1}

    x being the time between rows by the rate at which the loop holds its speed: what is
    read as the next command goes out says little of a car that has followed the last.
    """
    if vehicle is None or "speed_ref_mps" not in m.columns:
        return 1.0
    x = min(m.row * loop_stiffness(vehicle), AT_ONCE)
    return x / expm1(x) if x > 0 else 1.0


def _follows(c: Columns, d: Columns) -> list[Relation | None]:
    out: list[Relation | None] = []
    v = c["speed_mps"]
    if "speed_ref_mps" in c:
        out.append(
            slope(
                "speed against its reference",
                {"speed_mps": 1, "speed_ref_mps": -1},
                v,
                c["speed_ref_mps"],
                loose=1.7,
                least=0.9,
                through_zero=True,
            )
        )
    if "distance_m" in c:
        out.append(
            slope(
                "change of distance against speed",
                {"distance_m": 1, "speed_mps": -1, "time_s": -1},
                d["distance_m"],
                v,
                loose=1.5,
                least=0.9,
                through_zero=True,
            )
        )
    return out


def _turning(m: Means, vehicle: Vehicle | None) -> list[Relation | None]:
    c, d = m.columns, m.rates
    out: list[Relation | None] = []
    if "yaw_rate_radps" not in c:
        return out
    r = c["yaw_rate_radps"]
    if "speed_mps" in c and "accel_y_mps2" in c:
        out.append(
            slope(
                "lateral acceleration against speed times yaw rate",
                {"accel_y_mps2": 1, "speed_mps": -1, "yaw_rate_radps": -1},
                c["accel_y_mps2"],
                c["speed_mps"] * r,
                loose=1.6,
                least=0.75,
            )
        )
    if "speed_mps" in c and "steer_cmd_rad" in c:
        l = vehicle.wheelbase if vehicle is not None else WHEELBASE
        out.append(
            slope(
                "yaw rate against speed times steering",
                {"yaw_rate_radps": 1, "speed_mps": -1, "steer_cmd_rad": -1},
                r,
                c["speed_mps"] * c["steer_cmd_rad"] / l,
                loose=6.0 if vehicle is not None else 20.0,
                least=0.6,
                by_vehicle=vehicle is not None,
            )
        )
    if "yaw_rad" in c:
        out.append(
            slope(
                "change of heading against yaw rate",
                {"yaw_rad": 1, "yaw_rate_radps": -1, "time_s": -1},
                d["yaw_rad"],
                r,
                loose=1.6,
                least=0.75,
            )
        )
    return out


def _pose(m: Means, vehicle: Vehicle | None) -> list[Relation | None]:
    c, d = m.columns, m.rates
    if not {"x_m", "y_m", "speed_mps"} <= set(c):
        return []
    pace = np.hypot(d["x_m"], d["y_m"])
    return [
        slope(
            "speed of the pose against speed",
            {"x_m": 1, "speed_mps": -1, "time_s": -1},
            pace,
            np.abs(c["speed_mps"]),
            loose=1.8,
            least=0.8,
            through_zero=True,
        )
    ]


def _drive(m: Means, vehicle: Vehicle | None) -> list[Relation | None]:
    c, d = m.columns, m.rates
    out: list[Relation | None] = []
    if "speed_mps" not in c:
        return out
    if "motor_speed_radps" in c:
        n = 1.0 if vehicle is None else vehicle.rad_per_m
        out.append(
            slope(
                "motor speed against speed",
                {"motor_speed_radps": 1, "speed_mps": -1},
                c["motor_speed_radps"],
                c["speed_mps"] * n,
                loose=1.7 if vehicle is not None else np.inf,
                least=0.9,
                through_zero=True,
                by_vehicle=vehicle is not None,
            )
        )
    out += [
        slope(
            f"{name} against the change of speed",
            {name: 1, "speed_mps": -1, "time_s": 1},
            c[name],
            d["speed_mps"],
            loose=np.inf,
            least=0.35,
        )
        for name in ("motor_current_a", "motor_torque_nm")
        if name in c
    ]
    return out + _torque(c, d["speed_mps"], vehicle)


def _torque(c: Columns, rate: Array, vehicle: Vehicle | None) -> list[Relation | None]:
    """Return what a motor's torque is of that which speeds the mass up.

    As it was logged, and as the motor's constants make it of the current.
    """
    if vehicle is None or off_the_ground(c):
        return []
    made_of = {"motor_torque_nm": ("motor torque", 1.0)}
    if K_t := motor_torque_constant(vehicle):
        made_of["motor_current_a"] = "motor current times torque constant", K_t
    return [
        slope(
            f"{what} against mass times tyre radius times the change of speed by "
            "gear ratio",
            {name: 1, "speed_mps": -1, "time_s": 1},
            c[name] * factor,
            rate * vehicle.body.mass_kg.value * vehicle.lever,
            loose=WORK,
            least=0.5,
            by_vehicle=True,
        )
        for name, (what, factor) in made_of.items()
        if name in c
    ]
