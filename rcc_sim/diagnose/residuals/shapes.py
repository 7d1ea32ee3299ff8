"""What may be a little off in a log without being a cause, by what it does to channels.

Each is a shape for every channel that is compared, which a fit adds in some size: the
drag of bends that a driver makes up for late, load that moves between the axles,
readings that are not of their row's own time, sensors that read too much.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from rcc_sim.analyse.heading import TURN_RATE
from rcc_sim.analyse.offsets import scale_sd
from rcc_sim.channel import moving_mean
from rcc_sim.definitions.sensors import ACCELEROMETERS, INERTIAL
from rcc_sim.definitions.vehicle import Vehicle
from rcc_sim.diagnose.residuals.beside_motor import MOTOR
from rcc_sim.diagnose.residuals.lateness import (
    FLOWS_OF,
    NEIGHBOURS,
    battery_channel,
    without_slow,
)
from rcc_sim.diagnose.residuals.terminals import (
    BEYOND_SHAFT,
    CURRENT,
    VOLTAGE,
    knows_voltage,
)
from rcc_sim.physics.effects.tyre_saturation import slip_angle, tyre_stiffness
from rcc_sim.simulate.smooth import slopes_beside
from rcc_sim.simulate.spans import CLOSE, FLOWS
from rcc_sim.units import G

if TYPE_CHECKING:
    from rcc_sim.diagnose.residuals.problem import Problem

Array = NDArray[np.float64]

TORQUE, ALTIMETER = "motor_torque_nm", "elevation_m"

FELT = "accel_x_mps2"
"""Column in which a slope is felt, and no drag."""

ACROSS = "accel_y_mps2"

LATERAL = ("yaw_rate_radps", TURN_RATE, ACROSS)

BEND_SHARE = 0.5
"""Share of a bend's drag that a driver may make up for late, one sd."""

MADE_UP = 1.0
"""Time in which a driver makes up for what a bend took from the speed. [s]"""

OFF_THE_ROW = 0.3
"""Rows by which readings may be off their row's time, one sd: half a row either way."""

POLLED, ASKED = 0.25, 0.5
"""Time between two rows [s] from which a logger may ask for its readings one after
another, as at the diagnostic socket of a car; and rows by which one may then come later
than another, one sd.
"""

SHOWN = 30.0
"""Nats by which readings of other instants than their rows must show."""

CALMED = 5
"""Rows over which a channel is a mean before its rate of change is taken."""

A_LITTLE = 0.01
"""Share by which a torque or a slope is changed to see what its gain does."""

DISCHARGED = 0.1
"""Share of an open-circuit voltage that the charge of a drive may take, one sd."""

SLOPES = ("slope_before", "slope_after")

SCALE = ".scale"

USUAL_HEIGHT = 0.3
"""Height of a centre of gravity in wheelbases, where a file states none."""

GRIP, NEAR = "effects.tyre_saturation.friction_coefficient", 0.9
"""Figure that limits an axle's force, and the share of it up to which load is told."""

MOVED = 0.08
"""Time in which load has moved, and the car turns by it: of cars whose springs take
0.005 to 0.15 s it leaves 4 nats at most. [s]"""

MOST_MOVED = 0.7
"""Share of an axle's load that may move, as far as a stiffness of the model tells."""

STIFFNESS = (
    "effects.front_cornering_stiffness.scale",
    "effects.rear_cornering_stiffness.scale",
)
"""By what the model's axles are made stiffer in cornering."""


class Shape(NamedTuple):
    """What size 1 adds to each channel that is compared, and one sd of the size."""

    tracks: list[Array]
    sd: float


