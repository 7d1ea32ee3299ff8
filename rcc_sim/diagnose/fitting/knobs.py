"""Figures that a fit may move, and how far each may be off beforehand."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from math import exp, inf

import numpy as np
from numpy.typing import NDArray

from rcc_sim.analyse.offsets import offset_sd
from rcc_sim.definitions.vehicle import Vehicle
from rcc_sim.diagnose.residuals.problem import SPEED_OFFSET, WHEELS, WHEELS_SD, Problem
from rcc_sim.diagnose.residuals.shapes import POLLED, SCALE
from rcc_sim.diagnose.residuals.sizes import tells_slip

Array = NDArray[np.float64]

CURRENT_LOOP_LAG = 0.003
"""Lag that any current loop may have; bandwidths are 50 Hz to some kHz. [s]"""

LEAST = 0.2
"""Share of what is stated below which no mass, length or stiffness is."""

RADIUS = "effects.wheel_radius.scale"
YAW_INERTIA = "body.yaw_inertia_kgm2"
SLIP = "effects.longitudinal_slip.stiffness_n"

BIAS = "bias."

OWN = "own."

MOST_FACTOR = 2.0
"""Largest logarithm of a factor by which a step moves a figure."""

NEARBY = 1.0
"""Widest step of a finite difference, in sds of the figure with all others held."""


FINEST = 1e-4
"""Share of its first step below which that of a finite difference does not narrow:
where the model jumps, as at a launch a row sooner, any step tells more than a wider."""


@dataclass(frozen=True)
class Knob:
    """A figure that a fit may move.

    Parameters
    ----------
    key : str
        Dotted key of the vehicle file, ``own.LOG.KEY`` of one that holds in a log
        alone, or ``bias.LOG.COLUMN`` of a sensor.
    value : float
        Where it is expected.
    sd : float
        How far it may be off; infinite for what is to be found.
    low, high : float
        Its bounds.
    step : float
        Step of a finite difference.
    acts : str
        How the model changes as it moves: ``steps``, where a reference passes it at its
        rows, all at once; by whole ``rows``, within which nothing changes; as a
        ``factor``. Where two factors trade, it is their product that the logs tell, and
        a step along both of them must not leave it.
    finest : float
        Below which its step does not narrow; 0 until it has narrowed.
    """

    key: str
    value: float
    sd: float = inf
    low: float = -inf
    high: float = inf
    step: float = 0.0
    acts: str = ""
    finest: float = 0.0

    @property
    def is_stepped(self) -> bool:
        """Whether the model changes in steps as the figure moves."""
        return self.acts == "steps"

    @property
    def by_factor(self) -> bool:
        """Whether it moves by factors."""
        return self.acts == "factor"

    @property
    def stride(self) -> float:
        """Step of a finite difference."""
        if self.step:
            return self.step
        return 0.5 * self.sd if self.sd < inf else 1e-3 * (abs(self.value) or 1.0)

    def finer(self, sd: float) -> Knob:
        """Return it with a step no wider than so many sds of what the logs tell.

        Figures that trade are told from each other by what their signals have left of
        each other: by a per cent where one alone would gain thousands of nats. Signals
        over a step that bends them by more make such a valley look closed.
        """
        if self.acts == "rows":
            return self
        finest = self.finest or FINEST * self.stride
        step = min(self.stride, max(NEARBY * sd, finest))
        return replace(self, step=step, finest=finest)

    def moved(self, value: float, by: float) -> float:
        """Return a value after a step, within the bounds."""
        if self.by_factor and value > 0:
            return self.within(value * exp(min(by / value, MOST_FACTOR)))
        return self.within(value + by)

    def within(self, value: float) -> float:
        """Return a value, or the bound beyond which it lies."""
        return min(max(value, self.low), self.high)

    def inward(self, value: float, wider: float = 1.0) -> float:
        """Step of a finite difference from a value that does not leave the bounds."""
        step, up, down = wider * self.stride, self.high - value, value - self.low
        if step <= up:
            return step
        return -min(step, down) if down >= up else up


def tolerance_knobs(problems: Sequence[Problem]) -> list[Knob]:
    """The figures of the vehicle file that state how far they may be off."""
    problem, knobs = problems[0], []
    for key, figure in problem.vehicle.figures().items():
        if key == YAW_INERTIA and not any(p.drive.steered for p in problems):
            continue  # its torque is that of the yaw rate's noise
        if key == SLIP and not any(is_felt(p, figure.value) for p in problems):
            continue  # what it does is less than the drive is smeared by
        sd = figure.tolerance
        if sd > 0 and key == "tyres.radius_m":
            # what was logged came about by the file's radius: the true one differs
            if RADIUS not in problem.vehicle.figures():
                knobs.append(Knob(RADIUS, 1.0, sd / figure.value, low=0.5, high=2.0))
        elif sd > 0:
            low, high = bounds_of(problem, key)
            acts = acts_of(problem.vehicle, key)
            knobs.append(Knob(key, figure.value, sd, low, high, acts=acts))
    return knobs


def is_felt(problem: Problem, stiffness: float) -> bool:
    """Tell whether a stated slip stiffness [N] may be a little off in a log.

    When it acts is felt in fast rows alone; what it costs, F² v / C, in slow ones too
    whose speed is not smoothed.
    """
    exact = problem.row >= POLLED and problem.drive.smear == 0
    return exact or tells_slip(problem, stiffness)


def acts_of(vehicle: Vehicle, key: str) -> str:
    """Return how the model changes as a figure of a vehicle file moves."""
    table, name, *rest = key.split(".")
    if table == "effects":
        return vehicle.known[name].param(rest[0]).acts
    params = (p for effect in vehicle.known.values() for p in effect.params)
    factors = {p.sought.same_as for p in params if p.is_factor}
    return "factor" * (key in factors)


def bounds_of(problem: Problem, key: str) -> tuple[float, float]:
    """Least and most that a figure may be: an effect's own; else a fifth of the stated.

    A loss may be nil; a mass may not.
    """
    if key.startswith("effects."):
        low, high = problem.vehicle.effect_bounds(key)
        return low, max(high, problem.stated(key))
    value = problem.vehicle.figures()[key].value
    return (LEAST * value if value > 0 else -inf), inf


def bias_knobs(problem: Problem, log: int = 0) -> list[Knob]:
    """An offset for each sensor but those that count, charge; and speed, which drives.

    Nor for one whose offset was withheld: that is what is to be found. And all else
    that may be a little off in a log.
    """
    knobs = []
    for c in problem.channels:
        if c in problem.unzeroed:
            continue
        sd = power_bias(problem) if c == "battery_power_w" else None
        sd = offset_sd(problem.log, problem.vehicle, c) if sd is None else sd
        counted = c == "speed_mps" or (c == "battery_power_w" and problem.charge)
        if not counted and sd > 0:
            knobs.append(Knob(bias_key(log, c), 0.0, sd))
    off = problem.shapes.items()
    knobs += [Knob(bias_key(log, name), 0.0, shape.sd) for name, shape in off]
    return knobs


def power_bias(problem: Problem) -> float | None:
    """Return the offset of a power that is voltage times current, where they tell. [W]

    None where the file tells the power's own, or of neither meter an offset or a noise.
    """
    parts = ("battery_voltage_v", "battery_current_a")
    log, vehicle = problem.log, problem.vehicle

    def is_told(column: str) -> bool:
        told = vehicle.bias_sd(column), vehicle.noise_sd(column)
        return any(sd is not None for sd in told)

    if is_told("battery_power_w") or not any(map(is_told, parts)):
        return None
    if not all(c in log for c in parts):
        return None
    of_voltage, of_current = (offset_sd(log, vehicle, c) for c in parts)
    voltage, current = (float(np.nanmean(np.abs(log[c]))) for c in parts)
    return float(np.hypot(of_current * voltage, of_voltage * current))


def nuisance_knobs(problems: Sequence[Problem]) -> list[Knob]:
    """Everything that may be a little off without being a cause."""
    knobs = tolerance_knobs(problems)
    for i, problem in enumerate(problems):
        knobs += bias_knobs(problem, i)
        if problem.drive.on_stand:
            knobs.append(Knob(own_key(i, WHEELS), 1.0, WHEELS_SD, low=LEAST))
        if stated := problem.vehicle.bias_sd("speed_mps"):
            knobs.append(Knob(own_key(i, SPEED_OFFSET), 0.0, stated))
    commanded = not all(p.drive.imposed for p in problems)
    if commanded and "motor_lag" not in problems[0].vehicle.effects:
        key = "effects.motor_lag.time_constant_s"
        lag = CURRENT_LOOP_LAG
        knobs.append(Knob(key, 0.0, lag, low=0.0, high=1.0, step=lag / 3))
    return knobs


def bias_key(log: int, column: str) -> str:
    """Key of the offset of a sensor in one of the logs."""
    return f"{BIAS}{log}.{column}"


def scale_key(log: int, column: str) -> str:
    """Key of the share by which a sensor reads too much in one of the logs."""
    return bias_key(log, column) + SCALE


def offsets_of(values: Mapping[str, float], log: int) -> dict[str, float]:
    """Return what is added to the channels of one log throughout, by name."""
    mine = bias_key(log, "")
    return {k.removeprefix(mine): x for k, x in values.items() if k.startswith(mine)}


def own_key(log: int, key: str) -> str:
    """Key of a figure that holds in one of the logs alone."""
    return f"{OWN}{log}.{key}"


def figures_of(values: Mapping[str, float], log: int | None = None) -> dict[str, float]:
    """Return the figures of the vehicle, in all logs or in one.

    The sensors' offsets are left out.
    """
    of_all = {k: x for k, x in values.items() if not k.startswith((BIAS, OWN))}
    own = f"{OWN}{log}."
    return of_all | {
        k.removeprefix(own): x for k, x in values.items() if k.startswith(own)
    }
