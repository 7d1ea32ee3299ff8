"""A logged drive, run again: the vehicle under the log's own inputs."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from math import inf

import numpy as np
from numpy.typing import NDArray

from rcc_sim.definitions.figure import Figure
from rcc_sim.definitions.kernel import (
    efficiency_map,
    force_table,
    kernel_params,
    road_of,
)
from rcc_sim.definitions.vehicle import Vehicle
from rcc_sim.errors import InputError
from rcc_sim.physics import params as schema
from rcc_sim.physics import record
from rcc_sim.physics.replay import run_replayed
from rcc_sim.simulate.columns import log_columns
from rcc_sim.simulate.own import own_terms
from rcc_sim.simulate.road import surveyed_slope
from rcc_sim.simulate.run import delay_lines
from rcc_sim.simulate.sensors import sensed_columns
from rcc_sim.simulate.smooth import smoothed
from rcc_sim.trace import Trace

Array = NDArray[np.float64]
Measured = tuple[Array, Array, Array, Array, Array]

STEP = 0.01
"""Longest time step of an imposed run. [s]"""

COARSE = (0.005, 0.02)
"""Longest time steps of a commanded and of an imposed run that need only be near. [s]

Enough for what a change of a figure does, the error being much the same without it.
"""

ROUNDING = 1e-9
"""Time within which two instants are the same. [s]"""

LEAPT = 0.25
"""Share of a command's way that is made in leaps from which on it holds between rows.
"""

LATE = 1e6
"""Time beyond which a clock counts from its own start: Unix time, say. [s]"""

SAMPLED = 0.5
"""Share of the time between two rows below which flows are samples, not means. At such
a row a drive that is straight between the rows has no acceleration: that of the time
before would meet the speed of its end, 7 % too much energy at 1 Hz in a town."""

HOLE = 5.5
"""Usual intervals beyond which nothing is said of the time between two readings: five
are bridged, however their times are rounded."""

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
    commands : tuple of ndarray
        Speed reference [m/s], steering angle [rad], throttle [1] and auxiliary power
        [W] at the rows.
    road : (distance, slope)
        Slope of the road [1] over distance from the first row, as the log's speeds
        make it; of a road that the file states, true. [m]
    measured : tuple of ndarray
        Speed [m/s], motor current [A], yaw rate [rad/s], motor torque [N m], NaN where
        not known; acceleration [m/s²] that bends the speed between the rows.
    window : float
        Time before a row over which flows are averaged. [s]
    start : float
        What the log's clock showed where ``time`` is 0. [s]
    distance : ndarray or None
        Distance driven at the rows, where the road is not flat. [m]
    held : tuple of bool
        Whether reference and steering hold between the rows, as digital commands do,
        or run straight, as the throttle does.
    stated, climbed : bool
        Whether the file states the road; whether its slope is what the log's elevation
        gains over that distance.
    unseen : ndarray of bool or None
        Rows of an imposed run at which no speed was logged for long: it is bridged
        there, and nothing is predicted.
    """

    time: Array
    imposed: bool
    steered: bool
    commands: tuple[Array, Array, Array, Array]
    road: tuple[Array, Array]
    measured: Measured
    window: float
    start: float = 0.0
    distance: Array | None = None
    held: tuple[bool, bool] = (False, False)
    stated: bool = False
    climbed: bool = False
    unseen: NDArray[np.bool_] | None = None

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
        measured = self.measured
        speed, current, yaw_rate, torque, accel = (x[rows] for x in measured)
        ref, steer, throttle, aux = (x[rows] for x in self.commands)
        return replace(
            self,
            time=self.time[rows],
            commands=(ref, steer, throttle, aux),
            measured=(speed, current, yaw_rate, torque, accel),
            road=road,
            distance=distance,
            unseen=None if self.unseen is None else self.unseen[rows],
        )


