"""How large a strength is: in shares of a mass, a row, a current; worth 1 % of all."""

from __future__ import annotations

import numpy as np

from rcc_sim.channel import sensor_noise
from rcc_sim.diagnose.residuals.problem import Problem
from rcc_sim.simulate.replay import RECALLS
from rcc_sim.units import RHO_AIR, G

SMEARED = 2.0
"""Rows over which the acceleration of an imposed drive is not known: a delay of less is
none. One of a row was named where a cycle was driven corner by corner."""

LATE = 0.25
"""Share of the time in which the model comes to the measured speed by which that must
be late to be told, where commands drive: less is like any error of when they act."""

LIMITED = {
    "motor_current": ("motor_current_a", 1.0),
    "braking_current": ("motor_current_a", -1.0),
    "braking_torque": ("motor_torque_nm", -1.0),
}
"""What a limit may be of: its column, and the sign of what it limits there."""

SEVERAL, SURELY = 10, 0.9
"""Rows in which a current must be above a limit for that to be none; and share of what
a meter reads that surely flowed."""

SHORTEST_CLOCK, ANGLE = 0.01, 0.1
"""Shortest time between two orders that a log may tell [s]; and the angle of the wheels
whose shares are tried where none was asked [rad]."""


def size_of(problem: Problem, of: str) -> float:
    """What strengths are shares of, in a drive; 0 where it has no such thing."""
    vehicle, drive = problem.vehicle, problem.nominal
    match of:
        case "mass":
            return vehicle.body.mass_kg.value
        case "weight":
            return vehicle.body.mass_kg.value * G
        case "wheelbase":
            return vehicle.wheelbase
        case "row":
            return problem.row * (SMEARED if problem.drive.imposed else 1.0)
        case "speed":
            drawn = 0.0 if problem.drive.imposed else LATE * RECALLS[0]
            return max(size_of(problem, "row"), drawn)
        case "clock":
            return max(size_of(problem, "row"), SHORTEST_CLOCK)
        case "motor_speed":
            return float(np.nanmax(drive["motor_speed_radps"]))
        case "steering":
            return float(np.nanmax(np.abs(problem.log["steer_cmd_rad"]))) or ANGLE
        case _ if of in LIMITED:
            return most_asked(problem, *LIMITED[of])
    return 1.0


def small_changes(problem: Problem) -> dict[str, float]:
    """Return unit -> a change of a figure worth 1 % of the weight, or of the power."""
    vehicle, drive = problem.vehicle, problem.nominal
    speed = max(float(problem.speed.max()), 0.1)
    lever = vehicle.lever
    mass = vehicle.body.mass_kg.value
    force = 0.01 * mass * G
    power = 0.01 * float(np.nanmax(np.abs(drive["battery_power_w"]))) or 1.0
    sizes = {
        "N": force,
        "N m": force * lever,
        "N m s/rad": force * lever**2 / speed,
        "kg": 0.01 * mass,
        "kg m²": 0.01 * mass * lever**2,
        "m²": force / (0.5 * RHO_AIR * speed**2),
        "m/s": 0.05 * speed,
        "W": power,
    }
    volts = drive.get("battery_voltage_v")
    if volts is not None and np.isfinite(volts).any():
        sizes["Ω"] = 0.01 * float(np.nanmax(volts)) ** 2 / (100 * power)
    return sizes


def reached(problem: Problem, of: str) -> float:
    """Return what a motor's current or torque surely reached, below which no limit is.

    In ``SEVERAL`` rows, each between two that reached it as well, beyond their noise
    and what a meter may read too much; 0 where the log does not tell.
    """
    column, sign = LIMITED[of]
    seen = sign * problem.log.columns.get(column, np.zeros(0))
    known = seen[np.isfinite(seen)]
    if len(known) < 3 * SEVERAL:
        return 0.0
    steady = np.min([known[:-2], known[1:-1], known[2:]], axis=0)
    most = float(np.partition(steady, -SEVERAL)[-SEVERAL])
    return max(SURELY * (most - 2.0 * sensor_noise(known)), 0.0)


def most_asked(problem: Problem, column: str, sign: float) -> float:
    """Most that a drive asked of a current or a torque, in the model or in the log."""
    columns = (c[column] for c in (problem.nominal, problem.log) if column in c)
    return max((float(np.nanmax(sign * x)) for x in columns), default=0.0)


def lost_at_stops(problem: Problem) -> float:
    """Speed [m/s] that a row loses as the vehicle comes to stand, in the median stop.

    The row before the last, which may hold a part of the rest.
    """
    speed, stands = problem.speed, problem.standing
    last = np.flatnonzero(stands[2:] & ~stands[1:-1]) + 1
    lost = speed[last - 1] - speed[last]
    return max(float(np.median(lost)), 0.0) if len(lost) else 0.0


def stiffest(problem: Problem) -> float:
    """Slip stiffness [N] beyond which an imposed drive tells none: C = m v / T.

    Wheels that slip by kappa = m a / C turn at v (1 + kappa) = v + a (m v / C): ahead
    of the road by a time m v / C. The drive's acceleration is smeared over a time T
    itself, a row or what smooths its speed to either side, and what that leaves is
    taken up by any slip as well: noise of a speed looks like less behind a softer tyre.
    """
    mass, row = problem.vehicle.body.mass_kg.value, problem.row
    speed = float(np.sqrt(np.mean(problem.speed**2)))
    return mass * speed / (2 * max(row, problem.drive.smear))


def tells_slip(problem: Problem, stiffness: float) -> bool:
    """Tell whether a drive tells a stated slip stiffness [N] from a stiffer one."""
    return not problem.drive.imposed or stiffness <= stiffest(problem)
