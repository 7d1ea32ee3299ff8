"""One log and one vehicle: what the model says of each channel, for any figures."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from math import inf

import numpy as np
from numpy.typing import NDArray

from rcc_sim.analyse.charge import Charge
from rcc_sim.analyse.gap_regimes import HELD, Scale, stands
from rcc_sim.analyse.heading import TURN_RATE, turn_rate
from rcc_sim.analyse.logcheck.rest import standing as surely_standing
from rcc_sim.channel import interval_of, moving_mean, rows_in
from rcc_sim.definitions.kernel import forgetting_time, loop_stiffness
from rcc_sim.definitions.vehicle import Vehicle
from rcc_sim.diagnose.residuals.beside_motor import BesideMotor, beside_motor
from rcc_sim.diagnose.residuals.lateness import clear_delay, likeliest_delay
from rcc_sim.diagnose.residuals.losses import load_of
from rcc_sim.diagnose.residuals.shapes import LATERAL, TORQUE, Shape, shapes_of
from rcc_sim.diagnose.residuals.terminals import (
    CURRENT,
    RESISTANCE,
    VOLTAGE,
    compared,
    flowed,
    metered,
    steady_rows,
    tells,
)
from rcc_sim.physics.effects import neutral_of
from rcc_sim.simulate.drive import Drive, is_surveyed
from rcc_sim.simulate.replay import FREE, RECALLS, Recalls, replay
from rcc_sim.trace import Trace, integral_of

Array = NDArray[np.float64]

CHANNELS = (
    "speed_mps",
    "yaw_rate_radps",
    TURN_RATE,
    "accel_x_mps2",
    "accel_y_mps2",
    "motor_current_a",
    "motor_torque_nm",
    "battery_voltage_v",
    "battery_current_a",
    "battery_power_w",
)
"""Columns by which model and log are compared, where the log has them."""

WHEELS, WHEELS_SD = "wheels", 0.5
"""Figure of a log whose wheels turn off the ground: their inertia, of what is usual;
and by how much it may be off."""

SPEED_OFFSET = "speed_offset"
"""Figure of a log: what its speed sensor reads too much throughout. [m/s]"""

SINCE_BRAKING, SINCE_STANDING = "since_braking_s", "since_standing_s"

BRAKED, SLIGHT = 1.0, 0.02
"""Time over which a torque that slows the car is a mean, and share of the largest that
it must be: less is noise of the speed. Of the top speed: at less it stands. [s]"""

MIN_ROWS = 30
"""Rows of a channel by which the model can be judged, at least."""


@dataclass(frozen=True)
class Problem:
    """A log to be explained by a vehicle.

    Parameters
    ----------
    vehicle : Vehicle
        The nominal model.
    log : Trace
        What the sensors saw.
    drive : Drive
        What of the log drives the model.
    charge : Charge or None
        Stretches of the drive, one each row of the log, where power is known from the
        battery's charge alone.
    bridged : ndarray of bool or None
        Rows of such a drive at which no speed was logged.
    unzeroed : tuple of str
        Columns whose offset is no tolerance: it was stated, and is withheld.
    turned : ndarray or None
        Yaw rate by a heading that was measured, by which the gyro is judged. [rad/s]
    recalls : tuple of float
        How the model's speed and its loop's integral come to the log's (`RECALLS`).
    noise : dict
        Channel -> what repeats of the drive do not share of its residual, where known.
    """

    vehicle: Vehicle
    log: Trace
    drive: Drive
    charge: Charge | None = None
    bridged: NDArray[np.bool_] | None = None
    unzeroed: tuple[str, ...] = ()
    turned: Array | None = None
    recalls: Recalls = RECALLS
    noise: Mapping[str, Array] = field(default_factory=dict)

    @cached_property
    def channels(self) -> tuple[str, ...]:
        """Columns compared."""
        found = [
            c
            for c in CHANNELS
            if c in self.log
            and c in self.nominal
            and self.known(c).sum() >= MIN_ROWS
            and np.nanstd(self.log[c]) > 0
        ]
        if self.drive.imposed and "speed_mps" in found:
            found.remove("speed_mps")
        found = compared(found, self.vehicle, by_charge=self.charge is not None)
        if "motor_current_a" in found and TORQUE in found:
            found.remove(TORQUE)
        if not self.drive.steered:
            found = [c for c in found if c not in LATERAL]
        return tuple(found)

    @cached_property
    def row(self) -> float:
        """Usual time between two rows. [s]"""
        return interval_of(self.log["time_s"])

    @cached_property
    def stiffness(self) -> float:
        """Rate at which the stated loop holds the speed: no fit may change it. [1/s]

        A loop that is sought softer would let the speed go where nothing holds it.
        """
        return loop_stiffness(self.vehicle)

    @cached_property
    def nominal(self) -> dict[str, Array]:
        """What the nominal model predicts."""
        return self.predict({})

    def predict(
        self,
        figures: dict[str, float],
        coarse: bool = False,
        only: Collection[str] = (),
    ) -> dict[str, Array]:
        """Columns that the model predicts with some figures changed."""
        return self.driven(figures, self.recalls, coarse, only)

    def driven(
        self,
        figures: dict[str, float],
        recalls: Recalls = FREE,
        coarse: bool = False,
        only: Collection[str] = (),
    ) -> dict[str, Array]:
        """Columns that it predicts, in a free run by default; all, or some ``only``."""
        own = {k: figures[k] for k in (WHEELS, SPEED_OFFSET) if k in figures}
        settings = {k: x for k, x in figures.items() if k not in own}
        vehicle = self.vehicle.changed(settings=settings) if settings else self.vehicle
        out = replay(
            vehicle,
            self.drive,
            recalls,
            stiffness=self.stiffness,
            coarse=coarse,
            turned=self.turned,
            wheels=own.get(WHEELS, 1.0),
            speed_offset=own.get(SPEED_OFFSET, 0.0),
            only=only,
        )
        if TURN_RATE in self.log:
            out[TURN_RATE] = turn_rate(out["time_s"], out["yaw_rad"])
        if self.charge is None:
            return out
        out = {name: self.charge.means(x) for name, x in out.items()}
        # the log's power was worked out with the energy that the file states
        stated, true = self.vehicle.battery_energy, vehicle.battery_energy
        if stated and true and "battery_power_w" in out:
            out["battery_power_w"] *= stated / true
        return out | {"time_s": self.log["time_s"]}

    def residuals(self, figures: dict[str, float], coarse: bool = False) -> list[Array]:
        """Measured minus predicted, per channel.

        A voltage by the current that flowed, u_0 - R i, where both were measured: the
        model's own errs with the drive, and would make a resistance look smaller.
        """
        out = self.nominal
        if figures or coarse:
            out = self.predict(figures, coarse, {*self.channels, CURRENT})
        left = {c: self.log[c] - out[c] for c in self.channels}
        if VOLTAGE in left and CURRENT in self.log:
            ohm = figures.get(RESISTANCE, self.stated(RESISTANCE))
            beside = self.log[CURRENT] - out[CURRENT]
            left[VOLTAGE] += ohm * flowed(beside, *self._metered)
        return self.beside([*left.values()])

    @cached_property
    def beside(self) -> Callable[[Sequence[Array]], list[Array]]:
        """What tells tracks apart: the battery's beside what the motor's asks of it."""
        return self.beside_in(self.channels)

    def beside_in(
        self, channels: Sequence[str]
    ) -> Callable[[Sequence[Array]], list[Array]]:
        """Return what tells the tracks of some channels apart so."""
        known = channels, self.log, self.nominal, self.vehicle
        return (None if self.torqued else beside_motor(*known)) or list

    @cached_property
    def _metered(self) -> tuple[float, int]:
        return metered(self.log, self.nominal[CURRENT]), steady_rows(self.log)

    def stated(self, key: str) -> float:
        """Return what the vehicle file says of a figure, or what it is without."""
        figure = self.vehicle.figures().get(key)
        return figure.value if figure else neutral_of(key, self.vehicle.known)

    @cached_property
    def shapes(self) -> dict[str, Shape]:
        """What may be a little off in the log without being a cause."""
        return shapes_of(self)

    @cached_property
    def delay(self) -> tuple[float, float]:
        """Delay [s] of the battery's readings that suits best, and what that leaves."""
        return likeliest_delay(self)

    @property
    def late(self) -> float:
        """Clear delay of the battery's readings beside an imposed drive, or 0. [s]"""
        return max(clear_delay(self), 0.0)

    def by_true_torque(self, gain: float) -> Problem:
        """Return the log with its measured torque, which reads so much too much."""
        torque = self.drive.measured.torque / (1 + gain)
        return replace(self, drive=self.drive.known_as(torque=torque)) if gain else self

    def by_felt_road(self, gain: float) -> Problem:
        """Return the log on the road that was felt: of its slopes so much is not there.

        At 1 the road is level, at -1 twice as steep as its altimeter says.
        """
        if not gain:
            return self
        distance, slope = self.drive.road
        return replace(
            self, drive=replace(self.drive, road=(distance, (1 - gain) * slope))
        )

    @cached_property
    def speed(self) -> Array:
        """Speed at the rows: measured, or the nominal model's. [m/s]"""
        speed = self.driven_speed
        return speed if self.charge is None else self.charge.means(speed)

    def coordinate(self, name: str) -> Array:
        """Return what a profile may run along: distance, speed, a column of the log."""
        if name == "distance_m":
            return self.distance
        if name == SINCE_BRAKING:
            return self.since(self.braking)
        if name == SINCE_STANDING:
            return self.since(self.standing)
        if name == TORQUE:
            return load_of(self)
        if name == "speed_mps" and not self.drive.imposed:
            # the model's: a coordinate must not know a reading's noise
            return np.abs(np.nan_to_num(self.nominal["speed_mps"]))
        return self.speed if name == "speed_mps" else np.nan_to_num(self.log[name])

    @cached_property
    def distance(self) -> Array:
        """Distance from the start of the log. [m]"""
        distance = integral_of(self.drive.time, self.driven_speed)
        return distance if self.charge is None else self.charge.means(distance)

    @cached_property
    def braking(self) -> NDArray[np.bool_]:
        """Rows at which the nominal model's motor slows it."""
        torque = np.nan_to_num(self.nominal[TORQUE])
        mean = moving_mean(torque, rows_in(self.log["time_s"], BRAKED))
        return np.asarray(mean < -SLIGHT * np.abs(torque).max())

    @cached_property
    def standing(self) -> NDArray[np.bool_]:
        """Rows at which the vehicle stands again."""
        stands = self.speed < SLIGHT * self.speed.max()
        return np.asarray(stands & np.logical_or.accumulate(~stands))

    @cached_property
    def at_rest(self) -> NDArray[np.bool_]:
        """Rows at which the vehicle surely stands."""
        return surely_standing(self.log["time_s"], self.log.columns)

    def since(self, event: NDArray[np.bool_]) -> Array:
        """Logarithm of 1 and the seconds since some rows; long, before the first."""
        time = self.log["time_s"]
        last = np.maximum.accumulate(np.where(event, time, -inf))
        since: Array = np.log1p(np.minimum(time - last, time[-1] - time[0]))
        return since

    @cached_property
    def unsure(self) -> list[Array]:
        """Share of each stretch in which the speed was not logged, if any was not."""
        if self.charge is None or self.bridged is None:
            return []
        return [self.charge.means(self.bridged.astype(float))]

    @property
    def driven_speed(self) -> Array:
        """Speed at the drive's rows: measured, else the nominal model's, else 0."""
        speed = np.abs(self.drive.measured.speed)
        if not (self.drive.imposed or np.isfinite(speed).all()):
            speed = np.where(np.isfinite(speed), speed, self.nominal["speed_mps"])
        return np.where(np.isfinite(speed), speed, 0.0)

    @cached_property
    def judged(self) -> list[NDArray[np.bool_]]:
        """Rows of each channel on which the model may be judged."""
        rows = [self.known(c) & np.isfinite(self.nominal[c]) for c in self.channels]
        if isinstance(self.beside, BesideMotor):
            rows[self.beside.battery] &= self.beside.known
        return rows

    def known(self, channel: str) -> NDArray[np.bool_]:
        """Rows at which the log tells of a channel what a model could say."""
        ok = np.isfinite(self.log[channel])
        ok[0] = False
        if channel == "speed_mps":
            ok &= ~self.parked
        if channel == VOLTAGE:
            ok &= tells(self.log[channel])
        if channel in HELD and self.drive.imposed:
            ok &= ~stands(self.speed, Scale.of(self.vehicle))
        return ok & self._rolling if channel in LATERAL else ok

    @cached_property
    def _rolling(self) -> NDArray[np.bool_]:
        """Rows at which it rolls, and turns by nothing that came before the log."""
        rolls, time = self.speed > self.slow, self.log["time_s"]
        begins = time - time[0] < forgetting_time(self.vehicle, float(self.speed[0]))
        return np.asarray(rolls & ~(rolls[0] & begins))

    @property
    def slow(self) -> float:
        """Speed below which cornering is not judged. [m/s]"""
        return Scale.of(self.vehicle).slow

    @property
    def parked(self) -> NDArray[np.bool_]:
        """Rows at which an open-loop car stands and nothing asks it to move.

        An encoder tells nothing there, and is exact as it never is on the way.
        """
        throttle = self.log.columns.get("throttle")
        if self.drive.imposed or throttle is None:
            return np.zeros(len(self.log), dtype=bool)
        return np.asarray((throttle == 0) & (self.log["speed_mps"] == 0))

    @property
    def torqued(self) -> bool:
        """Whether power follows from a torque that was measured."""
        torque = self.drive.measured.torque
        return self.drive.imposed and bool(np.isfinite(torque).any())

    @property
    def surveyed(self) -> bool:
        """Whether the log tells the slope of the road."""
        return is_surveyed(self.log)

    def on_road(self, distance: Array, slope: Array) -> Problem:
        """The same drive with that slope on top of its road's, over distance."""
        known, there = self.drive.road
        at = np.union1d(known, distance)
        total = np.interp(at, known, there) + np.interp(at, distance, slope)
        return replace(self, drive=replace(self.drive, road=(at, total)))

    def with_load(self, power: Array) -> Problem:
        """The same drive with an auxiliary power [W] at each row on top."""
        aux = self.drive.commands.aux + self._at_rows(power)
        return replace(self, drive=self.drive.commanded(aux=aux))

    def in_wind(self, speed: Array) -> Problem:
        """The same drive with a headwind [m/s] at each row on top."""
        wind = self.drive.commands.wind + self._at_rows(speed)
        return replace(self, drive=self.drive.commanded(wind=wind))

    def _at_rows(self, values: Array) -> Array:
        """Values at the log's rows, at those of its drive."""
        if self.charge is None:
            return values
        return np.interp(self.charge.time, self.log["time_s"], values)
