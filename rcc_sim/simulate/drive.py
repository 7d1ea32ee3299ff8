"""What drove the vehicle of a log, row by row."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from math import inf

import numpy as np
from numpy.typing import NDArray

from rcc_sim.channel import bridged, interval_of, moving_mean
from rcc_sim.definitions.kernel import answering_time, road_of
from rcc_sim.definitions.vehicle import Vehicle
from rcc_sim.errors import InputError
from rcc_sim.physics.rows import Commands, Measured
from rcc_sim.physics.tables import LINE, SINCE
from rcc_sim.simulate.holes import in_holes
from rcc_sim.simulate.road import surveyed_slope
from rcc_sim.simulate.smooth import slope_at, smoothed
from rcc_sim.trace import Trace, integral_of

Array = NDArray[np.float64]

ROUNDING = 1e-9
"""Time within which two instants are the same. [s]"""

LEAPT = 0.25
"""Share of a command's way that is made in leaps from which on it holds between rows.
"""

LATE = 1e6
"""Time beyond which a clock counts from its own start: Unix time, say. [s]"""

CALM = 0.5
"""Share of the time in which a vehicle answers its steering over which its yaw rate is
evened out: of a turn that comes and goes in ten such times that takes 0.4 %."""

SAMPLED = 0.5
"""Share of the time between two rows below which flows are samples, not means. At such
a row a drive that is straight between the rows has no acceleration: that of the time
before would meet the speed of its end, 7 % too much energy at 1 Hz in a town."""

LOST, FORGOTTEN = 0.25, 2.0
"""Longest time for which commands are bridged; and that after which a car's motion says
no more of what it was asked for before. [s]"""

COMMANDS = {"speed": "speed_ref_mps", "throttle": "throttle"}
"""Mode of the controller -> the column that commands it."""


@dataclass(frozen=True)
class Drive:
    """What drove the vehicle of a log, row by row.

    Parameters
    ----------
    time : ndarray, shape (n,)
        Of the rows, from ``start`` on. [s]
    imposed : bool
        The measured motion drives it, not the log's commands.
    steered : bool
        The log holds a commanded steering angle.
    commands : Commands
        What was asked of it and acted on it at the rows.
    road : (distance, slope)
        Slope of the road [1] over distance from the first row, as the log's speeds
        make it; of a road that the file states, true. [m]
    measured : Measured
        What its sensors say at the rows.
    window : float
        Time before a row over which flows are averaged. [s]
    felt : float
        The same of accelerations between commands, where it is shorter. [s]
    answers : float
        Time in which the vehicle as it is stated answers its steering. [s]
    start : float
        What the log's clock showed where ``time`` is 0. [s]
    distance : ndarray or None
        Distance driven at the rows, where the road is not flat. [m]
    held : tuple of int
        How reference or throttle, and steering, run between the rows
        (``physics.tables``): LINE, the first straight and the steering as a hand moves
        it; SINCE, held until the next, as digital commands are; BEFORE, held until
        their row, where that shows what acts already.
    stated, climbed : bool
        Whether the file states the road; whether its slope is what the log's elevation
        gains over that distance.
    unseen : ndarray of bool or None
        Rows at which nothing is predicted: of an imposed run those at which no speed
        was logged for long, which is bridged there; of another, those without its
        commands, and shortly after.
    smear : float
        Time over which the acceleration of an imposed run is smeared, where its speed
        was noisy. [s]
    back : bool
        It goes the other way along the road: slope and wind that the vehicle states
        come from the other side.
    on_stand : bool
        Its wheels turn off the ground: no road acts, and they alone are moved.
    """

    time: Array
    imposed: bool
    steered: bool
    commands: Commands
    road: tuple[Array, Array]
    measured: Measured
    window: float
    answers: float
    start: float = 0.0
    distance: Array | None = None
    held: tuple[int, int] = (LINE, LINE)
    stated: bool = False
    climbed: bool = False
    unseen: NDArray[np.bool_] | None = None
    smear: float = 0.0
    back: bool = False
    on_stand: bool = False
    felt: float = inf

    @property
    def turns_as_measured(self) -> bool:
        """Whether the yaw rate is imposed as well, no steering being known."""
        return self.imposed and not self.steered

    def part(self, rows: slice) -> Drive:
        """Return some rows of the drive, on their own part of the road."""
        road, distance = self.road, self.distance
        if distance is not None:
            road = (road[0] - distance[rows][0], road[1])
            distance = distance[rows] - distance[rows][0]
        return replace(
            self,
            time=self.time[rows],
            commands=Commands(*(x[rows] for x in self.commands)),
            measured=Measured(*(x[rows] for x in self.measured)),
            road=road,
            distance=distance,
            unseen=None if self.unseen is None else self.unseen[rows],
        )

    def commanded(self, **other: Array) -> Drive:
        """Return the drive with some other commands, by their names."""
        return replace(self, commands=self.commands._replace(**other))

    def known_as(self, **other: Array) -> Drive:
        """Return the drive with something else measured, by its name."""
        return replace(self, measured=self.measured._replace(**other))


def drive_of(log: Trace, vehicle: Vehicle, window: float = 0.01) -> Drive:
    """Return what drove the vehicle of a log: its commands, or else its motion.

    Parameters
    ----------
    log : Trace
        Time increases; commands that leap hold between rows, others run straight.
    vehicle : Vehicle
        Its controller's mode decides which commands count.
    window : float
        Time before a row over which flows are averaged. [s]

    Raises
    ------
    InputError
        If the log has neither commands nor a speed.
    """
    start = math.floor(log["time_s"][0]) if abs(log["time_s"][0]) > LATE else 0.0
    time = log["time_s"] - start
    imposed = not has_commands(log, vehicle)
    nan, accel = np.full(len(time), np.nan), np.zeros(len(time))
    speed = np.ascontiguousarray(log["speed_mps"]) if log.has("speed_mps") else nan
    unseen, smear = None, 0.0
    if not imposed:
        unseen = not_told(log, vehicle, time)
    else:
        if not log.has("speed_mps"):
            _refuse(log, vehicle)
        unseen = in_holes(time, np.isfinite(speed))
        felt = log["accel_x_mps2"] if log.has("accel_x_mps2") else None
        means = len(time) > 1 and window >= SAMPLED * interval_of(time)
        speed, accel, smear = smoothed(time, speed, felt, means=means)
        if len(time) > 2 and not accel.any() and not means:
            accel = np.where(speed > 0, slope_at(time, speed), 0.0)
    road, distance = _road(log, vehicle, time, speed)
    ref, steer, throttle, aux, wind, yaw_rate = (
        whole(log, column)
        for column in (
            *("speed_ref_mps", "steer_cmd_rad", "throttle", "aux_power_w"),
            *("headwind_mps", "yaw_rate_radps"),
        )
    )
    stand = is_on_stand(log)
    if stand:  # no road, and nothing to turn on
        road, distance, steer = (np.zeros(1), np.zeros(1)), None, 0.0 * steer
    asked = throttle if vehicle.mode == "throttle" else ref
    answers = answering_time(vehicle)
    current, torque = (
        np.ascontiguousarray(log[c]) if log.has(c) else nan
        for c in ("motor_current_a", "motor_torque_nm")
    )
    return Drive(
        time,
        imposed,
        log.has("steer_cmd_rad") and not stand,
        Commands(ref, steer, throttle, aux, wind),
        road,
        Measured(speed, current, calm(time, yaw_rate, answers), torque, accel),
        window,
        answers,
        start,
        distance,
        (SINCE if holds(asked) else LINE, SINCE if holds(steer) else LINE),
        stated=distance is not None and not is_surveyed(log),
        climbed=log.has("elevation_m") and not log.has("slope"),
        unseen=unseen,
        smear=smear,
        back=is_back(log),
        on_stand=stand,
    )


def calm(time: Array, yaw_rate: Array, answers: float) -> Array:
    """Return a yaw rate in which rows are evened out that no vehicle turns within.

    What turns the body goes by its change from row to row, which is mostly noise where
    rows are close.
    """
    if len(time) < 2:
        return yaw_rate
    half = int(0.5 * (CALM * answers / interval_of(time) - 1.0))
    return moving_mean(yaw_rate, 2 * half + 1) if half > 0 else yaw_rate


def is_back(log: Trace) -> bool:
    """Tell whether a log's ``direction`` is -1: it was driven the other way.

    Raises
    ------
    InputError
        If it changes, or is neither 1 nor -1.
    """
    return -1.0 == _throughout(
        log,
        "direction",
        (1.0, -1.0),
        "1, or -1 where it was driven the other way along the road",
        "way out and way back are two logs of one vehicle",
    )


def is_on_stand(log: Trace) -> bool:
    """Tell whether a log's ``on_stand`` is 1: its wheels turned off the ground.

    Raises
    ------
    InputError
        If it changes, or is neither 0 nor 1.
    """
    return 1.0 == _throughout(
        log,
        "on_stand",
        (0.0, 1.0),
        "0, or 1 where the wheels turned off the ground",
        "road and stand are two logs of one vehicle",
    )


def _throughout(
    log: Trace, column: str, either: tuple[float, float], what: str, why: str
) -> float:
    """Return what a column is all along, one of two; the first where it is not there.

    Raises
    ------
    InputError
        If it changes, or is neither.
    """
    if not log.has(column):
        return either[0]
    known = np.flatnonzero(np.isfinite(log[column]))
    values = log[column][known]
    odd = ~np.isin(values, either)
    if odd.any():
        row = known[int(np.argmax(odd))]
        raise InputError(
            f"{log.name}: row {row + 1}: {column}: {log[column][row]:g}", what
        )
    turns = values != values[0]
    if turns.any():
        row = known[int(np.argmax(turns))]
        raise InputError(
            f"{log.name}: row {row + 1}: {column} changes", f"cut the log there: {why}"
        )
    return float(values[0])


def has_commands(log: Trace, vehicle: Vehicle) -> bool:
    """Tell whether a log has the commands that this vehicle's controller obeys."""
    command = COMMANDS.get(vehicle.mode)
    return command is not None and log.has(command)


