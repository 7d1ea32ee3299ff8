"""Which effects could be behind a gap, and at what strengths to try them."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from math import inf, isfinite, log1p, sqrt

import numpy as np

from rcc_sim.definitions.vehicle import Vehicle
from rcc_sim.diagnose.knobs import STEPPED
from rcc_sim.diagnose.problem import Problem
from rcc_sim.errors import InputError, did_you_mean
from rcc_sim.physics.effect import Effect, Param
from rcc_sim.units import G, unit_of

DRAGGED = ("iron_loss",)
"""What a car that coasts drags along, so that the sum of its losses holds it too."""

NOT_FITTED = {"air_density_kg_per_m3"}
"""Figures that stand beside another and never vary on their own."""

AGGREGATES = {"road_load", "motor_efficiency"}
"""Effects that sum up others: they are no causes unless the file states them."""

IF_ASKED = {"steering_drag"}
"""Effects of some cars alone: no causes unless they were withheld, or asked for."""

SPEED_LOOP = {"reference_sampling", "speed_dead_zone", "speed_loop"}
COMMANDED = {"actuation_delay", "motor_lag", "current_limit", *SPEED_LOOP}
ROLLED = {"wheel_radius", "speed_sensor_scale"}
"""Effects that an imposed drive shows only by how it turns: without, they are a factor
on every force."""

TURNED = {"yaw_inertia"}
"""Effects of how a yaw rate changes: where one is imposed as it was measured, that is
its noise above all."""

LIKELY = 5.0
"""Strength that is tried first, in small changes of its unit."""

USUAL = 50.0
"""Largest strength that is usual, in small changes of its unit."""

SLIGHT = 0.05
"""Share of its typical departure from 1 that a scale must have to be told: a wheel's
radius is no better defined than by what its tyre slips."""

BEYOND = 2.5
"""Times its typical departure from neutral that a scale, a wind or a slope may have."""

FREEDOM, T_90 = 4.0, 2.132
"""Degrees of freedom of what strengths are likely, and the t within which nine in ten
are."""

OUTDOORS = {"headwind", "road_grade"}

LIGHTEST, HEAVIEST = 0.5, 1.0
"""Shares of its mass that a vehicle may lack, and carry."""

WITHIN = 5.0
"""Factor within which a stated figure of the car itself lies: what asks for more is not
that figure."""

MEASURED = {"N", "N m", "N m s/rad", "kg m²", "m²", "Ω", "1"}
"""Units of such figures; a load, in W or kg, may be any times what was stated."""

CLOCKED = {"reference_sampling"}
THROTTLE = {"throttle_dead_zone"}
DELAYS = {"actuation_delay", "steering_delay", "steering_lag", "motor_lag"}

SENSOR_DELAYS = {
    "yaw_rate_delay_s": "yaw_rate_radps",
    "accel_delay_s": "accel_y_mps2",
    "battery_delay_s": "battery_current_a",
}
"""Delays of a sensor that a log can show, and by which column."""


@dataclass(frozen=True)
class Search:
    """One figure of a candidate.

    Parameters
    ----------
    key : str
        Dotted key of the vehicle file.
    neutral : float
        What the file states, else the value at which the effect vanishes.
    low, high : float
        Bounds.
    first : float
        Strength that is tried first.
    grid : tuple of float
        Strengths that are all tried: for thresholds, limits and clocks.
    clocked : bool
        Whether it is a period, whose signal has no slope at all: found by trying alone.
    stepped : bool
        Whether it acts where a command passes it, and between two commands not at all:
        its slope leads nowhere far.
    least : float
        Distance from neutral below which a model is no better than its effect.
    most : float
        Largest distance from neutral that is usual.
    likely : float
        The likeliest one: of what runs over decades the middle of them, else ``most``.
    """

    key: str
    neutral: float
    low: float
    high: float
    first: float
    grid: tuple[float, ...] = ()
    clocked: bool = False
    stepped: bool = False
    least: float = 0.0
    most: float = inf
    likely: float = inf

    def price(self, x: float) -> float:
        """Nats that a strength costs: nine of ten are no larger than is usual.

        Student's t on the distance from neutral, because what is usual is known
        roughly; a limit, which has no such distance, is free.
        """
        if not isfinite(self.neutral):
            return 0.0
        t = T_90 * (x - self.neutral) / self.most
        return 0.5 * (FREEDOM + 1) * log1p(t**2 / FREEDOM)


@dataclass(frozen=True)
class Candidate:
    """An effect that may be missing from the vehicle, or not be what it states.

    Of some several figures may be off at once: each sensor has a delay of its own.
    """

    effect: str
    searches: tuple[Search, ...]
    several: bool = False

    def price(self, values: Mapping[str, float], keys: Collection[str]) -> float:
        """Nats that some of its figures cost."""
        return sum(s.price(values[s.key]) for s in self.searches if s.key in keys)


def candidates_for(
    problems: Sequence[Problem],
    only: Sequence[str] = (),
    withheld: Sequence[str] = (),
) -> list[Candidate]:
    """Return the effects that these logs could show.

    Some are where they were withheld, or asked for, alone; a sum of others that was
    withheld stands for its parts.

    Raises
    ------
    InputError
        If ``only`` names an effect that is not known or cannot act here.
    """
    first = problems[0]
    known = first.vehicle.known
    sums = {*withheld} & AGGREGATES
    quiet = IF_ASKED | (AGGREGATES - first.vehicle.effects.keys())
    parts = {p for name in sums for p in (*known[name].excludes, *DRAGGED)}
    found = []
    for name, effect in known.items():
        if name in parts and name not in only:
            continue  # it was in the sum that was taken out
        if (only and name not in only) or not applies(first, effect):
            continue
        if name in quiet and name not in withheld and name not in only:
            continue
        params = [p for p in effect.params if is_fitted(first, effect, p)]
        searches = tuple(search_of(first, effect, p) for p in params)
        if searches:
            several = effect.sensor or name in AGGREGATES
            found.append(Candidate(name, searches, several))
    missing = [name for name in only if name not in {c.effect for c in found}]
    if missing:
        if missing[0] in known:
            raise InputError(f"--candidates: {missing[0]}: cannot show in this log")
        what = f"--candidates: {missing[0]}: no such effect"
        raise InputError(what, did_you_mean(missing[0], known))
    return found


def applies(problem: Problem, effect: Effect) -> bool:
    """Tell whether an effect could act, and show, in a log."""
    vehicle, drive, name = problem.vehicle, problem.drive, effect.id
    mode = vehicle.controller.mode if vehicle.controller else "torque"
    stated = vehicle.effects
    if name in COMMANDED and drive.imposed:
        return False
    if (name in SPEED_LOOP and mode != "speed") or (
        name in THROTTLE and (mode != "throttle" or drive.imposed)
    ):
        return False
    if name.startswith("steering") and not drive.steered:
        return False
    if name in ROLLED | TURNED and drive.turns_as_measured:
        return False
    if name == "road_grade" and problem.surveyed:
        return False
    known = vehicle.known
    if any(other in stated for other in effect.excludes):
        return False
    if any(name in known[other].excludes for other in stated):
        return False
    return has_needs(vehicle, effect)


def has_needs(vehicle: Vehicle, effect: Effect) -> bool:
    """Tell whether a vehicle states what an effect is computed from."""
    figures = vehicle.figures()
    open_circuit = "battery.open_circuit_voltage_v"
    for need in effect.needs:
        if need == "motor.poles":
            if vehicle.motor.poles is None:
                return False
        elif need == open_circuit:
            if not {need, "battery.nominal_voltage_v"} & set(figures):
                return False
        elif need not in figures:
            return False
    return True


def is_fitted(problem: Problem, effect: Effect, param: Param) -> bool:
    """Tell whether a figure of an effect is one to be found."""
    if param.name in NOT_FITTED:
        return False
    if effect.id == "regeneration_limit":
        given = problem.vehicle.effects.get(effect.id, {})
        if given:
            return param.name in given
        return (param.name == "max_current_a") == (not problem.drive.imposed)
    if effect.id == "sensor_delay":
        return SENSOR_DELAYS.get(param.name, "") in problem.channels
    if effect.id == "accelerometer_bias":
        axis = param.name.partition("_")[0]
        return f"accel_{axis}_mps2" in problem.channels
    return True


def search_of(problem: Problem, effect: Effect, param: Param) -> Search:
    """Return where to look for a figure."""
    key = f"effects.{effect.id}.{param.name}"
    stated = problem.vehicle.figures().get(key)
    neutral = stated.value if stated else param.neutral
    low, high = param.bounds
    grid = grid_of(problem, effect, param)
    if effect.id == "sensor_delay":
        low = grid[0]  # within a row a delay cannot be told from smoothing
    if effect.id == "payload":
        mass = problem.vehicle.body.mass_kg.value
        low = max(low, neutral - LIGHTEST * mass)
        high = min(high, neutral + HEAVIEST * mass)
    a, b = param.typical
    small = problem.small.get(unit_of(param.name))
    least = 0.0
    if stated and neutral and not grid and unit_of(param.name) in MEASURED:
        low, high = max(low, neutral / WITHIN), min(high, neutral * WITHIN)
    if param.neutral == inf:
        first = b
    elif a < 0:
        first = param.neutral + 0.3 * b
        if effect.id in OUTDOORS:
            low, high = max(low, BEYOND * a), min(high, BEYOND * b)
    elif param.neutral == 1.0:
        first = 0.5 * (1 + a)
        least = SLIGHT * max(1 - a, b - 1)
        low = max(low, 1 - BEYOND * (1 - a))
        high = min(high, 1 + BEYOND * max(b - 1, 0.0))
    elif stated and neutral:
        first = 1.1 * neutral
    else:
        first = sqrt(max(a, 1e-9) * b) if small is None else LIKELY * small
    most = max(abs(a - param.neutral), abs(b - param.neutral))
    most = most if small is None else USUAL * small
    decades = param.neutral == 0.0 < a and not (stated and neutral)
    likely = first if decades else most
    clocked, stepped = effect.id in CLOCKED, effect.id in STEPPED
    more = (grid, clocked, stepped, least, most, likely)
    return Search(key, neutral, low, high, first, *more)


def grid_of(problem: Problem, effect: Effect, param: Param) -> tuple[float, ...]:
    """Strengths to try for an effect that has no slope at neutral; else none."""
    row = float(np.median(np.diff(problem.log["time_s"])))
    mass, nominal = problem.vehicle.body.mass_kg.value, problem.nominal
    name = effect.id
    if name == "longitudinal_slip":
        return tuple(mass * G * x for x in (3.0, 6.0, 12.0, 25.0))
    if name == "tyre_saturation":
        return (0.3, 0.4, 0.5, 0.6, 0.7, 0.85, 1.0)
    if name in ("current_limit", "regeneration_limit"):
        return limits(problem, name, param)
    if name == "reference_sampling":
        hold = max(row, 0.01)
        return tuple(hold * k for k in range(2, 51) if hold * k <= 2)
    if name == "speed_dead_zone":
        top = float(np.nanmax(nominal["motor_speed_radps"]))
        return tuple(top * x for x in (0.01, 0.02, 0.03, 0.045, 0.06, 0.09, 0.13))
    if name == "sensor_delay":
        return tuple(row * k for k in (1.0, 2.0, 5.0, 10.0) if row * k < 0.5) or (row,)
    if name in DELAYS:
        return (0.01, 0.03, 0.06, 0.1, 0.16)
    if name == "tyre_relaxation":
        return tuple(problem.vehicle.wheelbase * x for x in (0.05, 0.12, 0.3, 0.6, 1.0))
    if name == "steering_backlash":
        most = float(np.nanmax(np.abs(problem.log["steer_cmd_rad"]))) or 0.1
        return tuple(most * x for x in (0.05, 0.12, 0.25))
    if name == "throttle_dead_zone":
        return (0.05, 0.1, 0.15, 0.2, 0.3)
    return ()


def limits(problem: Problem, name: str, param: Param) -> tuple[float, ...]:
    """Shares of the most that the drive asked of a limited current or torque."""
    by_torque = param.name.endswith("nm")
    column = "motor_torque_nm" if by_torque else "motor_current_a"
    sign = 1.0 if name == "current_limit" else -1.0
    most = 0.0
    for columns in (problem.nominal, problem.log):
        if column in columns:
            most = max(most, float(np.nanmax(sign * columns[column])))
    shares = (0.3, 0.45, 0.6, 0.75, 0.9) if sign > 0 else (0.0, 0.1, 0.25, 0.5, 0.75)
    return tuple(most * x for x in shares) if most > 0 else ()
