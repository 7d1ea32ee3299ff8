"""What a log shows that a driver and a vehicle can do."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rcc_sim.channel import moving_mean, rows_in
from rcc_sim.diagnose.residuals.problem import Problem
from rcc_sim.diagnose.residuals.shapes import LATERAL
from rcc_sim.simulate.drive import COMMANDS
from rcc_sim.units import G

CORNERING = 0.3 * G
"""Lateral acceleration that a run may ask for where the log does not corner. [m/s²]"""

STEER, CORNERED = 0.01, 0.5
"""Steering angle [rad] and lateral acceleration [m/s²] from which a log does corner."""


LASTS = 0.5
"""Time that a driver holds an acceleration, at least: what is faster shakes. [s]"""

GRIP = 1.0
"""Friction of tyres of which none is stated."""


@dataclass(frozen=True)
class Limits:
    """What the driver and the vehicle were seen to do in a log.

    Parameters
    ----------
    top : float
        Largest speed. [m/s]
    command : float
        Largest command: speed [m/s], or throttle [1].
    steer : float
        Largest steering angle; 0 where none can be commanded or seen. [rad]
    accel, lateral : float
        Largest acceleration along and across. [m/s²]
    still, seconds : float
        Time to stand at the ends, longest coast. [s]
    coasts : bool
        Whether letting go of the command leaves the wheels free.
    wheelbase : float
        [m]
    """

    top: float
    command: float
    steer: float
    accel: float
    lateral: float
    still: float
    seconds: float
    coasts: bool
    wheelbase: float

    def angle(self, speed: float) -> float:
        """Largest steering angle at a speed. [rad]"""
        return min(self.steer, self.lateral * self.wheelbase / max(speed, 0.1) ** 2)


def level_column(problem: Problem) -> str:
    """Return the column by which a drive like that of a log is made."""
    if problem.drive.imposed:
        return "speed_mps"
    return COMMANDS.get(problem.vehicle.mode, "speed_mps")


def limits_of(problem: Problem) -> Limits:
    """Return what a log shows that can be driven."""
    log, drive, vehicle = problem.log, problem.drive, problem.vehicle
    speed = problem.driven_speed
    top = float(speed.max()) or 1.0
    friction = vehicle.tyres.friction_coefficient
    grip = G * (friction.value if friction else GRIP)
    command = top
    if level_column(problem) == "throttle":
        command = float(np.nanmax(drive.commands.throttle)) or 1.0
    sees = any(c in problem.channels for c in LATERAL)
    steer = float(np.abs(drive.commands.steer).max()) if drive.steered else 0.0
    cornered = 0.0
    if "accel_y_mps2" in log:
        across = moving_mean(log["accel_y_mps2"], rows_in(log["time_s"], LASTS))
        cornered = min(float(np.quantile(np.abs(across), 0.99)), grip)
    lateral = cornered if cornered > CORNERED and steer > STEER else CORNERING
    if drive.steered and sees and steer < STEER:  # it went straight: a gentle corner
        steer = 4 * CORNERING * vehicle.wheelbase / top**2
    calm = moving_mean(speed, rows_in(drive.time, LASTS))
    rate = np.gradient(calm, drive.time)
    accel = min(float(np.quantile(np.abs(rate), 0.95)), grip)
    regen = vehicle.effects.get("regeneration_limit", {})
    freely = any(getattr(f, "value", 1.0) == 0.0 for f in regen.values())
    duration = float(drive.time[-1] - drive.time[0])
    return Limits(
        top=top,
        command=command,
        steer=min(steer, 0.5) if sees else 0.0,
        accel=max(accel, 0.02 * G),
        lateral=lateral,
        still=2.0,
        seconds=max(min(duration, 300.0), 30.0),
        coasts=drive.imposed or vehicle.mode != "speed" or freely,
        wheelbase=vehicle.wheelbase,
    )