def shapes_of(problem: Problem) -> dict[str, Shape]:
    """Return all that may be a little off in a log, by name."""
    off = {name: Shape(x, BEND_SHARE) for name, x in bends_of(problem).items()}
    late = {name: Shape(x, OFF_THE_ROW) for name, x in late_of(problem).items()}
    late |= {name: Shape(x, ASKED) for name, x in asked_of(problem).items()}
    off |= late if is_shown(problem, [s.tracks for s in late.values()]) else {}
    fallen = discharge_of(problem)
    if fallen:
        off["discharge"] = Shape(fallen, DISCHARGED)
    moved = load_transfer_of(problem)
    if moved:
        off["load_transfer"] = Shape(moved, height_of(problem.vehicle))
    for column, tracks in scaled_of(problem).items():
        sd = scale_sd(problem.vehicle, column)
        if sd > 0:
            known = [np.nan_to_num(x) for x in tracks]
            off[column + SCALE] = Shape(known, sd)
    return off


def added_by(problem: Problem, name: str) -> dict[int, Array | float]:
    """What size 1 of a shape, or of a channel's offset, adds to what it changes."""
    shape, channels = problem.shapes.get(name), problem.channels
    if shape is not None:
        return dict(enumerate(problem.beside(shape.tracks)))
    if name != MOTOR:
        return {k: 1.0 for k, c in enumerate(channels) if c == name}
    told = problem.beside(
        [np.full(len(problem.log), float(c == name)) for c in channels]
    )
    return {k: x for k, x in enumerate(told) if x.any()}


def bends_of(problem: Problem) -> dict[str, list[Array]]:
    """What the drag of bends does to each channel, where it may go unseen.

    A car slows a little in a bend, by less than a noisy speed shows, until its driver
    makes up for it. In a drive that is imposed that share of the drag is missing in the
    power at first, and comes late; in all it is the same energy.
    """
    drive = problem.drive
    if not drive.imposed or problem.charge is not None:
        return {}
    if drive.steered:
        straight = drive.commanded(steer=np.zeros_like(drive.commands.steer))
    elif drive.measured.yaw_rate.any():
        straight = drive.known_as(yaw_rate=np.zeros_like(drive.measured.yaw_rate))
    else:
        return {}
    on = replace(problem, drive=straight).predict({})
    unmoved = (*LATERAL, FELT)
    drag = [
        np.nan_to_num(problem.nominal[c] - on[c]) * (c not in unmoved)
        for c in problem.channels
    ]
    return {"bend": [lagged(x, MADE_UP, problem.row) - x for x in drag]}


def lagged(x: Array, lag: float, row: float) -> Array:
    """Return x as it comes late by a first-order lag, both in seconds."""
    late = np.exp(-np.arange(0, 8 * lag, row) / lag)
    late /= late.sum()
    return np.convolve(x, late)[: len(x)]


def discharge_of(problem: Problem) -> list[Array]:
    """What an open-circuit voltage that falls with the charge does to each channel.

    Per share of it, at the largest charge that was taken (or given) since the start;
    where a file states it with an sd.
    """
    if knows_voltage(problem.vehicle) or VOLTAGE not in problem.channels:
        return []
    log = problem.log
    charge = np.cumsum(np.nan_to_num(log[CURRENT]) * np.gradient(log["time_s"]))
    stated = problem.vehicle.battery.open_circuit_voltage_v
    level = stated.value if stated else 0.0
    fall = level * charge / (np.abs(charge).max() or 1.0)
    return [-fall * (c == VOLTAGE) for c in problem.channels]


def load_transfer_of(problem: Problem) -> list[Array]:
    """What the load that moves between the axles does to each channel, per height.

    F_F ~ 1 - a_x h / (g l_R), F_R ~ 1 + a_x h / (g l_F), as in CommonRoad's
    single-track model: a planar bicycle's axles stay as stiff, and hold as much. As far
    as where it is largest, either way, and in between along a parabola: hard braking
    makes a car turn in by more than speeding up takes. Per unit of h / l, l the
    wheelbase, if that is what the file states.
    """
    steered = problem.drive.steered and set(LATERAL) & set(problem.channels)
    if not steered or problem.charge is not None:
        return []
    felt = lagged(np.nan_to_num(problem.nominal[FELT]), MOVED, problem.row)
    felt *= with_grip(problem) / G
    body, height = problem.vehicle.body, height_of(problem.vehicle)
    up = height * problem.vehicle.wheelbase
    arms = (-up / body.cg_to_rear_axle_m.value, up / body.cg_to_front_axle_m.value)
    most = min(float(np.abs(felt).max()), MOST_MOVED / max(map(abs, arms)))
    if most == 0.0:
        return [np.zeros(len(felt)) for _ in problem.channels]
    felt = np.clip(felt, -most, most) / most
    pairs = [*zip(STIFFNESS, arms, strict=True)]
    less, more = (
        problem.predict({k: problem.stated(k) * (1 + x * arm) for k, arm in pairs})
        for x in (-most, most)
    )
    told = []
    for channel in problem.channels:
        none = problem.nominal[channel]
        ends = np.nan_to_num([less[channel] - none, more[channel] - none])
        odd, even = 0.5 * (ends[1] - ends[0]), 0.5 * (ends[1] + ends[0])
        told.append((odd * felt + even * felt**2) / height)
    return told


