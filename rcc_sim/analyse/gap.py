"""Where a log and a model part: energy, channels, regimes, stages, windows."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import inf

import numpy as np
from numpy.typing import NDArray

from rcc_sim.analyse.charge import Charge, charge_of
from rcc_sim.analyse.gap_alarm import alarm_limit, strongest_first
from rcc_sim.analyse.gap_channels import (
    ChannelGap,
    Noise,
    channel_gap,
    noise_of,
    refuse_other_drives,
)
from rcc_sim.analyse.gap_energy import EnergyGap, share_uncertainty
from rcc_sim.analyse.gap_power import (
    POWERS,
    energy_gap,
    power_and_shifts,
    power_of,
)
from rcc_sim.analyse.gap_regimes import (
    HELD,
    REGIMES,
    RegimeGap,
    Scale,
    labels,
    regime_gaps,
    stands,
)
from rcc_sim.analyse.gap_replays import Progress, Tolerances, predicted, tolerances
from rcc_sim.analyse.gap_stages import StageGap, stage_gaps, untorqued
from rcc_sim.analyse.gap_windows import Window, windows
from rcc_sim.analyse.heading import measured_turn, seen_heading, turn_at
from rcc_sim.analyse.logcheck.finding import COMMANDS, Finding
from rcc_sim.analyse.logged import COMPARED, Logged
from rcc_sim.analyse.sampled import drive_as_sampled
from rcc_sim.channel import rows_in
from rcc_sim.definitions.vehicle import Vehicle
from rcc_sim.errors import InputError
from rcc_sim.simulate.drive import Drive, has_commands
from rcc_sim.trace import Trace

Array = NDArray[np.float64]

LATERAL = ("yaw_rate_radps", "accel_y_mps2")
"""Channels that are not judged while the vehicle hardly moves."""

AVERAGED = 10.0
"""Times of the vehicle's own over which a window's difference is averaged. [1]"""

FINEST = 1e-3
"""Share of a channel's size below which no difference is a window. [1]"""

USED = (*COMPARED, "motor_speed_radps")


@dataclass(frozen=True)
class Gap:
    """What :func:`gap` found; measured less simulated throughout.

    Parameters
    ----------
    log, vehicle : str
        Names.
    mode : str
        ``commanded`` or ``imposed``.
    energy : EnergyGap
        With its uncertainty.
    channels, regimes, stages, windows : tuple
        Where it sits; the channel that parts most first.
    findings : tuple of Finding
        What the check of the log found, and what was left out.
    notes : tuple of str
        What a person should know of how it was compared.
    kinds : ndarray of int
        Regime of each row.
    measured : Trace
        The log as compared.
    simulated : dict of ndarray
        The prediction at its rows.
    """

    log: str
    vehicle: str
    mode: str
    energy: EnergyGap
    channels: tuple[ChannelGap, ...]
    regimes: tuple[RegimeGap, ...]
    stages: tuple[StageGap, ...]
    windows: tuple[Window, ...]
    findings: tuple[Finding, ...]
    notes: tuple[str, ...]
    kinds: NDArray[np.intp]
    measured: Trace
    simulated: dict[str, Array]