def _refuse(log: Trace, vehicle: Vehicle) -> None:
    command = COMMANDS.get(vehicle.mode)
    either = f"{command}, or speed_mps" if command else "speed_mps"
    raise InputError(
        f"{log.name}: nothing drives {vehicle.name}, whose mode is {vehicle.mode}: "
        f"the log should hold {either}",
        f"there are {', '.join(log.columns)}; of one by another name a --map tells, "
        "which `rccsim convert LOG --suggest-map` drafts",
    )


def whole(log: Trace, column: str) -> Array:
    """Return a column without gaps; zeros where the log does not have it."""
    if not log.has(column):
        return np.zeros(len(log))
    return bridged(log["time_s"], np.ascontiguousarray(log[column]))


def not_told(log: Trace, vehicle: Vehicle, time: Array) -> NDArray[np.bool_] | None:
    """Return the rows at which it is not known what the vehicle was asked for.

    And those after them, until it has forgotten what it was taken to be asked for.
    None where all is known.
    """
    asked = (COMMANDS[vehicle.mode], "steer_cmd_rad")
    ends = np.isin(np.arange(len(time)), (0, len(time) - 1))
    known = [ends | np.isfinite(log[c]) for c in asked if log.has(c)]
    holes = [in_holes(time, rows, LOST) for rows in known]
    lost = [hole for hole in holes if hole is not None]
    if not lost:
        return None
    some = np.logical_or.reduce(lost)
    last = np.maximum.accumulate(np.where(some, time, -inf))
    return np.asarray(some | (time - last < FORGOTTEN))


