"""Whether a log's currents and powers are samples, or means since the row before."""

from __future__ import annotations

from dataclasses import replace
from math import inf

import numpy as np

from rcc_sim.analyse.gap_energy import logged_power
from rcc_sim.analyse.gap_stages import untorqued
from rcc_sim.channel import interval_of, noise_of
from rcc_sim.definitions.vehicle import Vehicle
from rcc_sim.simulate.drive import ROUNDING, Drive, drive_of, has_commands
from rcc_sim.simulate.replay import replay
from rcc_sim.simulate.smooth import without_noise
from rcc_sim.simulate.spans import (
    CLOSE,
    ENOUGH,
    FLOWS,
    LONG,
    middle_of,
    nats_for_means,
)
from rcc_sim.trace import Trace

SAMPLE = 0.01
"""Time over which a sample is a mean: an inverter's own. [s]"""

SURE, EXACT, SHIFTED = 3.0, 0.05, 0.1
"""Standard deviations, rows, and share of what a noisy speed is smeared by, that means
since the row before may seem to be off the middle of that time. Flows that are farther
off it are samples of another clock than the speed's, as on a car's bus."""

NEARER = 0.25
"""Rows from the middle of a mean beyond which a sample's own time is nearer."""


def drive_as_sampled(
    log: Trace, vehicle: Vehicle, window: float | None = None
) -> Drive:
    """Return what drove the vehicle of a log, its flows averaged as its logger does.

    Parameters
    ----------
    log, vehicle
        As for :func:`rcc_sim.simulate.drive.drive_of`.
    window : float or None
        Time before a row over which flows are averaged; None: as the log tells, 10 ms
        for samples, without end for means since the row before. [s]

    Raises
    ------
    InputError
        If the log has neither commands nor a speed.
    """
    if window is not None:
        return drive_of(log, vehicle, window)
    if "battery_energy_j" in log:  # our own trace
        return drive_of(log, vehicle, inf)
    row = interval_of(log["time_s"])
    asked = may_be_means(row, imposed=not has_commands(log, vehicle))
    means = asked and holds_means(log, vehicle)
    return drive_of(log, vehicle, inf if means else SAMPLE)


def may_be_means(row: float, *, imposed: bool) -> bool:
    """Tell whether rows [s] are so far apart that samples and means differ."""
    return row > (1 - ROUNDING) * (LONG if imposed else CLOSE)


def holds_means(log: Trace, vehicle: Vehicle) -> bool:
    """Tell whether a log's flows are means since the row before.

    Neither an accelerometer nor a torque that was logged drives the model here: they
    are samples or means themselves, and would draw it to either. Between commands a
    delay that the model lacks makes flows late, and says nothing of them: they are
    means there, as a VESC gives them at each request [1]_, unless samples are likelier.

    References
    ----------
    .. [1] B. Vedder, VESC firmware, comm/commands.c, COMM_GET_VALUES: currents are
           averages since they were read before.
    """
    kept = {c: x for c, x in log.columns.items() if c != "accel_x_mps2"}
    drive = evened(untorqued(drive_of(Trace(kept, name=log.name), vehicle, inf)))
    row = interval_of(drive.time)
    power = logged_power(log)
    seen = {c: log[c] for c in FLOWS if log.has(c)}
    if power is not None:
        seen["battery_power_w"] = power
    mean = replay(vehicle, drive)
    half = replay(vehicle, replace(drive, window=0.5 * row))
    shown = [(x, mean[c], half[c]) for c, x in seen.items() if c in mean]
    nats = [nats_for_means(*channel, drive.smear / row) for channel in shown]
    over_sample, over_late = (
        float(sum(x)) for x in zip((0.0, 0.0), *nats, strict=True)
    )
    if not nats:
        return False
    if not drive.imposed:
        return over_sample > -ENOUGH
    if over_sample <= ENOUGH or over_late <= -ENOUGH:
        return False
    off, sd = middle_of(shown, drive.smear / row)
    most = SURE * sd + EXACT + SHIFTED * drive.smear / row
    return -most <= off <= min(most, NEARER)


def evened(drive: Drive) -> Drive:
    """Return an imposed drive whose speed is free of noise that passes for its own.

    Of rows a second apart a drive bends more than a usual sensor errs, and they count
    as exact. From one row to the next such a noise is twice as large in a mean since
    the row before as in an average about a row, which would seem to fit better.
    """
    speed = drive.measured.speed
    if not drive.imposed or drive.smear or not np.isfinite(speed).all():
        return drive
    noise = noise_of(speed)
    if noise == 0.0:
        return drive
    calm, change, smear = without_noise(drive.time, speed, noise)
    return replace(drive.known_as(speed=calm, accel=change), smear=smear)