def gap(
    logged: Logged,
    vehicle: Vehicle,
    *,
    repeats: Sequence[Trace] = (),
    window: float | None = None,
    progress: Progress | None = None,
) -> Gap:
    """Compare a log with a vehicle's model that is driven as the log was.

    The model runs freely: commanded where the log holds the commands that the
    vehicle's controller obeys, else on the measured motion.

    Parameters
    ----------
    logged : Logged
        From :func:`rcc_sim.analyse.logged.open_log`.
    vehicle : Vehicle
        The model, with the sds of its figures.
    repeats : sequence of Trace
        Other logs of the same drive, from which noise is known.
    window : float or None
        Time before a row over which its currents and powers are means; None: as the
        log tells (:func:`rcc_sim.analyse.sampled.drive_as_sampled`). [s]
    progress : callable or None
        Told the share that is done.

    Raises
    ------
    InputError
        If nothing drives the model, or it predicts nothing that the log holds; if a
        repeat is of another drive.
    """
    _refuse_unusable(logged, vehicle)
    refuse_other_drives(logged.log, repeats)
    log, drive, charge = _posed(logged.log, vehicle, window)
    tell = progress or (lambda share: None)
    simulated = predicted(
        vehicle, drive, USED, progress=lambda share: tell(0.3 * share)
    )
    channels = _channels(log, drive, simulated)
    base = {c: simulated[c] for c in (*channels, *_powers(simulated))}
    moved = tolerances(
        vehicle, drive, base, progress=lambda share: tell(0.3 + 0.5 * share)
    )
    if charge is not None:
        simulated = charge.as_known(simulated)
        moved = charge.tolerances(moved, vehicle)
    scale = Scale.of(vehicle)
    kinds = _kinds(log, drive, simulated, scale)
    compared = _compared(log, drive, simulated, channels, scale)
    memory = rows_in(drive.time, AVERAGED * scale.time)
    noises = {
        name: (charge.noise_of(e), "charge")
        if charge is not None and name == "battery_power_w"
        else noise_of(name, log, e, vehicle, repeats, memory)
        for name, e in compared.items()
    }
    gaps, when = _parted(log, simulated, compared, noises, moved, memory)
    del compared  # a long log's is large
    energy, measured, weights, moved = energy_gap(
        log, vehicle, drive, simulated, moved=moved
    )
    model = power_of(energy.at, simulated)
    power = None if measured is None else measured - model

    def driven(d: Drive) -> tuple[Array, Array]:
        power, shifts = power_and_shifts(vehicle, d, energy.at)
        if charge is None:
            return power, shifts
        return charge.at_rows(power), charge.shifts(shifts)

    tell(0.85)
    stages = stage_gaps(
        log,
        vehicle,
        drive,
        driven,
        simulated=model,
        measured=measured,
        weights=weights,
        moved=moved,
        energy=energy,
    )
    doubts = share_uncertainty(kinds, len(REGIMES), weights, moved, energy)
    tell(1.0)
    return Gap(
        log.name,
        vehicle.name,
        "imposed" if drive.imposed else "commanded",
        energy,
        tuple(gaps),
        tuple(regime_gaps(kinds, log["time_s"], power, weights, doubts)),
        tuple(stages),
        when,
        logged.findings,
        _notes(logged.log, log, drive, energy, gaps, moved, vehicle),
        kinds,
        log,
        simulated,
    )


def _refuse_unusable(logged: Logged, vehicle: Vehicle) -> None:
    """Say why the speed is missing that would have to drive the model."""
    log = logged.log
    if has_commands(log, vehicle) or log.has("speed_mps"):
        return
    found = reversed(logged.findings)  # of several of a channel the first counts
    wrong = {f.channel: f for f in found if f.severity == "error"}
    if "speed_mps" in wrong:
        lost = " and ".join(name for name in COMMANDS if name in wrong)
        why = (
            f"{lost} cannot be used either"
            if lost
            else f"the log holds no commands that {vehicle.name} obeys"
        )
        raise InputError(
            f"{log.name}: speed_mps: {wrong['speed_mps'].what}",
            f"the motion has to drive the model, for {why}; {wrong['speed_mps'].mend}",
        )


def _posed(
    log: Trace, vehicle: Vehicle, window: float | None
) -> tuple[Trace, Drive, Charge | None]:
    """Return a log as it is compared, what drives the model, and its charge if told.

    Power follows from the motion that was measured, not from a torque that was.
    """
    drive = drive_as_sampled(log, vehicle, window)
    charge = charge_of(log, vehicle) if drive.imposed else None
    if charge is not None:
        drive = replace(drive, window=inf)
        columns = {**log.columns, "battery_power_w": charge.held(charge.power)}
        log = Trace(columns, name=log.name)
    if drive.steered:
        log = _turning(log, vehicle)
    return log, untorqued(drive) if drive.imposed else drive, charge


def _turning(log: Trace, vehicle: Vehicle) -> Trace:
    """Return a log without a gyro with the yaw rate of a heading that was measured."""
    if log.has("yaw_rate_radps") or not measured_turn(log, vehicle.wheelbase):
        return log
    turn = turn_at(log["time_s"], seen_heading(log))
    return Trace({**log.columns, "yaw_rate_radps": turn}, name=log.name)


def _channels(log: Trace, drive: Drive, simulated: dict[str, Array]) -> tuple[str, ...]:
    found = [c for c in COMPARED if log.has(c) and c in simulated]
    if drive.imposed and "speed_mps" in found:
        found.remove("speed_mps")
    if drive.turns_as_measured:
        found = [c for c in found if c not in LATERAL or c == "accel_y_mps2"]
        if not log.has("yaw_rate_radps"):
            found = [c for c in found if c not in LATERAL]
    if not found:
        has_now = ", ".join(n for n in log.columns if n != "time_s")
        raise InputError(
            f"{log.name}: nothing to compare: the model is driven by all that it holds",
            f"there are {has_now}",
        )
    return tuple(found)


def _powers(simulated: dict[str, Array]) -> list[str]:
    return [name for name in POWERS if name in simulated]