def holds(command: Array) -> bool:
    """Tell whether a command stays as it is for some rows and then leaps.

    One that holds between its messages leaps from row to row; a driver's hand, or a
    cycle's speed, moves over several. It holds if ``LEAPT`` of its way is leapt.
    """
    way = np.abs(np.diff(command))
    way[way <= ROUNDING * np.ptp(command)] = 0.0
    still = np.pad(way == 0.0, 1, constant_values=True)
    return bool(way[still[:-2] & still[2:]].sum() > LEAPT * way.sum())


def is_surveyed(log: Trace) -> bool:
    """Tell whether a log holds the slope of its road, or its elevation."""
    return log.has("elevation_m") or log.has("slope")


def _road(
    log: Trace, vehicle: Vehicle, time: Array, speed: Array
) -> tuple[tuple[Array, Array], Array | None]:
    """Return the slope over distance that log or file know, and the rows' distances."""
    stated = None if is_surveyed(log) else road_of(vehicle)
    if not is_surveyed(log) and stated is None:
        return (np.zeros(1), np.zeros(1)), None
    if stated is not None and is_back(log):
        raise InputError(
            f"{log.name}: direction: the road of {vehicle.name}, "
            "effects.road_grade.profile, counts from where the way out begins",
            "give the way back a slope or elevation_m of its own",
        )
    v = np.where(np.isfinite(speed), speed, 0.0)
    distance = np.maximum.accumulate(integral_of(time, v))
    if stated is not None:
        return stated, distance
    if log.has("slope"):
        s, first = np.unique(distance, return_index=True)
        return (s, whole(log, "slope")[first]), distance
    return surveyed_slope(distance, log["elevation_m"], time), distance
