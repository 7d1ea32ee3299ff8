"""A logged drive, run again: the vehicle under the log's own inputs."""

from __future__ import annotations

import math
from collections.abc import Collection
from math import inf

import numpy as np
from numpy.typing import NDArray

from rcc_sim.definitions.figure import Figure
from rcc_sim.definitions.kernel import (
    efficiency_map,
    force_table,
    kernel_params,
    loop_stiffness,
)
from rcc_sim.definitions.vehicle import Vehicle
from rcc_sim.errors import InputError
from rcc_sim.physics import params as schema
from rcc_sim.physics import record
from rcc_sim.physics.effects import sensor_delay
from rcc_sim.physics.logged_motion import run_with_logged_motion
from rcc_sim.physics.replay import run_replayed
from rcc_sim.physics.rows import Measured
from rcc_sim.simulate.columns import log_columns
from rcc_sim.simulate.drive import ROUNDING, Drive
from rcc_sim.simulate.own import own_terms
from rcc_sim.simulate.run import delay_lines
from rcc_sim.simulate.sensors import sensed_columns

Array = NDArray[np.float64]

Recalls = tuple[float, float, float]
FREE: Recalls = (inf, inf, 0.0)
"""Times in which speed, and the speed loop's integral, are drawn to what was measured;
and by what share of its loop's stiffness the speed is besides, where no loop holds it.
Of a free run, none. [s], [s], [1]"""

RECALLS: Recalls = (0.2, 1.0, 1.0)
"""The same of a run that stays near its log. Well above a row and well below a
manoeuvre: a rough road then does not add up, and whatever memory this leaves in what
the run errs by is short.
"""

COARSE = 0.005
"""Longest time step of a commanded run that need only be near. [s]

Enough for what a change of a figure does, the error being much the same without it.
"""

STEP, COARSE_STEP = 0.034, 0.1
"""Longest time steps of an imposed run, and of one that need only be near, in times in
which the vehicle answers its steering: the step then changes less than a hundredth of
what noise does. [1]"""

RELAXED = 0.5
"""The same of tyres that relax, as a share: their lag asks for shorter steps. [1]"""

LONGEST = 0.1
"""Longest time step of an imposed run of any vehicle. [s]"""

WHEELS = 0.03
"""Inertia of the wheels as a share of the mass (effective mass 1.03 m, SAE J1263)."""

OF_THE_ROAD = (
    ("road_grade", "slope"),
    ("headwind", "speed_mps"),
    ("rolling_resistance", "coefficient"),
    ("aerodynamic_drag", "drag_area_m2"),
    ("steering_drag", "force_n_per_rad"),
    ("steering_offset", "angle_rad"),
)
"""Figures that do nothing where the wheels turn off the ground."""