def replay(
    vehicle: Vehicle,
    drive: Drive,
    recalls: tuple[float, float] = (inf, inf),
    *,
    substeps: int = 1,
    coarse: bool = False,
    turned: Array | None = None,
) -> dict[str, Array]:
    """Run the vehicle along a log; return what it predicts at the log's rows.

    Parameters
    ----------
    vehicle, drive
        What is driven, and by what (:func:`drive_of`).
    recalls : (float, float)
        Times in which speed, and the speed loop's integral, are drawn to what was
        measured; infinite: never, a free run. [s]
    substeps : int
        Runs of the loop in place of one, to see what the time step costs.
    coarse : bool
        Take longer time steps (``COARSE``), several times as fast.
    turned : ndarray, shape (n,), or None
        True yaw rate at the rows, by another measurement than the gyro; NaN where not
        known. What the gyro shows then follows from it, not from the model. [rad/s]

    Returns
    -------
    columns : dict of ndarray, each of shape (n,)
        As those of a simulated trace, without x and y and the energy ledger; NaN at
        rows that are ``unseen``.

    Raises
    ------
    InputError
        If the vehicle lacks a figure that the run needs.
    """
    values = kernel_params(vehicle, commanded=not drive.imposed)
    if drive.steered:
        values["lanes"]["steer"] = schema.LOGGED
    control = values["control"]
    if drive.imposed:
        control["T_loop"] = _step(drive.time, COARSE[1] if coarse else STEP)
        control["delta_max"] = control.get("delta_max", inf)
    elif coarse:
        control["T_loop"] *= max(math.floor(COARSE[0] / control["T_loop"] + 1e-6), 1)
    control["T_loop"] /= substeps
    n = len(drive.time)
    own = own_terms(vehicle)
    P, work, sinks = own.records()
    record.fill(P[0], values)
    table = record.array(schema.ROW, n)
    own.call(
        run_replayed,
        True,
        P,
        work,
        (drive.time, *drive.commands, drive.held),
        road_driven(vehicle, drive),
        as_true(vehicle, drive),
        (efficiency_map(vehicle), force_table(vehicle)),
        delay_lines(values),
        table,
        sinks,
        drive.imposed,
        drive.window,
        recalls,
    )
    c = work[0][0]
    columns = log_columns(
        vehicle,
        table,
        n=float(c["n"]),
        n_file=float(c["n_file"]),
        K_t=float(c["K_t"]),
    )
    columns["yaw_rad"] = record.column(table, "psi")
    if turned is not None:
        simulated = columns["yaw_rate_radps"]
        known = np.isfinite(turned)
        columns["yaw_rate_radps"] = np.where(known, turned, simulated)
    seen = sensed_columns(vehicle, columns)
    if drive.unseen is not None:
        seen = {c: np.where(drive.unseen, np.nan, x) for c, x in seen.items()}
    seen["time_s"] = drive.time + drive.start
    return seen


def _interval(time: Array) -> float:
    """Return the usual time between two rows. [s]"""
    return float(np.median(np.diff(time)))


def _step(time: Array, longest: float) -> float:
    """Return the time step of an imposed run: a whole part of the rows' interval."""
    interval = _interval(time)
    return interval / max(math.ceil(interval / longest - 1e-6), 1)


def as_true(vehicle: Vehicle, drive: Drive) -> Measured:
    """Return what was measured as it was, by what the vehicle's sensors make of it.

    ``speed_mps`` is the motor's speed with the file's tyre radius; a reading that is
    late belongs to an earlier row.
    """
    rolled = speed_share(vehicle)
    late = figure_of(vehicle, "sensor_delay", "delay_s", 0.0)
    of_speed, of_yaw, of_motor = (
        late + figure_of(vehicle, "sensor_delay", f"{name}_delay_s", 0.0)
        for name in ("speed", "yaw_rate", "motor_current")
    )
    speed, current, yaw_rate, torque, accel = drive.measured
    if rolled != 1.0:
        speed, accel = speed * rolled, accel * rolled
    return (
        earlier(drive, speed, of_speed),
        earlier(drive, current, of_motor),
        earlier(drive, yaw_rate, of_yaw),
        earlier(drive, torque, of_motor),
        earlier(drive, accel, of_speed),
    )