def with_grip(problem: Problem) -> Array:
    """Return how much more a load changes an axle's force than its stiffness alone. [1]

    F / (α dF/dα): stiffness and grip are both in proportion to it. Either axle is as
    near to its grip as the car is to what both can hold.
    """
    grip = problem.vehicle.figures().get(GRIP)
    if grip is None:
        return np.ones(len(problem.log))
    part = np.linspace(0.0, NEAR, 100)[1:]
    alpha = [slip_angle(x, 1.0, 1.0) for x in part]
    slope = [tyre_stiffness(x, 1.0, 1.0) for x in alpha]
    used = np.abs(np.nan_to_num(problem.nominal[ACROSS])) / (grip.value * G)
    more: Array = np.interp(used, part, part / np.multiply(alpha, slope))
    return more


def height_of(vehicle: Vehicle) -> float:
    """Return the height of the centre of gravity as a share of the wheelbase."""
    height = vehicle.body.cg_height_m
    return height.value / vehicle.wheelbase if height else USUAL_HEIGHT


def late_of(problem: Problem) -> dict[str, list[Array]]:
    """What readings that are not of their row's time do to each channel, per row.

    Between commands of some rows a second no log says for certain whether its flows, or
    its accelerometers, are samples or means since the row before. Where a torque that
    was measured drives the model, it is on another clock than the battery's meter, and
    filtered otherwise: of a BMW's current 0.4 is by its row's torque, the rest by that
    of the three about it. What that leaves in fast changes would be told as a gain. If
    its readings are clearly late, about where they are.
    """
    if problem.row < CLOSE or problem.charge is not None:
        return {}
    if is_shaped(problem):
        read = problem.nominal
        if problem.late:
            time = problem.log["time_s"]
            ago = time - problem.late
            read = {c: np.interp(ago, time, read[c]) for c in problem.channels}
        each = [(c in BEYOND_SHAFT, read[c]) for c in problem.channels]
        off = {
            k: [np.nan_to_num(shifted(x, k) - x) * its for its, x in each]
            for k in NEIGHBOURS
        }
        if problem.late:  # by how much is the delay's to tell
            sums = {k: zip(off[k], off[-k], strict=True) for k in NEIGHBOURS if k > 0}
            return {f"flows_{k}": [a + b for a, b in of] for k, of in sums.items()}
        return {FLOWS_OF.format(k): tracks for k, tracks in off.items()}
    if problem.drive.imposed:
        return {}
    # as measured: the model's own rates are wrong where a cause is missing
    calm = [moving_mean(problem.log[c], CALMED) for c in problem.channels]
    rates = [problem.row * np.gradient(x, problem.log["time_s"]) for x in calm]
    kinds = {"late_flows": FLOWS, "late_accel": ACCELEROMETERS}
    return {
        kind: [-x * (c in those) for c, x in zip(problem.channels, rates, strict=True)]
        for kind, those in kinds.items()
        if set(those) & set(problem.channels)
    }