def replay(
    vehicle: Vehicle,
    drive: Drive,
    recalls: Recalls = FREE,
    *,
    stiffness: float | None = None,
    substeps: int = 1,
    coarse: bool = False,
    turned: Array | None = None,
    wheels: float = 1.0,
    speed_offset: float = 0.0,
    only: Collection[str] = (),
) -> dict[str, Array]:
    """Run the vehicle along a log; return what it predicts at the log's rows.

    Parameters
    ----------
    vehicle, drive
        What is driven, and by what (:func:`drive_of`).
    recalls : (float, float, float)
        How speed and the speed loop's integral are drawn to what was measured (`FREE`).
    stiffness : float or None
        That of the loop, of which the last of them is a share; None: of the vehicle's
        own (:func:`~rcc_sim.definitions.kernel.loop_stiffness`). [1/s]
    substeps : int
        Runs of the loop in place of one, to see what the time step costs.
    coarse : bool
        Take longer time steps (``COARSE``, ``COARSE_STEP``), several times as fast.
    turned : ndarray, shape (n,), or None
        True yaw rate at the rows, by another measurement than the gyro; NaN where not
        known. What the gyro shows then follows from it, not from the model. [rad/s]
    wheels : float
        Inertia of the wheels over ``WHEELS``, by which they turn off the ground.
    speed_offset : float
        What the speed sensor reads too much throughout. [m/s]
    only : collection of str
        Columns that are wanted, beside time and heading; all where empty.

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
    elif not drive.on_stand:
        values["lanes"]["steer"] = schema.TURNED
    if drive.back:
        values["road_grade"]["slope"] *= -1.0
        values["headwind"]["speed_mps"] *= -1.0
    if drive.on_stand:
        lift(vehicle, values, WHEELS * wheels)
    control = values["control"]
    if drive.imposed:
        relaxed = values["tyre_relaxation"]["length_m"] > 0.0
        control["T_loop"] = _longest_step(drive, coarse=coarse, relaxed=relaxed)
        control["delta_max"] = control.get("delta_max", inf)
    elif coarse:
        control["T_loop"] *= max(math.floor(COARSE / control["T_loop"] + 1e-6), 1)
    control["T_loop"] /= substeps
    n = len(drive.time)
    own = own_terms(vehicle)
    P, work, sinks = own.records()
    record.fill(P, values)
    table = record.array(schema.ROW, n)
    measured, ago = as_true(vehicle, drive, speed_offset)
    given = (
        (drive.time, drive.commands, drive.held),
        road_driven(vehicle, drive),
        measured,
        (efficiency_map(vehicle), force_table(vehicle)),
    )
    if drive.imposed:
        longest, filled = control["T_loop"], (table, sinks, drive.window)
        own.call(run_with_logged_motion, True, P, work, *given, *filled, longest)
    else:
        lines = delay_lines(values)
        of_speed, of_integral, share = recalls
        stiff = loop_stiffness(vehicle) if stiffness is None else stiffness
        back = (of_speed, of_integral, share * stiff, ago)
        over = (table, sinks, (drive.window, drive.felt))
        own.call(run_replayed, True, P, work, *given, lines, *over, back)
    if any(o.kind == "sensed" for o in vehicle.own_acting):
        only = ()  # it may read any
    c = work[0][0]
    columns = log_columns(
        vehicle,
        table,
        n=float(c["n"]),
        n_file=float(c["n_file"]),
        K_t=float(c["K_t"]),
        only=only,
    )
    columns["yaw_rad"] = record.column(table, "psi")
    if turned is not None and "yaw_rate_radps" in columns:
        simulated = columns["yaw_rate_radps"]
        known = np.isfinite(turned)
        columns["yaw_rate_radps"] = np.where(known, turned, simulated)
    seen = sensed_columns(vehicle, columns, imposed=drive.imposed)
    if speed_offset and "speed_mps" in seen:
        seen["speed_mps"] = seen["speed_mps"] + speed_offset
    if drive.unseen is not None:
        seen = {c: np.where(drive.unseen, np.nan, x) for c, x in seen.items()}
    seen["time_s"] = drive.time + drive.start
    return seen


def lift(vehicle: Vehicle, values: dict[str, dict[str, float]], wheels: float) -> None:
    """Take the wheels off the ground: they alone are moved, so much of the mass.

    Raises
    ------
    InputError
        If what holds the vehicle back is stated as a whole.
    """
    if "road_load" in vehicle.effects:
        raise InputError(
            f"{vehicle.where}: effects.road_load: is of road and bearings",
            "off the ground it is not known what is left of it: state its parts",
        )
    for effect, name in OF_THE_ROAD:
        values[effect][name] = 0.0
    values["payload"]["mass_kg"] = (wheels - 1.0) * values["body"]["m"]


def _longest_step(drive: Drive, *, coarse: bool, relaxed: bool) -> float:
    """Return the longest time step of an imposed run. [s]

    Where nothing turns it, nothing answers.
    """
    if not drive.steered and not drive.measured.yaw_rate.any():
        return LONGEST
    share = COARSE_STEP if coarse else STEP
    if relaxed and not coarse:
        share *= RELAXED
    return min(share * drive.answers, LONGEST)


def as_true(
    vehicle: Vehicle, drive: Drive, speed_offset: float = 0.0
) -> tuple[Measured, Array]:
    """Return what was measured as it was, by what the vehicle's sensors make of it.

    And how long before each row [s] the speed was what it then holds. ``speed_mps`` is
    the motor's speed with the file's tyre radius, and reads ``speed_offset`` too much,
    but where it reads nil; a reading that is late belongs to an earlier row. An imposed
    drive has the clock of its speed.
    """
    rolled = speed_share(vehicle)
    delays = (
        figure_of(vehicle, sensor_delay.EFFECT.id, p.name, p.neutral)
        for p in sensor_delay.EFFECT.params
    )
    late, *more = sensor_delay.behind_speed(*delays) if drive.imposed else delays
    of_speed, of_yaw, _, of_motor, _ = (late + x for x in more)
    speed, current, yaw_rate, torque, accel = drive.measured
    if speed_offset:
        speed = np.where(speed == 0.0, 0.0, speed - speed_offset)
    if rolled != 1.0:
        speed, accel = speed * rolled, accel * rolled
    measured = Measured(
        earlier(drive, speed, of_speed),
        earlier(drive, current, of_motor),
        earlier(drive, yaw_rate, of_yaw, drives=True),
        earlier(drive, torque, of_motor),
        earlier(drive, accel, of_speed),
    )
    ago = np.zeros(len(drive.time))
    if of_speed and not drive.imposed:
        then = drive.time + of_speed
        ago = np.maximum(then - drive.time[read_by(drive, of_speed)], 0.0)
    return measured, ago


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


def earlier(
    drive: Drive, values: Array, delay: float, *, drives: bool = False
) -> Array:
    """Return readings that came late, or early, [s] at the rows that they belong to.

    Between two rows it is the first of them, so that nothing is drawn to a reading
    that it has yet to predict; what ``drives`` a run, as all does that was measured of
    an imposed one, is interpolated.
    """
    known = np.isfinite(values)
    if delay == 0.0 or not known.any():
        return values
    then = drive.time + delay
    if drive.imposed or drives:
        whole = np.interp(then, drive.time[known], values[known])
        gaps = np.interp(then, drive.time, known.astype(float)) < 1 - ROUNDING
        return np.where(gaps, np.nan, whole)
    in_time = then <= drive.time[-1] + ROUNDING
    return np.where(in_time, values[read_by(drive, delay)], np.nan)


def read_by(drive: Drive, delay: float) -> NDArray[np.intp]:
    """Return the last row by when what was true at each had been read, late [s]."""
    then = drive.time + delay + ROUNDING
    return np.maximum(np.searchsorted(drive.time, then, side="right") - 1, 0)
