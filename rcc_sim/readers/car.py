"""What a log's own units need to know of the car: wheel, gear and poles."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from math import prod
from typing import NamedTuple, Protocol

import numpy as np

from rcc_sim.errors import InputError
from rcc_sim.readers.log import Log, Mapped
from rcc_sim.trace import Trace


class HasValue(Protocol):
    """A figure of a vehicle file."""

    @property
    def value(self) -> float:
        """The number to calculate with."""
        ...


class HasPoles(Protocol):
    """The motor's table of a vehicle file."""

    @property
    def poles(self) -> int | None:
        """Number of poles, not of pole pairs; None where not stated."""
        ...


class Car(Protocol):
    """A vehicle, as far as logs need it; `definitions.vehicle.Vehicle` is one."""

    @property
    def where(self) -> str:
        """What errors call it."""
        ...

    @property
    def motor(self) -> HasPoles:
        """Its motor's table."""
        ...

    def figure(self, key: str, why: str = "") -> HasValue:
        """Return the figure of a dotted key, or raise."""
        ...


class Ratios(NamedTuple):
    """Between road, motor and electrical speed.

    Attributes
    ----------
    radps_per_mps : float
        Motor speed at a road speed, N_d / r_w. [rad/m]
    erpm_per_radps : float
        Electrical turns a minute at a motor speed, 60 N_p / (4 π). [ERPM s/rad]
    """

    radps_per_mps: float
    erpm_per_radps: float


def ratios(vehicle: Car) -> Ratios:
    """Ratios of a vehicle's drivetrain.

    Raises
    ------
    InputError
        If the file does not state gear, wheel or poles.
    """
    return Ratios(radps_per_mps(vehicle), erpm_per_radps(vehicle))


def radps_per_mps(vehicle: Car) -> float:
    """Return motor speed over road speed, N_d / r_w; raise where not stated. [rad/m]"""
    why = "turns road speed into the motor's"
    gear = vehicle.figure("drivetrain.gear_ratio", why).value
    return gear / vehicle.figure("tyres.radius_m", why).value


def erpm_per_radps(vehicle: Car) -> float:
    """Return electrical turns a minute over motor speed; raise without poles."""
    poles = vehicle.motor.poles
    if poles is None:
        raise InputError(
            f"{vehicle.where}: motor.poles: missing (turns motor speed into ERPM)",
            "number of poles, not of pole pairs: an even number",
        )
    return poles / 2 * 60 / (2 * np.pi)


def with_vehicle(log: Log, vehicle: Car) -> Log:
    r"""Add what the motor's speed tells of a vehicle: no column is replaced.

    .. math:: \omega = 2\pi\,\mathrm{ERPM} / (60 N_p / 2), \quad
              v = \omega r_w / N_d

    Parameters
    ----------
    log : Log
        As read.
    vehicle : Car
        Whose log it is.

    Returns
    -------
    log : Log
        With ``motor_speed_radps``, ``speed_mps`` and ``speed_ref_mps`` where the log
        lacks them and has what they follow from; a motor's speed beside a road's only
        where the file states the poles.

    Raises
    ------
    InputError
        As in `ratios`, if any of them is to be added.
    """
    columns = dict(log.trace.columns)
    mapped = list(log.mapped)
    beside = "speed_mps" in columns and vehicle.motor.poles is None
    steps: tuple[tuple[str, str, Callable[[Car], float]], ...] = (
        ("motor_speed_radps", "motor_speed_erpm", erpm_per_radps),
        ("speed_mps", "motor_speed_radps", radps_per_mps),
        ("speed_ref_mps", "motor_speed_ref_erpm", lambda car: prod(ratios(car))),
    )
    for ours, source, by in steps:
        if ours in columns or source not in columns:
            continue
        if ours == "motor_speed_radps" and beside:
            continue
        factor = 1 / by(vehicle)
        columns[ours] = columns[source] * factor
        mapped.append(Mapped(ours, source, factor))
    trace = Trace(columns, name=log.trace.name)
    return replace(log, trace=trace, mapped=tuple(mapped))