def figure_of(vehicle: Vehicle, effect: str, name: str, neutral: float) -> float:
    """Return a figure of an effect, or what it is where the file has none."""
    figure = vehicle.effects.get(effect, {}).get(name)
    return figure.value if isinstance(figure, Figure) else neutral


def speed_share(vehicle: Vehicle) -> float:
    """Return the true speed over the logged one. [1]"""
    rolled = figure_of(vehicle, "wheel_radius", "scale", 1.0)
    return rolled / figure_of(vehicle, "speed_sensor_scale", "scale", 1.0)


def road_driven(vehicle: Vehicle, drive: Drive) -> tuple[Array, Array]:
    """Return the slope over the distance that was truly driven. [m], [1]

    A place of the log's road is farther on by as much as its speeds are low, and its
    elevation is gained over that much more.
    """
    share = speed_share(vehicle)
    if drive.stated or share == 1.0:
        return drive.road
    distance, slope = drive.road
    return distance * share, slope / share if drive.climbed else slope


def earlier(drive: Drive, values: Array, delay: float) -> Array:
    """Return readings that came late [s] at the rows that they belong to.

    Between two rows it is the first of them, so that nothing is drawn to a reading
    that it has yet to predict; what drives an imposed run is interpolated.
    """
    known = np.isfinite(values)
    if delay == 0.0 or not known.any():
        return values
    then = drive.time + delay
    if drive.imposed:
        whole = np.interp(then, drive.time[known], values[known])
        gaps = np.interp(then, drive.time, known.astype(float)) < 1 - ROUNDING
        return np.where(gaps, np.nan, whole)
    row = np.searchsorted(drive.time, then + ROUNDING, side="right") - 1
    return np.where(then <= drive.time[-1] + ROUNDING, values[row], np.nan)


def is_imposed(log: Trace, vehicle: Vehicle) -> bool:
    """Tell whether a log lacks the commands that this vehicle's controller obeys."""
    mode = vehicle.controller.mode if vehicle.controller else "torque"
    command = COMMANDS.get(mode)
    return command is None or not has(log, command)


def has(log: Trace, column: str) -> bool:
    """Tell whether a log has a value of a column."""
    return column in log and bool(np.isfinite(log[column]).any())


def drive_of(
    log: Trace, vehicle: Vehicle, window: float = 0.01, jerk: float | None = None
) -> Drive:
    """Return what drove the vehicle of a log: its commands, or else its motion.

    Parameters
    ----------
    log : Trace
        Time increases; commands that leap hold between rows, others run straight.
    vehicle : Vehicle
        Its controller's mode decides which commands count.
    window : float
        Time before a row over which flows are averaged. [s]
    jerk : float or None
        For :func:`rcc_sim.simulate.smooth.smoothed`; None: by cross-validation.

    Raises
    ------
    InputError
        If the log has neither commands nor a speed.
    """
    start = math.floor(log["time_s"][0]) if abs(log["time_s"][0]) > LATE else 0.0
    time = log["time_s"] - start
    imposed = is_imposed(log, vehicle)
    nan, accel = np.full(len(time), np.nan), np.zeros(len(time))
    speed = np.ascontiguousarray(log["speed_mps"]) if has(log, "speed_mps") else nan
    unseen = None
    if imposed:
        if not has(log, "speed_mps"):
            _refuse(log, vehicle)
        unseen = in_holes(time, np.isfinite(speed))
        felt = log["accel_x_mps2"] if has(log, "accel_x_mps2") else None
        speed, accel = smoothed(time, speed, felt, jerk)
        if len(time) > 2 and not accel.any() and window < SAMPLED * _interval(time):
            accel = np.where(speed > 0, np.gradient(speed, time), 0.0)
    road, distance = _road(log, vehicle, time, speed)
    ref, steer, throttle, aux, yaw_rate = (
        _whole(log, time, column)
        for column in (
            *("speed_ref_mps", "steer_cmd_rad", "throttle", "aux_power_w"),
            "yaw_rate_radps",
        )
    )
    current, torque = (
        np.ascontiguousarray(log[c]) if has(log, c) else nan
        for c in ("motor_current_a", "motor_torque_nm")
    )
    return Drive(
        time,
        imposed,
        has(log, "steer_cmd_rad"),
        (ref, steer, throttle, aux),
        road,
        (speed, current, yaw_rate, torque, accel),
        window,
        start,
        distance,
        (holds(ref), holds(steer)),
        stated=distance is not None and not is_surveyed(log),
        climbed=has(log, "elevation_m") and not has(log, "slope"),
        unseen=unseen,
    )


