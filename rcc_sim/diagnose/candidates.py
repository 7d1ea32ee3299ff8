"""Which effects could be behind a gap, and at what strengths to try them."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf, sqrt

import numpy as np

from rcc_sim.diagnose.problem import Problem
from rcc_sim.physics.effect import Effect, Param
from rcc_sim.physics.effects import EFFECTS
from rcc_sim.units import G

NOT_FITTED = {"air_density_kg_per_m3"}
SPEED_LOOP_ONLY = {"reference_sampling", "speed_dead_zone", "speed_loop"}
AGGREGATES = {"road_load", "motor_efficiency"}
COMMANDED_ONLY = {"actuation_delay", "motor_lag", "current_limit"}


@dataclass(frozen=True)
class Search:
    """One parameter of a candidate: where from, within what, what to try first."""

    key: str
    neutral: float
    low: float
    high: float
    first: float
    grid: tuple[float, ...] = ()


@dataclass(frozen=True)
class Candidate:
    """An effect that may be missing from the vehicle."""

    effect: str
    searches: tuple[Search, ...]


def candidates_for(problem: Problem, only: tuple[str, ...] = ()) -> list[Candidate]:
    found = []
    for name, effect in EFFECTS.items():
        if only and name not in only:
            continue
        if name in AGGREGATES and name not in problem.vehicle.effects:
            continue
        if not _applies(problem, effect):
            continue
        searches = tuple(
            _search(problem, effect, p)
            for p in effect.params
            if _fits(problem, effect, p)
        )
        if searches:
            found.append(Candidate(name, searches))
    return found


def _applies(problem: Problem, effect: Effect) -> bool:
    vehicle, drive = problem.vehicle, problem.drive
    mode = vehicle.controller.mode if vehicle.controller else "torque"
    if effect.id in SPEED_LOOP_ONLY and (drive.imposed or mode != "speed"):
        return False
    if effect.id in COMMANDED_ONLY and drive.imposed:
        return False
    if effect.id == "throttle_dead_zone" and (drive.imposed or mode != "throttle"):
        return False
    if effect.id.startswith("steering") and not drive.steered:
        return False
    if effect.id == "road_grade" and ("elevation_m" in problem.log or "slope" in problem.log):
        return False
    if any(x in vehicle.effects for x in effect.excludes):
        return False
    if any(effect.id in EFFECTS[x].excludes for x in vehicle.effects):
        return False
    known = vehicle.figures()
    for need in effect.needs:
        if need == "motor.poles":
            if vehicle.motor.poles is None:
                return False
        elif need not in known and not (
            need == "battery.open_circuit_voltage_v"
            and "battery.nominal_voltage_v" in known
        ):
            return False
    return True


def _fits(problem: Problem, effect: Effect, p: Param) -> bool:
    if p.name in NOT_FITTED:
        return False
    if effect.id == "regeneration_limit":
        given = problem.vehicle.effects.get(effect.id, {})
        if given:
            return p.name in given
        by_current = not problem.drive.imposed
        return (p.name == "max_current_a") == by_current
    if effect.id == "sensor_delay":
        shown = {
            "yaw_rate_delay_s": "yaw_rate_radps",
            "accel_delay_s": "accel_y_mps2",
            "battery_delay_s": "battery_current_a",
        }
        return shown.get(p.name, "") in problem.log
    if effect.id == "accelerometer_bias":
        return ("accel_x_mps2" if p.name[0] == "x" else "accel_y_mps2") in problem.log
    return True


def _search(problem: Problem, effect: Effect, p: Param) -> Search:
    key = f"effects.{effect.id}.{p.name}"
    if effect.id == "sensor_delay":
        # below one row a delay cannot be told from smoothing
        row = float(np.median(np.diff(problem.log["time_s"])))
        grid = tuple(row * k for k in (1.0, 3.0, 10.0) if row * k < 0.5)
        return Search(key, 0.0, row, p.bounds[1], row, grid=grid)
    given = problem.vehicle.figures().get(key)
    neutral = given.value if given else p.neutral
    low, high = p.bounds
    a, b = p.typical
    if p.neutral == inf:
        return Search(key, neutral, low, high, b, grid=_limits(problem, effect, p))
    if a < 0:
        first = p.neutral + 0.3 * b
    elif p.neutral == 1.0:
        first = 0.5 * (1 + a)
    else:
        first = sqrt(max(a, 1e-9) * b)
        if given:
            first = neutral * 1.1 if neutral else first
    return Search(key, neutral, low, high, first, grid=_grid(problem, effect, p))


def _limits(problem: Problem, effect: Effect, p: Param) -> tuple[float, ...]:
    """Shares of what the drive asked of a limited quantity."""
    if p.name == "stiffness_n":
        weight = problem.vehicle.body.mass_kg.value * G
        return tuple(weight * x for x in (3.0, 6.0, 12.0, 25.0))
    if p.name == "friction_coefficient":
        return (0.3, 0.4, 0.5, 0.6, 0.7, 0.85, 1.0)
    out = problem.nominal
    column = "motor_torque_nm" if p.name.endswith("nm") else "motor_current_a"
    if column not in out:
        return ()
    x = out[column]
    most = float(np.nanmax(x)) if effect.id == "current_limit" else float(-np.nanmin(x))
    if effect.id == "current_limit":
        return tuple(most * s for s in (0.3, 0.45, 0.6, 0.75, 0.9))
    if column in problem.log:
        most = max(most, float(-np.nanmin(problem.log[column])))
    return tuple(most * s for s in (0.0, 0.1, 0.25, 0.5, 0.75)) if most > 0 else ()


def _grid(problem: Problem, effect: Effect, p: Param) -> tuple[float, ...]:
    if effect.id == "reference_sampling":
        dt = float(np.median(np.diff(problem.log["time_s"])))
        return (
            tuple(
                k * 0.01
                for k in (2, 3, 4, 5, 6, 8, 10, 12, 15, 20, 25, 30, 35, 40, 45, 50)
            )
            if dt < 0.2
            else (0.5, 1.0, 2.0)
        )
    if effect.id == "speed_dead_zone":
        top = float(np.nanmax(problem.nominal["motor_speed_radps"]))
        return tuple(top * s for s in (0.01, 0.02, 0.03, 0.045, 0.06, 0.09, 0.13))
    if effect.id in ("sensor_delay", "actuation_delay", "steering_delay", "steering_lag", "motor_lag"):
        return (0.01, 0.03, 0.06, 0.1, 0.16)
    if effect.id == "steering_backlash":
        top = float(np.nanmax(np.abs(problem.log["steer_cmd_rad"])))
        return tuple(top * s for s in (0.05, 0.12, 0.25))
    if effect.id == "throttle_dead_zone":
        return (0.05, 0.1, 0.15, 0.2, 0.3)
    return ()