def _kinds(
    log: Trace, drive: Drive, simulated: dict[str, Array], scale: Scale
) -> NDArray[np.intp]:
    speed = drive.measured.speed
    if not np.isfinite(speed).any():
        speed = simulated["speed_mps"]
    yaw = drive.measured.yaw_rate if log.has("yaw_rate_radps") else None
    turn = simulated["yaw_rate_radps"] if yaw is None else yaw
    return labels(drive.time, speed, turn, simulated["motor_torque_nm"], scale)


def _compared(
    log: Trace,
    drive: Drive,
    simulated: dict[str, Array],
    channels: Sequence[str],
    scale: Scale,
) -> dict[str, Array]:
    """Return measured less simulated per channel, NaN where it is not judged."""
    speed = np.where(
        np.isfinite(drive.measured.speed), drive.measured.speed, simulated["speed_mps"]
    )
    moves = speed > scale.slow
    held = stands(speed, scale) if drive.imposed else np.zeros(len(speed), bool)
    out = {}
    for name in channels:
        e = log[name] - simulated[name]
        e[0] = np.nan  # a mean over the time before the first row is not known
        if name in LATERAL:
            e = np.where(moves, e, np.nan)
        if name in HELD:
            e = np.where(held, np.nan, e)
        if np.isfinite(e).any():
            out[name] = e
    return out


def _parted(
    log: Trace,
    simulated: dict[str, Array],
    compared: dict[str, Array],
    noises: dict[str, Noise],
    moved: Tolerances,
    memory: int,
) -> tuple[list[ChannelGap], tuple[Window, ...]]:
    """Return by how much each channel parts, the farthest first, and when."""
    gaps, sizes = [], {}
    for name, e in compared.items():
        noise, band = noises[name], moved.band(name, len(log))
        ok = np.isfinite(e)
        gaps.append(
            channel_gap(name, log[name], simulated[name], ok, noise=noise, band=band)
        )
        least = FINEST * float(np.sqrt(np.mean(log[name][ok] ** 2)))
        size = np.maximum(np.hypot(noise[0], band), least)
        sizes[name] = np.broadcast_to(size, len(log))
    limit = alarm_limit(compared, sizes, moved, memory)
    when = tuple(windows(log["time_s"], compared, sizes, memory, limit))
    return strongest_first(gaps, frozenset(w.channel for w in when)), when


def _notes(
    logged: Trace,
    log: Trace,
    drive: Drive,
    energy: EnergyGap,
    gaps: Sequence[ChannelGap],
    moved: Tolerances,
    vehicle: Vehicle,
) -> tuple[str, ...]:
    notes, turns = [], log.columns.get("yaw_rate_radps", np.zeros(1))
    if not has_commands(log, vehicle):
        notes.append("no commands that the controller obeys: the motion is imposed")
    if not drive.steered and np.nanmax(np.abs(turns), initial=0.0) > 0.0:
        notes.append("no steering is told: the model turns as yaw_rate_radps shows")
    notes += not_logged(log, energy)
    guessed = [g.channel for g in gaps if g.noise_from == "guess"]
    if guessed:
        of = f" of {', '.join(guessed)}" if len(guessed) < len(gaps) else ""
        notes.append(
            f"noise{of} is guessed from the log; --repeats or the vehicle file's "
            "[sensors] would tell it"
        )
    if any(g.noise_from == "charge" for g in gaps):
        notes.append(
            "the battery's power is the mean over stretches of the log, from its state "
            "of charge and the energy that the file states"
        )
    if "yaw_rate_radps" in log and "yaw_rate_radps" not in logged:
        notes.append("no gyro: yaw_rate_radps is the rate at which the heading turns")
    if not moved.keys:
        notes.append(f"{vehicle.name} states no sd: u_val holds noise alone")
    elif len(moved.rows) < len(log):
        notes.append("a long log: the tolerances were tried on stretches of it")
    return tuple(notes)


def not_logged(log: Trace, energy: EnergyGap) -> list[str]:
    """Return what a person should know of what could not be compared."""
    notes = []
    half = {"battery_current_a", "battery_voltage_v"} & set(log.columns)
    lone = f"of the battery only {half.pop()} is of use" if len(half) == 1 else ""
    if energy.at == "shaft":
        why = lone or "the battery was not logged"
        notes.append(f"{why}: the energy is that of the shaft")
    elif not energy.at:
        why = lone or "neither battery nor shaft was logged"
        notes.append(f"{why}: there is no energy gap")
    if "speed_mps" not in log:
        notes.append("there is no usable speed_mps: the model's own stands for it")
    return notes
