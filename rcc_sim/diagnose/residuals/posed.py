"""A log posed as a problem: its power worked out, its noise kept from driving it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from math import inf

import numpy as np
from numpy.typing import NDArray

from rcc_sim.analyse.charge import charge_of
from rcc_sim.analyse.gap_energy import logged_power
from rcc_sim.analyse.gap_stages import untorqued
from rcc_sim.analyse.heading import TURN_RATE, measured_turn
from rcc_sim.analyse.sampled import drive_as_sampled
from rcc_sim.channel import is_nil, is_rough, sensor_noise
from rcc_sim.definitions.vehicle import Vehicle
from rcc_sim.diagnose.residuals.beside_motor import MOTOR, drawn_by_motor
from rcc_sim.diagnose.residuals.problem import Problem
from rcc_sim.diagnose.residuals.terminals import CURRENT, POWER
from rcc_sim.simulate.drive import Drive
from rcc_sim.simulate.replay import RECALLS, replay
from rcc_sim.simulate.smooth import jerk_of, smooth_speed
from rcc_sim.trace import Trace

Array = NDArray[np.float64]

NOISE_IN, DOUBLINGS = 0.25, 5
"""Share of a sensor's noise that the noise of a speed may make of its prediction, and
times that the recall of the speed is doubled for it at most. Whatever smooths what
comes in so, as a motor's lag does, would gain by that: 360 nats in 70 s of a scaled car
whose speed has 0.03 m/s of noise, where nothing was hidden.
"""


SMOOTHED_OVER, NO_MORE = (32, 16, 8, 4, 2), 1.1
"""Rows over which a measured torque is smoothed, and times its noise that this may take
from it: more is the drive's own."""


def problem_of(log: Trace, vehicle: Vehicle) -> Problem:
    """Return a log as a problem for a vehicle; its battery power is worked out."""
    power = logged_power(log)
    if power is not None and "battery_power_w" not in log:
        log = Trace({**log.columns, "battery_power_w": power}, name=log.name)
    drive = drive_as_sampled(log, vehicle)
    charged = by_charge(log, vehicle, drive)
    if charged is not None:
        return charged
    drive = kept_still(drive)
    turn = measured_turn(log, vehicle.wheelbase)
    if turn is None:
        return recalling(calmed(Problem(vehicle, log, drive)))
    log = Trace({**log.columns, TURN_RATE: turn.since}, name=log.name)
    return recalling(calmed(Problem(vehicle, log, drive, turned=turn.at)))


def kept_still(drive: Drive) -> Drive:
    """Return a commanded drive that stands where nothing is asked and nothing moves.

    A speed's noise there is its sensor's: the model would be drawn after it, and what
    holds a vehicle at rest, as dry friction does, would gain. In a minute that a car
    was parked, with 0.01 m/s of noise, it was named for sure.
    """
    speed, commands = drive.measured.speed, drive.commands
    if drive.imposed or not np.isfinite(speed).any():
        return drive
    rests = (commands.ref == 0) & (commands.throttle == 0)
    rests &= is_nil(drive.time, speed, sensor_noise(speed))
    return drive.known_as(speed=np.where(rests, 0.0, speed))


def calmed(problem: Problem) -> Problem:
    """Return an imposed drive by a measured torque, without that torque's noise.

    It is measured against that which the motion takes, so that corners of the drive
    stay: the difference is smoothed, over the most rows over which that takes no more
    than the noise, and nothing that follows the torque from row to row. A noisy torque
    that drives the model would foresee the power too strongly, by as much as its noise
    is of what it changes by, and whatever follows the motion instead would gain: where
    the torque of a drive on a motorway had 4 N m of noise, and nothing was hidden, a
    payload was named, a load and a drag. One that has lost what the motion does not
    tell foresees it too weakly: where a wind of 6 m/s was unknown, and its torque
    smoothed over 1.6 s, an efficiency was 2 % off.
    """
    drive, torque = problem.drive, problem.drive.measured.torque
    if not problem.torqued or not is_rough(torque):
        return problem
    noise, row = sensor_noise(torque), problem.row
    white = np.random.default_rng(0).normal(0.0, noise, len(torque))
    by_motion = replay(problem.vehicle, untorqued(drive))["motor_torque_nm"]
    for rows in SMOOTHED_OVER:
        how = {"noise": noise, "jerk": jerk_of(noise, row, rows * row)}
        taken = rough_part(drive.time, torque - by_motion, **how)
        if np.nanstd(taken) > NO_MORE * noise:
            continue
        chance = rough_part(drive.time, white, **how)
        lost = in_common(taken, rough_part(drive.time, torque, **how))
        if rows == SMOOTHED_OVER[-1] or lost <= in_common(chance, chance):
            calm = np.where(np.isfinite(torque), torque - taken, np.nan)
            return replace(problem, drive=drive.known_as(torque=calm))
    return problem