def asked_of(problem: Problem) -> dict[str, list[Array]]:
    """What a slow logger's asking one after another does to each channel.

    Where flows are samples, by the slope of the speed before a row or after it in place
    of its own: either may be that of the instant at which they were read. Where a
    torque was among them, beyond the shaft by the speed of so many rows later.
    """
    drive = problem.drive
    time, (speed, *_, accel) = drive.time, drive.measured
    if problem.row < POLLED or problem.late or not is_shaped(problem):
        return {}

    def by(size: float = 1.0, **other: Array) -> list[Array]:
        out = replace(problem, drive=drive.known_as(**other)).predict({})
        off = (out[c] - problem.nominal[c] for c in problem.channels)
        return [np.nan_to_num(x) / size for x in off]

    found, moves = {}, speed > 0  # a car at rest has no drag of any kind
    if accel.any():
        beside = zip(SLOPES, slopes_beside(time, speed), strict=True)
        found = {k: by(accel=moves * x) for k, x in beside}
    if problem.torqued:
        later = np.interp(time + A_LITTLE * problem.row, time, speed)
        told = problem.beside(by(A_LITTLE, speed=moves * later))
        its = [c in BEYOND_SHAFT for c in problem.channels]
        found["speed_later"] = [x * of for x, of in zip(told, its, strict=True)]
    return found


def is_shown(problem: Problem, off: Sequence[list[Array]]) -> bool:
    """Tell whether readings of a slow log are of other instants than its rows.

    Where no torque was logged beside the battery: by what is ``off`` at each row a line
    of least squares through what was logged, all without what is slow, leaves less than
    one of the prediction and of what figures of the car do (v, v a, v³). What they
    might be off by would be taken from what acts: 1 to 17 nats in three roads and a
    changing load where no reading is; 58 to 600 in 18 logs of others' and our own, two
    of which have nothing but corners between their rows.
    """
    if problem.torqued or not (off and is_shaped(problem)):
        return True
    column, time, v = battery_channel(problem), problem.log["time_s"], problem.speed
    if not column:
        return False
    at = problem.channels.index(column)
    figures = [problem.nominal[column], v, v * np.gradient(v, time), v**3]
    told = (problem.log[column], *figures, *(tracks[at] for tracks in off))
    y, *X = (without_slow(time, x)[problem.judged[at]] for x in told)

    def left(some: list[Array]) -> float:
        A = np.stack(some, axis=1)
        return float(np.std(y - A @ np.linalg.lstsq(A, y, rcond=None)[0]))

    without = left(X[: len(figures)])
    return len(y) * np.log(left(X) / without) < -SHOWN if without else False


def is_shaped(problem: Problem) -> bool:
    """Tell whether the battery's readings may be of the rows beside their own.

    As beside a torque on another clock, or where corners of the drive lie between rows.
    """
    apart = CLOSE if problem.torqued else POLLED
    return problem.drive.imposed and problem.row >= apart and problem.charge is None


def shifted(x: Array, rows: int) -> Array:
    """Return a channel (n,) as it is so many rows later; its ends go on."""
    n = len(x)
    return x[np.clip(np.arange(n) + rows, 0, n - 1)]


def scaled_of(problem: Problem) -> dict[str, list[Array]]:
    """What a sensor that reads too much does to each channel, per unit, by column.

    An inertial sensor does it to what it reads. An inverter works its torque out, from
    currents and a map: it is what an imposed drive takes its power from, too. An
    altimeter makes the slopes of the road: one that shows climbs where there are none
    reads too much by 1.
    """
    nominal, channels = problem.nominal, problem.channels
    found = {
        column: [nominal[c] * (c == column) for c in channels]
        for column in channels
        if column in (*INERTIAL, TORQUE)
    }
    if TORQUE in found and problem.drive.imposed:
        told = per_little(problem, problem.by_true_torque(A_LITTLE).predict({}))
        told[channels.index(TORQUE)] = nominal[TORQUE]
        found[TORQUE] = told
    _, slope = problem.drive.road
    if problem.surveyed and slope.any():
        felt = problem.by_felt_road(A_LITTLE).predict({})
        found[ALTIMETER] = per_little(problem, felt)
    return found


def per_little(problem: Problem, out: Mapping[str, Array]) -> list[Array]:
    """Return what ``A_LITTLE`` more of something does to each channel, per unit."""
    return [(out[c] - problem.nominal[c]) / A_LITTLE for c in problem.channels]