def in_holes(time: Array, known: NDArray[np.bool_]) -> NDArray[np.bool_] | None:
    """Return the rows that lie in long holes between readings; None where none does."""
    rows = np.flatnonzero(known)
    if len(rows) < 2:
        return None
    after = np.searchsorted(rows, np.arange(len(time)))
    before = np.pad(time[rows], (1, 0), constant_values=-inf)[after]
    next_one = np.pad(time[rows], (0, 1), constant_values=inf)[after]
    hole = ~known & (next_one - before > HOLE * _interval(time[rows]))
    return hole if hole.any() else None


def holds(command: Array) -> bool:
    """Tell whether a command stays as it is for some rows and then leaps.

    One that holds between its messages leaps from row to row; a driver's hand, or a
    cycle's speed, moves over several. It holds if ``LEAPT`` of its way is leapt.
    """
    way = np.abs(np.diff(command))
    way[way <= ROUNDING * np.ptp(command)] = 0.0
    still = np.pad(way == 0.0, 1, constant_values=True)
    return bool(way[still[:-2] & still[2:]].sum() > LEAPT * way.sum())


def _refuse(log: Trace, vehicle: Vehicle) -> None:
    mode = vehicle.controller.mode if vehicle.controller else "torque"
    command = COMMANDS.get(mode)
    either = f"{command}, or speed_mps" if command else "speed_mps"
    raise InputError(
        f"{log.name}: nothing drives {vehicle.name}, whose mode is {mode}: "
        f"the log should hold {either}",
        f"there are {', '.join(log.columns)}",
    )


def _whole(log: Trace, time: Array, column: str) -> Array:
    """Return a column without gaps; zeros where the log does not have it."""
    if not has(log, column):
        return np.zeros(len(time))
    values = np.ascontiguousarray(log[column])
    known = np.isfinite(values)
    return values if known.all() else np.interp(time, time[known], values[known])


def integral_of(time: Array, rate: Array) -> Array:
    """Way since the first row, from rates at the rows: m from m/s, rad from rad/s."""
    steps = 0.5 * (rate[1:] + rate[:-1]) * np.diff(time)
    return np.concatenate([[0.0], np.cumsum(steps)])


def is_surveyed(log: Trace) -> bool:
    """Tell whether a log holds the slope of its road, or its elevation."""
    return has(log, "elevation_m") or has(log, "slope")


def _road(
    log: Trace, vehicle: Vehicle, time: Array, speed: Array
) -> tuple[tuple[Array, Array], Array | None]:
    """Return the slope over distance that log or file know, and the rows' distances."""
    stated = None if is_surveyed(log) else road_of(vehicle)
    if not is_surveyed(log) and stated is None:
        return (np.zeros(1), np.zeros(1)), None
    v = np.where(np.isfinite(speed), speed, 0.0)
    distance = np.maximum.accumulate(integral_of(time, v))
    if stated is not None:
        return stated, distance
    if has(log, "slope"):
        s, first = np.unique(distance, return_index=True)
        return (s, _whole(log, time, "slope")[first]), distance
    return surveyed_slope(distance, log["elevation_m"]), distance