def rough_part(time: Array, x: Array, *, noise: float, jerk: float) -> Array:
    """Return what smoothing takes from a channel."""
    return x - smooth_speed(time, x, noise=noise, jerk=jerk)[0]


def in_common(one: Array, other: Array) -> float:
    """Return the mean product of two channels a row apart: white noise has none."""
    return 0.5 * float(np.nanmean(one[1:] * other[:-1] + other[1:] * one[:-1]))


def recalling(problem: Problem) -> Problem:
    """Return a drive of a speed loop drawn to its speed as gently as that is noisy.

    The loop itself holds the model to its reference; an open-loop car would drift.
    """
    speed = problem.drive.measured.speed
    loops = problem.vehicle.mode == "speed"
    if problem.drive.imposed or not loops or not np.isfinite(speed).any():
        return problem
    rng = np.random.default_rng(0)
    more = speed + rng.normal(0.0, sensor_noise(speed), len(speed))
    noisier = replace(problem, drive=problem.drive.known_as(speed=more))
    judged = [c for c in problem.channels if c != "speed_mps"]
    noise = {c: sensor_noise(problem.log[c]) for c in judged}
    gentle, integral, hold = RECALLS
    hold = min(hold, held_by(problem, noise))
    for _ in range(DOUBLINGS):
        one, two = (
            p.driven({}, (gentle, integral, hold), coarse=True)
            for p in (problem, noisier)
        )
        if all(np.nanstd(two[c] - one[c]) <= NOISE_IN * noise[c] for c in judged):
            break
        gentle *= 2
    if (gentle, integral, hold) == RECALLS:
        return problem  # with what it has worked out already
    return replace(problem, recalls=(gentle, integral, hold))


def held_by(problem: Problem, noise: Mapping[str, float]) -> float:
    """Return the share of a loop's stiffness by which a coasting car may be drawn.

    Drawn at a rate λ, the model's speed takes on s √(λ/2f) of the noise s of its f rows
    a second, and its loop, which lets go and takes hold again, makes currents of that.
    ``noise`` is that of the channels that are judged.
    """
    vehicle, control = problem.vehicle, problem.vehicle.controller
    gain = control.proportional_gain_as_per_rad if control else None
    if gain is None or not problem.stiffness:
        return 1.0
    made = gain.value * vehicle.rad_per_m * sensor_noise(problem.log["speed_mps"])
    made *= float(np.sqrt(problem.stiffness * problem.row / 2))
    per = {MOTOR: 1.0} | {
        c: float(np.nanmax(drawn_by_motor(vehicle, problem.nominal, c)))
        for c in (CURRENT, POWER)
        if c in noise
    }
    least = min(
        (noise[c] / per[c] for c in per if noise.get(c) and per[c]), default=inf
    )
    return (NOISE_IN * least / made) ** 2 if made > 0 else 1.0


def by_motion(problem: Problem) -> Problem:
    """Return the same drive, its power by its motion and not by the torque logged."""
    if not problem.drive.imposed:
        return problem
    return replace(problem, drive=untorqued(problem.drive))


def at_own_rows(problem: Problem, log: Trace) -> Problem:
    """Return the problem of a log at its own rows, its flows means, not by its charge.

    ``log`` is what was logged.
    """
    if problem.charge is None:
        return problem
    plain = problem_of(log, problem.vehicle)
    return replace(plain, drive=replace(plain.drive, window=inf))


def by_charge(log: Trace, vehicle: Vehicle, drive: Drive) -> Problem | None:
    """Return a log as one row a stretch between two states of charge, if it is one.

    Every other channel is then a mean over the stretch, too.
    """
    charge = charge_of(log, vehicle) if drive.imposed else None
    if charge is None:
        return None
    drive = replace(drive, window=inf, unseen=None)  # a stretch tells how much it was
    columns = {name: charge.means(x) for name, x in log.columns.items()}
    columns["battery_power_w"] = charge.power
    bridged = ~np.isfinite(log["speed_mps"])
    return Problem(vehicle, Trace(columns, name=log.name), drive, charge, bridged)
